// SPDX-License-Identifier: MIT
#include "camera/projection.h"

#include <glm/geometric.hpp>

namespace alidade {

std::optional<Ray> Projection::ray(const glm::dvec2& film_position) const {
  const std::optional<LensRay> seen = lens_.unproject(
      {(film_position.x - camera_.cx) / camera_.fx, (film_position.y - camera_.cy) / camera_.fy});
  if (!seen) return std::nullopt;
  const CameraPose& pose = camera_.pose;
  const glm::dvec3& towards = seen->direction;
  const glm::dvec3 direction = towards.x * pose.right + towards.y * pose.down + towards.z * pose.forward;
  glm::dvec3 origin = pose.position;
  if (seen->origin != glm::dvec3(0.0)) origin += seen->origin.x * pose.right + seen->origin.y * pose.down;
  return make_ray(origin, direction, 0.0);
}

std::optional<glm::dvec2> Projection::project(const glm::dvec3& world) const {
  const glm::dvec3 offset = world - camera_.pose.position;
  const std::optional<glm::dvec2> film =
      lens_.project({glm::dot(offset, camera_.pose.right), glm::dot(offset, camera_.pose.down),
                     glm::dot(offset, camera_.pose.forward)});
  if (!film) return std::nullopt;
  return glm::dvec2(camera_.cx + camera_.fx * film->x, camera_.cy + camera_.fy * film->y);
}

}  // namespace alidade
