// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "cloud/e57/e57_file.h"

namespace alidade::camera {

/// Writes the images of E57 files into `folder`, which is created if missing, byte for byte as they are:
/// NAME.jpg or NAME.png by the name of the image, else its GUID; NAME_visual for a visual reference of an
/// image that has another representation; NAME_2 and so on where a name is repeated; NAME_mask.png for a
/// mask; NAME.json, a camera file, if a lens has the projection (camera_of()). images.json contains the
/// metadata of all images, also of those without a camera. Errors: an output exists and may not be replaced,
/// found before anything is written; no image in any file; a damaged page.
void extract_images(std::vector<E57File>& files, const std::filesystem::path& folder, bool overwrite);

}  // namespace alidade::camera
