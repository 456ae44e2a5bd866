// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cloud/e57/e57_file.h"
#include "tools/console.h"

namespace alidade {

/// Whether a file begins as E57 files do. Errors: it cannot be read.
bool is_e57_file(const std::filesystem::path& file);

/// What `alidade info --json` tells about an E57 file beside what its points tell.
nlohmann::ordered_json e57_json(const E57File& file);

/// The same as lines for people; of more than ten scans or images the first ten, unless verbose.
std::vector<std::string> e57_lines(const E57File& file, Verbosity verbosity);

}  // namespace alidade
