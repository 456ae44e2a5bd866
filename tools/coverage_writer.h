// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "visibility/points/placement.h"

namespace alidade {

/// write_coverage_picture() of visibility/points/placement.h, through the module (tools/load_module.h).
using CoverageWriter = void (*)(const Placement& placement, const std::filesystem::path& file,
                                bool overwrite);
CoverageWriter load_coverage_writer();

}  // namespace alidade
