// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera.h"
#include "cloud/e57/e57_file.h"

namespace alidade::camera {

/// A camera under the name of its photo, or another name that its file has for it.
struct NamedCamera {
  std::string name;
  Camera camera;
};

/// The cameras of a file in an order that does not change from reading to reading: by name, byte by byte;
/// those of a trajectory as they follow in the file.
struct CameraSet {
  std::vector<NamedCamera> cameras;
  std::vector<std::string> warnings;  ///< omissions and assumptions
};

struct CameraFileOptions {
  /// For trajectories, which lack them: image size and lens are taken from this camera, its pose is not used.
  std::optional<Camera> lens;
  /// transforms.json: undo `applied_transform` and `applied_scale`, so that cameras are in the world that
  /// was there before the conversion.
  bool original_world = false;
};

/// Reads our camera file, a COLMAP model (a folder with cameras and images, .bin or .txt), transforms.json of
/// nerfstudio and instant-ngp, OpenSfM's reconstruction.json (its first reconstruction), openMVG's
/// sfm_data.json, the photos of an E57 file, or a trajectory as text, distinguished by content. Formats and
/// conventions: docs/cameras.md. Poses become camera-to-world, pixels get our convention. Lenses are not
/// followed over their images: check_camera() does that for the cameras that are used. Errors, with file and
/// location: unknown formats and models, missing parts, counts beyond the file's size, matrices that are not
/// rotations, focal lengths of 0, duplicate names, no camera at all. Cost: linear. Memory: a constant times
/// the file's size without its points.
CameraSet read_cameras(const std::filesystem::path& path, const CameraFileOptions& options = {});

/// Reads the cameras in the text of such a file; `name` is used in messages, and relative paths are relative
/// to its folder. Not for COLMAP models and E57 files.
CameraSet parse_cameras(std::string text, const std::filesystem::path& name,
                        const CameraFileOptions& options = {});

/// The camera called `name`: exactly, or if there is only one, the one whose file name without folder or
/// without folder and extension is `name`. `source` names the file in messages. Errors: none, or several.
const NamedCamera& camera_called(const CameraSet& set, const std::string& name, const std::string& source);

/// The camera of a picture in an E57 file: pinhole pictures, whose axes are x right, y up and -z ahead, as
/// pinhole cameras; spherical ones, whose axes are x ahead, y left and z up and whose middle looks ahead, as
/// equirectangular cameras, which cover a circle without a gap if their pixels do to half a pixel. An image
/// without a pose is in the axes of the file. Empty for visual references, which have no camera, for
/// cylindrical pictures, which no lens describes, and for sizes and focal lengths that cameras cannot have.
std::optional<Camera> camera_of(const E57Image& image, const E57Picture& picture);

/// Whether a file is an E57 file, by its first bytes; false if it cannot be read.
bool is_e57(const std::filesystem::path& file);

/// A photo inside an E57 file.
struct E57Photo {
  NamedCamera camera;
  E57Picture picture;
};

/// The pictures of an E57 file that have a camera_of(), in the order of the file, under the names of their
/// images, or else their GUIDs or numbers; "_2" and so on make the names unique. `warnings` gets the number
/// of pictures without a camera, of photos without a pose, and of photos with a mask.
std::vector<E57Photo> e57_photos(const E57Document& document, std::vector<std::string>& warnings);

}  // namespace alidade::camera
