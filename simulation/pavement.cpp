// SPDX-License-Identifier: MIT
#include "simulation/pavement.h"

#include "simulation/patterns.h"

namespace alidade {

using namespace patterns;
using glm::dvec3;

namespace {

dvec3 grass(const dvec3& position) {
  const double wide = blotches(position, 6.0, 11), patch = blotches(position, 0.9, 12),
               blade = blotches(position, 0.11, 13);
  const dvec3 fresh(0.33, 0.46, 0.17), dry(0.50, 0.51, 0.26);
  return blend(fresh, dry, std::clamp(0.32 + 0.38 * wide + 0.22 * patch, 0.0, 1.0)) * (1.0 + 0.16 * blade);
}

dvec3 cobble(const dvec3& position) {
  const Stone stone = stone_at({position.x, position.y}, {0.24, 0.19}, 0.030, 21);
  const double stain = blotches(position, 3.5, 22);
  const dvec3 grey =
      blend(dvec3(0.565, 0.54, 0.505), dvec3(0.60, 0.545, 0.47), 0.5 + 0.5 * blotches(position, 9.0, 23));
  return blend(grey * (1.0 + 0.10 * stone.shade + 0.06 * stain), dvec3(0.40, 0.375, 0.33),
               0.75 * stone.joint);
}

dvec3 slab(const dvec3& position) {
  const Stone stone = stone_at({position.x, position.y}, {0.9, 0.6}, 0.028, 31);
  const dvec3 sandstone(0.705, 0.665, 0.595);
  const double shade = 1.0 + 0.06 * stone.shade + 0.05 * blotches(position, 1.3, 32);
  return blend(sandstone * shade, dvec3(0.47, 0.44, 0.39), 0.7 * stone.joint);
}

dvec3 gravel(const dvec3& position) {
  return dvec3(0.72, 0.67, 0.575) *
         (1.0 + 0.05 * blotches(position, 2.0, 41) + 0.10 * blotches(position, 0.06, 42));
}

dvec3 asphalt(const dvec3& position) {
  return dvec3(0.35, 0.355, 0.365) *
         (1.0 + 0.07 * blotches(position, 2.5, 51) + 0.06 * blotches(position, 0.08, 52));
}

dvec3 soil(const dvec3& position) {
  return dvec3(0.38, 0.30, 0.22) * (1.0 + 0.12 * blotches(position, 0.25, 61));
}

}  // namespace

dvec3 pavement_color(Pavement pavement, const dvec3& position) {
  switch (pavement) {
    case Pavement::cobble:
      return cobble(position);
    case Pavement::slab:
      return slab(position);
    case Pavement::gravel:
      return gravel(position);
    case Pavement::asphalt:
      return asphalt(position);
    case Pavement::road_marking:
      return fraction(position.x / 6.0) < 0.5 ? dvec3(0.80, 0.80, 0.78) : asphalt(position);
    case Pavement::soil:
      return soil(position);
    case Pavement::grass:
      break;
  }
  return grass(position);
}

}  // namespace alidade
