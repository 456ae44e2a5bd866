// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "cloud/e57/e57_file.h"
#include "renderer/scene.h"

namespace alidade {

/// The camera of a picture in an E57 file: pinhole pictures, whose axes are x right, y up and -z ahead, as
/// pinhole cameras; spherical ones, whose axes are x ahead, y left and z up and whose middle looks ahead, as
/// equirectangular cameras. An image without a pose stands in the axes of the file. Empty for visual
/// references, which have no camera, for cylindrical pictures, of which there is no lens, and for sizes and
/// focal lengths that cameras cannot have.
std::optional<Camera> camera_of(const E57Image& image, const E57Picture& picture);

}  // namespace alidade
