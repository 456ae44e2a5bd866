// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "camera/camera_set.h"
#include "cloud/crs.h"
#include "extensions/photos/photo_visibility.h"
#include "jobs/camera_file.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/long_run.h"
#include "jobs/visibility/visibility_cloud.h"
#include "jobs/write_points.h"

namespace alidade::jobs {

/// Which photos see which points, and their footprints.
struct PhotosRequest : VisibilityRequest {
  CameraFileRequest cameras;
  std::filesystem::path photos;      ///< empty: those in the file of `cameras`
  std::filesystem::path footprints;  ///< empty: none
  bool colorize = false;
  double max_distance = std::numeric_limits<double>::infinity();
  std::optional<double> footprint_cell;
  CheckpointRequest checkpoint;
};

/// Declares all fields.
void add_photos_fields(const Fields& fields, PhotosRequest& request);

struct CheckedPhotos : PhotosRequest {
  camera::CameraSet camera_set;  ///< read from the file
};
using PhotosPlan = Plan<CheckedPhotos>;

/// Checks all that can be checked before a point or photo is read, and reads the cameras. Errors: unknown
/// output formats; colours without photos; files that cannot be read, replaced or written; those of
/// read_camera_file().
PhotosPlan plan(const PhotosRequest& request);

/// The cameras, in the cloud's reference system, and what their photos see.
struct PhotosResult {
  std::vector<camera::NamedCamera> cameras;
  Crs crs;
  visibility::PhotoVisibility seen;
};

/// The columns that the output has beside those of the cloud. `seen` must outlive them.
std::vector<ResultColumn> columns_of(const visibility::PhotoVisibility& seen);

/// Computes what the photos see, and writes the points and footprints where the request has files for them.
/// Errors: photos that are missing, of another size than their cameras, or cannot be read; those of
/// load_cloud_alone() and visibility::photo_visibility(); Cancelled. Memory: the cloud, its surfaces, and
/// that of visibility::photo_visibility().
PhotosResult run(const PhotosPlan& plan, Listener& listener);

}  // namespace alidade::jobs
