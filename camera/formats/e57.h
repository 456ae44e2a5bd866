// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera.h"
#include "camera/camera_set.h"
#include "cloud/e57/e57_file.h"

namespace alidade::camera {

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
