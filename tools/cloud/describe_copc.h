// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace alidade {

/// What `alidade info` tells about the octree of a COPC file: levels, nodes and spacing, or what is wrong
/// with it.
std::string copc_text(const std::filesystem::path& file);

}  // namespace alidade
