// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "camera/camera_set.h"
#include "jobs/fields.h"

// What jobs with camera files have in common.

namespace alidade::jobs {

/// The files that --camera takes, for its help text.
inline const std::string k_camera_files =
    "Alidade's JSON, a COLMAP folder, transforms.json, reconstruction.json, sfm_data.json, an E57 file with "
    "photos, or a trajectory as CSV";

/// The cameras of a file.
struct CameraFileRequest {
  std::filesystem::path file;
  std::filesystem::path lens;      ///< camera file with the size and lens of a trajectory; empty: none
  std::vector<std::string> names;  ///< of the cameras; empty: all
  bool original_world = false;     ///< CameraFileOptions::original_world
};

/// Declares --lens, whose help ends with `lens_default`, and --original-world.
void add_camera_reading(const Fields& fields, const std::string& lens_default, CameraFileRequest& request);

/// Reads the cameras of the file, or those of them with the names, in the order of the names. Each has passed
/// check_camera(). `lens`: of trajectories, if the request has none. Errors: those of read_camera(),
/// read_cameras(), camera_called() and check_camera(); a camera named twice.
camera::CameraSet read_camera_file(const CameraFileRequest& request,
                                   std::optional<camera::Camera> lens = std::nullopt);

/// "'a.jpg', 'b.jpg'", of many the first ten and "...".
std::string some_names(std::span<const std::string> names);

}  // namespace alidade::jobs
