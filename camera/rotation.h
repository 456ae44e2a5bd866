// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "renderer/scene.h"

namespace alidade {

/// How far the columns are from length 1 at right angles: the largest entry of |R^T R - I|.
double error_of_rotation(const glm::dmat3& rotation);

/// The same matrix with columns of length 1 at right angles; for those whose error is small. The third column
/// keeps its direction.
glm::dmat3 orthonormal(const glm::dmat3& rotation);

/// Rotation by a quaternion w, x, y, z of any length (Hamilton's convention). Empty if its length is 0, not
/// finite, or beyond 1e-100 to 1e100.
std::optional<glm::dmat3> rotation_from_quaternion(const std::array<double, 4>& quaternion);

/// Rotation about an axis by its length in radians, counter-clockwise seen from the tip. Source: Rodrigues.
/// Requires: finite, at most 1e6 long.
glm::dmat3 rotation_from_axis_angle(const glm::dvec3& axis);

/// From camera = rotation * world + translation, with camera axes right, down, forward.
CameraPose pose_from_world_to_camera(const glm::dmat3& rotation, const glm::dvec3& translation);

}  // namespace alidade
