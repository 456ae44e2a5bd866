// SPDX-License-Identifier: MIT
#include "tools/visibility/row_output.h"

#include "base/error.h"
#include "tools/image_module.h"

namespace alidade::tools {

visibility::RowForm chosen_row_form(const std::filesystem::path& file) {
  const std::optional<visibility::RowForm> form = visibility::row_form(file);
  if (form) return *form;
  throw file_error(file, "unknown output format", ".csv, .json or .geojson");
}

void load_row_writer(const std::filesystem::path& file) {
  if (chosen_row_form(file) == visibility::RowForm::geojson) image_module();
}

visibility::RowFileHead row_file_head(const CommandLine& command_line, const PointCloud& cloud) {
  visibility::RowFileHead head{.command = picture_command(command_line), .cloud_files = {}};
  for (const CloudFile& file : cloud.files) head.cloud_files.push_back(file.path.string());
  return head;
}

visibility::ToLonLat to_lon_lat_of(const Crs& crs) {
  if (crs.empty()) return {};
  return [crs](std::span<const glm::dvec3> positions) { return image_module().lon_lat(crs, positions); };
}

void warn_of_cloud_coordinates(const std::filesystem::path& file) {
  say_warning(file.string() +
              ": has the coordinates of the cloud, because its reference system is unknown; GeoJSON requires "
              "longitude and latitude");
}

}  // namespace alidade::tools
