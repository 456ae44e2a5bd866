// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>

#include "cloud/e57/e57_xml.h"

namespace alidade {
namespace {

/// Rotation by a unit quaternion of Hamilton's convention.
glm::dmat3 rotation_of(double w, double x, double y, double z) {
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

}  // namespace

std::optional<E57Pose> read_e57_pose(const E57Node& parent, E57Oddities& oddities) {
  const E57Node node = parent.child("pose");
  if (!node) return std::nullopt;
  E57Pose pose;
  if (const E57Node rotation = node.child("rotation")) {
    const double w = rotation.child("w").number_or(0.0), x = rotation.child("x").number_or(0.0),
                 y = rotation.child("y").number_or(0.0), z = rotation.child("z").number_or(0.0);
    const double length = std::hypot(std::hypot(w, x), std::hypot(y, z));
    if (!(length > 1e-100 && length < 1e100)) {
      rotation.fail("is no rotation", "a quaternion of length 1", fmt::format("length {}", length));
    }
    if (std::abs(length - 1.0) > 1e-3) {
      oddities.add("quaternion",
                   fmt::format("{}: the quaternion of the pose has length {}; it was brought to 1",
                               parent.where(), length));
    }
    pose.is_rotated = x != 0.0 || y != 0.0 || z != 0.0;
    if (pose.is_rotated) pose.rotation = rotation_of(w / length, x / length, y / length, z / length);
  }
  if (const E57Node translation = node.child("translation")) {
    pose.translation = {translation.child("x").number_or(0.0), translation.child("y").number_or(0.0),
                        translation.child("z").number_or(0.0)};
  }
  return pose;
}

}  // namespace alidade
