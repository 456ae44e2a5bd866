// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "cloud/point_cloud.h"
#include "tools/command.h"
#include "visibility/row_text.h"

// What commands that write rows have in common.

namespace alidade::tools {

/// By the extension of the name. Errors: none of them.
visibility::RowForm chosen_row_form(const std::filesystem::path& file);

/// Fails before the work if such a file cannot be written here. Errors: those of image_module().
void load_row_writer(const std::filesystem::path& file);

visibility::RowFileHead row_file_head(const CommandLine& command_line, const PointCloud& cloud);

/// Through the module, which is loaded when the function is first called. Empty for a cloud without a
/// reference system.
visibility::ToLonLat to_lon_lat_of(const Crs& crs);

/// That a GeoJSON file has the coordinates of the cloud.
void warn_of_cloud_coordinates(const std::filesystem::path& file);

}  // namespace alidade::tools
