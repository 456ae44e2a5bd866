// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace alidade {

/// What OpenImageIO has to say about a failure, in one line: its lines, without those that another one
/// repeats and says more of.
std::string image_trouble(const std::string& said);

/// Size of a picture's file in bytes. Errors: no such file, not a regular file, cannot be read.
std::uint64_t picture_file_size(const std::filesystem::path& file);

}  // namespace alidade
