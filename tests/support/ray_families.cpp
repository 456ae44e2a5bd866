// SPDX-License-Identifier: MIT
#include "tests/support/ray_families.h"

#include <algorithm>

#include "tests/support/positions.h"

namespace alidade::test {
namespace {

/// An axis, with zeros of either sign on the other two.
glm::dvec3 axis_direction(Random& random) {
  glm::dvec3 direction(random.below(2) ? 0.0 : -0.0, random.below(2) ? 0.0 : -0.0,
                       random.below(2) ? 0.0 : -0.0);
  direction[static_cast<int>(random.below(3))] = random.below(2) ? 1.0 : -1.0;
  return direction;
}

glm::dvec3 some_direction(Random& random) {
  switch (random.below(6)) {
    case 0:
      return axis_direction(random);
    case 1: {  // in an axis plane
      glm::dvec3 direction = random.direction();
      direction[static_cast<int>(random.below(3))] = random.below(2) ? 0.0 : -0.0;
      return direction;
    }
    case 2: {  // nearly along an axis
      glm::dvec3 direction = 1e-9 * random.direction();
      direction[static_cast<int>(random.below(3))] = random.below(2) ? 1.0 : -1.0;
      return direction;
    }
    case 3: {  // components so small that their squares vanish
      glm::dvec3 direction = 1e-200 * random.direction();
      direction[static_cast<int>(random.below(3))] = random.below(2) ? 1.0 : -1.0;
      return direction;
    }
    default:
      return random.direction();
  }
}

}  // namespace

std::vector<RayCase> ray_cases(const PointCloud& cloud, std::size_t count, Random& random) {
  const Positions positions(cloud, random);
  const double diagonal = positions.diagonal(), spacing = positions.spacing();
  std::vector<RayCase> cases;
  while (cases.size() < count) {
    const glm::dvec3 direction = some_direction(random);
    const glm::dvec3 target =
        random.below(2) ? positions.point() : positions.inside() + 0.3 * spacing * random.in_cube();
    double back = 0.0;
    switch (random.below(5)) {
      case 0:
        break;
      case 1:
        back = 1e6;
        break;
      case 2:
        back = random.between(-1, 1) * spacing;
        break;
      default:
        back = random.between(0, 2) * diagonal;
    }
    RayCase next;
    next.ray = make_ray(target, direction);
    next.ray.origin = next.ray.position(-back);
    switch (random.below(5)) {
      case 0:
        next.ray.t_min = 0.0;
        break;
      case 1:
        next.ray.t_min = back + random.between(-1, 1) * spacing;
        break;
      case 2:
        next.ray.t_max = back + random.between(-1, 1) * spacing;
        break;
      case 3:
        next.ray.t_min = random.between(0, 1) * back;
        next.ray.t_max = next.ray.t_min + random.unit() * diagonal;
        break;
      default:
        break;
    }
    next.query.radius = positions.length();
    next.query.measure = random.below(2) ? Measure::entry : Measure::t;
    if (random.below(3) == 0) next.query.entry_min = random.below(2) ? 1e-6 : back - next.query.radius;
    cases.push_back(next);
  }
  return cases;
}

}  // namespace alidade::test
