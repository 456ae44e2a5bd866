// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "camera/camera.h"

namespace alidade::camera {

/// Cameras on a full circle around some positions, framed as by overview_camera(): the first in the
/// south-west, then counterclockwise seen from above, `count` at equal angles. All face the vertical line
/// through the middle of the positions' box, from the same height and distance. Requires: a position,
/// count >= 1.
std::vector<Camera> orbit_cameras(std::span<const glm::dvec3> positions, int width, int height, int count);

/// Cameras on a smooth path from the first keyframe to the last: positions by centripetal Catmull-Rom splines
/// (Yuksel, Schaefer and Keyser, Computer-Aided Design 43, 2011); directions, focal lengths and principal
/// points by the same weights, the directions made orthogonal again. The speed along the path is constant;
/// between keyframes at the same position the camera turns. Size and lens are those of the first keyframe.
/// Requires: two keyframes, count >= 2. Errors: keyframes that differ in size or lens.
std::vector<Camera> cameras_between(std::span<const Camera> keyframes, int count);

}  // namespace alidade::camera
