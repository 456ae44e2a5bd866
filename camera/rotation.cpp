// SPDX-License-Identifier: MIT
#include "camera/rotation.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/exact_math.h"
#include "base/ray.h"

namespace alidade {

double error_of_rotation(const glm::dmat3& rotation) {
  const glm::dmat3 product = glm::transpose(rotation) * rotation;
  double error = 0.0;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      const double difference = std::fabs(product[column][row] - (column == row ? 1.0 : 0.0));
      // A difference that is not a number must not pass for a small one.
      if (!(difference <= error)) error = difference;
    }
  }
  return error;
}

glm::dmat3 orthonormal(const glm::dmat3& rotation) {
  const glm::dvec3 z = unit_direction(rotation[2]);
  const glm::dvec3 x = unit_direction(glm::cross(rotation[1], z));
  return {x, glm::cross(z, x), z};
}

std::optional<glm::dmat3> rotation_from_quaternion(const std::array<double, 4>& quaternion) {
  double sum = 0.0;
  for (const double component : quaternion) sum += component * component;
  const double length = std::sqrt(sum);
  if (!(length >= 1e-100 && length <= 1e100)) return std::nullopt;
  const double w = quaternion[0] / length, x = quaternion[1] / length, y = quaternion[2] / length,
               z = quaternion[3] / length;
  // Columns: the images of the three axes (e.g. Shoemake, "Animating Rotation with Quaternion Curves", 1985).
  return glm::dmat3{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                    {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                    {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

glm::dmat3 rotation_from_axis_angle(const glm::dvec3& axis) {
  const double angle = length_of(axis);
  if (angle == 0.0) return glm::dmat3(1.0);
  const glm::dvec3 unit = unit_direction(axis);
  const SineCosine turn = sine_cosine(angle);
  glm::dmat3 rotation;
  for (int column = 0; column < 3; ++column) {
    glm::dvec3 base(0.0);
    base[column] = 1.0;
    rotation[column] =
        turn.cosine * base + turn.sine * glm::cross(unit, base) + (1.0 - turn.cosine) * unit[column] * unit;
  }
  return rotation;
}

CameraPose pose_from_world_to_camera(const glm::dmat3& rotation, const glm::dvec3& translation) {
  const glm::dmat3 axes = glm::transpose(rotation);
  return {.position = -(axes * translation), .right = axes[0], .down = axes[1], .forward = axes[2]};
}

}  // namespace alidade
