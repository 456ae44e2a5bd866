// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "cloud/point_cloud.h"
#include "jobs/listener.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/row_text.h"

// What jobs that write rows have in common.

namespace alidade::jobs {

/// The form of rows by the extension of the name. Errors: another extension.
visibility::RowForm chosen_row_form(const std::filesystem::path& file);

/// Loads GDAL if such files need it, so that a run fails before the work. Errors: those of geo::load_gdal().
void load_row_writer(const std::filesystem::path& file);

/// Writes rows, as the functions of the library do; false if a GeoJSON file got the coordinates of the cloud.
using WriteRows =
    std::function<bool(visibility::RowForm, const visibility::RowFileHead&, const visibility::ToLonLat&,
                       const std::filesystem::path& file, bool overwrite)>;

/// Writes the output of a job, if there is one, and warns if it has the coordinates of the cloud. Errors:
/// those of `write`.
void write_rows(const VisibilityRequest& request, const PointCloud& cloud, const WriteRows& write,
                Listener& listener);

/// Warns that a GeoJSON file has the coordinates of the cloud.
void warn_of_cloud_coordinates(const std::filesystem::path& file, Listener& listener);

}  // namespace alidade::jobs
