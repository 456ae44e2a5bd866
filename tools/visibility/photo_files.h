// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "camera/camera_set.h"

namespace alidade::tools {

/// The file of each camera's photo in a folder: under the camera's name with its folders, or without them; a name
/// without extension gets that of the usual formats of photos. Opens each. Errors: not a folder; a photo that is
/// missing, with the number of those that are not; one that cannot be read, or of another size than its camera.
std::vector<std::filesystem::path> find_photos(const std::filesystem::path& folder,
                                               std::span<const camera::NamedCamera> cameras);

}  // namespace alidade::tools
