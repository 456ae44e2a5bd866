// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

namespace alidade {

/// "800000000", "512M", "2G": bytes. Errors: CLI::ValidationError.
std::size_t parse_size(const std::string& text);

}  // namespace alidade
