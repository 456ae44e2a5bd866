// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "camera/camera.h"

namespace alidade::camera {

/// Cameras on a full circle around some positions, as overview_camera() sees them from each side: the first
/// from the south-west, then counterclockwise seen from above, `count` at equal angles. All look at the
/// vertical line through the middle of the positions' box, from one height and distance. Requires: a
/// position, count >= 1.
std::vector<Camera> orbit_cameras(std::span<const glm::dvec3> positions, int width, int height, int count);

/// Cameras on a smooth way through keyframes, whose first and last they are: positions by centripetal
/// Catmull-Rom splines (Yuksel, Schaefer and Keyser, Computer-Aided Design 43, 2011), directions by the same
/// weights, made orthogonal again; focal lengths and principal points in between linearly. The way is covered
/// at constant speed; keyframes at one position only turn. Size and lens are those of the first keyframe.
/// Requires: two keyframes, count >= 2. Errors: keyframes of other sizes or lenses than the first.
std::vector<Camera> cameras_between(std::span<const Camera> keyframes, int count);

}  // namespace alidade::camera
