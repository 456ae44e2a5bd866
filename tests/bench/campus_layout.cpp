// SPDX-License-Identifier: MIT
#include "tests/bench/campus_layout.h"

#include <algorithm>
#include <cmath>

#include "simulation/noise.h"

namespace alidade::bench {

using namespace simulation;

namespace {

constexpr double k_eye_height = 1.7;

double between(double low, double high, std::mt19937_64& random) {
  return low + (high - low) * unit_of(random());
}

bool is_open(const CampusLayout& layout, double x, double y, double margin) {
  return std::ranges::none_of(layout.buildings, [&](const Building& building) {
    return x > building.low.x - margin && x < building.high.x + margin && y > building.low.y - margin &&
           y < building.high.y + margin;
  });
}

glm::dvec3 open_ground(const CampusLayout& layout, double margin, std::mt19937_64& random) {
  for (;;) {
    const double x = between(5, k_campus_side - 5, random), y = between(5, k_campus_side - 5, random);
    if (is_open(layout, x, y, margin)) return {x, y, terrain_height(x, y)};
  }
}

/// A tree's position in front of a wall.
glm::dvec3 beside_building(const CampusLayout& layout, double radius, std::mt19937_64& random) {
  for (;;) {
    const Building& building = layout.buildings[random() % layout.buildings.size()];
    const double margin = radius + between(1.0, 4.0, random);
    const double x = between(building.low.x - margin, building.high.x + margin, random);
    const double y = between(building.low.y - margin, building.high.y + margin, random);
    if (is_open(layout, x, y, radius)) return {x, y, terrain_height(x, y)};
  }
}

/// In the cells of a grid, so that streets run between them.
void add_buildings(CampusLayout& layout, std::mt19937_64& random) {
  constexpr int k_columns = 8, k_rows = 5;
  for (int row = 0; row < k_rows; ++row) {
    for (int column = 0; column < k_columns; ++column) {
      const double width = between(12, 32, random), depth = between(12, 45, random);
      const double x = (column + 0.5) * k_campus_side / k_columns + between(-6, 6, random);
      const double y = (row + 0.5) * k_campus_side / k_rows + between(-12, 12, random);
      const double ground = terrain_height(x, y);
      layout.buildings.push_back({{x - 0.5 * width, y - 0.5 * depth, ground - 2.0},
                                  {x + 0.5 * width, y + 0.5 * depth, ground + between(5, 22, random)}});
    }
  }
}

}  // namespace

double terrain_height(double x, double y) {
  return 3.0 * std::sin(x / 41.0) + 2.0 * std::sin(y / 57.0 + 1.0) + 1.2 * std::sin((x + y) / 23.0);
}

CampusLayout campus_layout() {
  std::mt19937_64 random(20);
  CampusLayout layout;
  add_buildings(layout, random);
  for (int i = 0; i < 300; ++i) {
    const double radius = between(1.2, 3.5, random), trunk = between(1.5, 4.0, random);
    const glm::dvec3 foot =
        i % 2 ? beside_building(layout, radius, random) : open_ground(layout, radius, random);
    layout.crowns.push_back({foot + glm::dvec3(0, 0, trunk + radius), radius});
    layout.poles.push_back({foot, trunk + 0.5 * radius, 0.07 * radius + 0.05});
  }
  for (int i = 0; i < 120; ++i) layout.poles.push_back({open_ground(layout, 1.0, random), 6.0, 0.08});
  for (int i = 0; i < 10; ++i) layout.stations.push_back(open_position(layout, random));
  return layout;
}

glm::dvec3 open_position(const CampusLayout& layout, std::mt19937_64& random) {
  return open_ground(layout, 3.0, random) + glm::dvec3(0, 0, k_eye_height);
}

}  // namespace alidade::bench
