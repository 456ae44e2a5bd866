// SPDX-License-Identifier: MIT
#include "jobs/visibility/row_output.h"

#include <optional>

#include "base/error.h"
#include "geo/earth.h"
#include "geo/gdal_library.h"
#include "jobs/outputs.h"

namespace alidade::jobs {

visibility::RowForm chosen_row_form(const std::filesystem::path& file) {
  const std::optional<visibility::RowForm> form = visibility::row_form(file);
  if (form) return *form;
  throw file_error(file, "unknown output format", "the extension .csv, .json or .geojson");
}

void load_row_writer(const std::filesystem::path& file) {
  if (chosen_row_form(file) == visibility::RowForm::geojson) geo::load_gdal();
}

void write_rows(const VisibilityRequest& request, const PointCloud& cloud, const WriteRows& write,
                Listener& listener) {
  if (request.output.empty()) return;
  visibility::RowFileHead head{.command = request.command, .cloud_files = {}};
  for (const CloudFile& file : cloud.files) head.cloud_files.push_back(kept_name(file.path));
  visibility::ToLonLat to_lon_lat;
  if (!cloud.crs.empty()) {
    to_lon_lat = [&](std::span<const glm::dvec3> positions) { return geo::lon_lat(cloud.crs, positions); };
  }
  if (!write(chosen_row_form(request.output), head, to_lon_lat, request.output, request.overwrite))
    warn_of_cloud_coordinates(request.output, listener);
}

void warn_of_cloud_coordinates(const std::filesystem::path& file, Listener& listener) {
  listener.warn(
      file.string() +
      ": has the coordinates of the cloud, because its reference system is unknown; GeoJSON requires "
      "longitude and latitude");
}

}  // namespace alidade::jobs
