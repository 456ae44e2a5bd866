// SPDX-License-Identifier: MIT
#include <glm/geometric.hpp>

#include "simulation/courtyard_parts.h"

namespace alidade::courtyard_parts {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr dvec3 k_rose(0.86, 0.64, 0.53), k_cream(0.91, 0.865, 0.76), k_white(0.90, 0.885, 0.84),
    k_ochre(0.85, 0.70, 0.46);
constexpr dvec3 k_red_tile(0.605, 0.375, 0.285), k_brown_tile(0.50, 0.335, 0.275), k_slate(0.40, 0.405, 0.43);

/// A plain house with windows on all sides.
void add_house(Objects& objects, const dvec2& min, const dvec2& max, bool ridge_along_x, double eaves,
               double ridge, const dvec3& tint, const dvec3& tiles) {
  const dvec2 corners[] = {{min.x, min.y}, {max.x, min.y}, {max.x, max.y}, {min.x, max.y}};
  for (int side = 0; side < 4; ++side) {
    WallPlan wall{.left = corners[side],
                  .right = corners[(side + 1) % 4],
                  .base = -2.5,
                  .top = eaves,
                  .tint = tint,
                  .plinth = 0.9};
    const double width = glm::length(wall.right - wall.left);
    const int count = static_cast<int>(width / 3.1);
    for (double bottom = 1.5; bottom + 1.9 < eaves; bottom += 3.0)
      add_windows(wall, count, 0.6, width - 0.6, bottom, {1.1, 1.45});
    add_wall(objects, wall);
  }
  add_roof(objects, {.min = min,
                     .max = max,
                     .ridge_along_x = ridge_along_x,
                     .eaves = eaves,
                     .ridge = ridge,
                     .tint = tiles,
                     .gable_tint = tint});
  add_chimney(objects, 0.5 * (min + max) + dvec2(0.8, 0.8), ridge - 1.5, ridge + 1.0);
}

}  // namespace

void add_neighbours(Objects& objects) {
  // Across the street, and neighbours to both sides.
  add_house(objects, {-58, -53}, {-38, -45.5}, true, 7.0, 10.0, k_ochre, k_brown_tile);
  add_house(objects, {-34, -53}, {-12, -45.5}, true, 8.6, 11.8, k_cream, k_red_tile);
  add_house(objects, {-9, -53}, {9, -45.5}, true, 7.6, 11.0, k_rose, k_slate);
  add_house(objects, {14, -53}, {40, -45.5}, true, 6.4, 9.6, k_white, k_red_tile);
  add_house(objects, {46, -18}, {57, -2}, false, 6.2, 9.8, k_ochre, k_red_tile);
  add_house(objects, {-58, 8}, {-47, 26}, false, 6.2, 9.6, k_cream, k_brown_tile);
}

}  // namespace alidade::courtyard_parts
