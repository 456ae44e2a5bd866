// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera.h"

namespace alidade::camera {

/// A camera and its name: that of its photo, or another one that its file gives.
struct NamedCamera {
  std::string name;
  Camera camera;
};

/// The cameras of a file, sorted by the bytes of their names; those of a trajectory in the order of the file.
struct CameraSet {
  std::vector<NamedCamera> cameras;
  std::vector<std::string> warnings;  ///< omissions and assumptions
};

struct CameraFileOptions {
  /// Image size and lens for trajectories, which have none. The pose is ignored.
  std::optional<Camera> lens;
  /// transforms.json: undo `applied_transform` and `applied_scale`, so that cameras are in the world before
  /// the conversion.
  bool original_world = false;
};

/// Reads an Alidade camera file, a COLMAP model (a folder with cameras and images, .bin or .txt),
/// transforms.json of nerfstudio and instant-ngp, OpenSfM's reconstruction.json (its first reconstruction),
/// openMVG's sfm_data.json, the photos of an E57 file, or a trajectory as text, distinguished by content.
/// Formats and conventions: docs/cameras.md. Poses become camera-to-world, pixel coordinates those of Camera.
/// Folds of lenses are not searched for: call check_camera() for the cameras that are used. Errors, with file
/// and location: unknown formats and models, missing parts, counts beyond the file's size, matrices that are
/// not rotations, focal lengths of 0, duplicate names, no camera. Cost: linear. Memory: a constant times the
/// file's size without its points.
CameraSet read_cameras(const std::filesystem::path& path, const CameraFileOptions& options = {});

/// Reads the cameras in the text of such a file; `name` is used in messages, and relative paths are relative
/// to its folder. Not for COLMAP models and E57 files.
CameraSet parse_cameras(std::string text, const std::filesystem::path& name,
                        const CameraFileOptions& options = {});

/// The camera called `name`: exactly, or if there is only one, the one whose file name without folder or
/// without folder and extension is `name`. `source` names the file in messages. Errors: none, or several.
const NamedCamera& camera_called(const CameraSet& set, const std::string& name, const std::string& source);

}  // namespace alidade::camera
