// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "cloud/e57/e57_file.h"
#include "tools/console.h"

namespace alidade::tools {

/// What `alidade info --json` prints about an E57 file beside the facts of its points.
nlohmann::ordered_json e57_json(const E57File& file);

/// The facts of e57_json() as lines for people; of more than ten scans or images the first ten, unless
/// verbose.
std::vector<std::string> e57_lines(const E57File& file, Verbosity verbosity);

/// Writes the images of E57 files into `folder`, which is created if missing, byte for byte as they are:
/// NAME.jpg or NAME.png by the name of the image, else its GUID; NAME_visual for a visual reference of an
/// image that has another representation; NAME_2 and so on where a name is repeated; NAME_mask.png for a
/// mask; NAME.json, a camera file, if a lens has the projection (camera_of()). images.json contains the
/// metadata of all images, also of those without a camera. Returns the number of images written. Errors: an
/// output exists and may not be replaced, found before anything is written; no image in any file; a damaged
/// page.
std::size_t extract_images(std::span<const std::filesystem::path> files, const std::filesystem::path& folder,
                           bool overwrite);

}  // namespace alidade::tools
