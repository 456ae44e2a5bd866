// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "renderer/scene.h"

namespace alidade {

/// The camera as a camera file on one line; parse_camera gives back the same camera, bit for bit.
std::string camera_json(const Camera& camera);

}  // namespace alidade
