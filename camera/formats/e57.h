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

/// The camera of an image in an E57 file. Pinhole images, whose axes are x right, y up and -z ahead, have
/// pinhole cameras. Spherical images, whose axes are x ahead, y left and z up and whose middle is ahead, have
/// equirectangular cameras; these cover a circle without a gap if the pixels do so to half a pixel. An image
/// without a pose is in the axes of the file. Empty for visual references, which have no camera, for
/// cylindrical images, which no lens describes, and for sizes and focal lengths that cameras cannot have.
std::optional<Camera> camera_of(const E57Image& image, const E57Representation& representation);

/// Whether a file is an E57 file, by its first bytes; false if it cannot be read.
bool is_e57(const std::filesystem::path& file);

/// A photo inside an E57 file.
struct E57Photo {
  NamedCamera camera;
  E57Representation representation;
};

/// The images of an E57 file that have a camera_of(), in the order of the file. Their names are those in the
/// file, or else GUIDs or numbers; "_2" and so on make them unique. `warnings` gets the number of
/// representations without a camera, of photos without a pose, and of photos with a mask.
std::vector<E57Photo> e57_photos(const E57Document& document, std::vector<std::string>& warnings);

}  // namespace alidade::camera
