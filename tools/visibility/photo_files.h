// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "camera/camera_set.h"
#include "image/read_image.h"

namespace alidade::tools {

/// Reads the photo of the camera of that index.
using PhotoReader = std::function<image::PhotoPixels(std::size_t photo)>;

/// Reads each camera's photo in a folder: the file with the camera's name, with its folders or without them;
/// a name without extension gets those of the usual formats of photos. Opens each photo. Errors: not a
/// folder; a photo is missing, with the number of those found; one that cannot be read, or of another size
/// than its camera.
PhotoReader photos_in_folder(const std::filesystem::path& folder,
                             std::span<const camera::NamedCamera> cameras);

/// Reads each camera's photo in the E57 file that the cameras are from. Opens each photo; the reader keeps
/// the file's XML. Errors: those of E57File; a photo that cannot be read, or of another size than its camera;
/// at any time, a damaged page.
PhotoReader photos_in_e57(const std::filesystem::path& file, std::span<const camera::NamedCamera> cameras);

}  // namespace alidade::tools
