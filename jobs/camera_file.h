// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
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

/// Declares --lens, whose help ends with `lens_default`, and --original-world.
void add_camera_reading(const Fields& fields, const std::string& lens_default,
                        std::filesystem::path& lens_file, bool& original_world);

/// Reads the cameras of a file, or those of them with these names, in the order of the names. Each has passed
/// check_camera(). Errors: those of read_cameras(), camera_called() and check_camera(); a camera named twice.
camera::CameraSet read_camera_file(const std::filesystem::path& file, const std::vector<std::string>& names,
                                   const camera::CameraFileOptions& options);

/// "'a.jpg', 'b.jpg'", of many the first ten and "...".
std::string some_names(std::span<const std::string> names);

}  // namespace alidade::jobs
