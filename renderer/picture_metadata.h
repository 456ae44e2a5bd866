// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "image/image_file.h"

namespace alidade {

/// The metadata as texts, in the order of docs/scene_format.md; what is empty is left out. Numbers have 17
/// significant digits.
std::vector<std::pair<std::string, std::string>> metadata_texts(const ImageMetadata& metadata);

/// Positions in an image are float, too coarse for coordinates like 5325000. They are therefore stored
/// relative to this point: the camera's place rounded to 10 km along each axis. It is 0 0 0 for sites around
/// the origin, and the same for cameras near each other.
glm::dvec3 position_offset(const Camera& camera);

}  // namespace alidade
