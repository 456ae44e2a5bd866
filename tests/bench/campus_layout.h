// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <random>
#include <vector>

namespace alidade::bench {

/// Side of the square site, metres; coordinates run from 0 to here in x and y.
constexpr double k_campus_side = 400.0;

/// Height of the rolling terrain.
double terrain_height(double x, double y);

/// A house without openings: an upright box.
struct Building {
  glm::dvec3 low, high;
};

/// A ball of leaves above the ground.
struct Crown {
  glm::dvec3 center;
  double radius;
};

/// A trunk or a lamp post: an upright cylinder.
struct Pole {
  glm::dvec3 foot;
  double height, radius;
};

/// The objects of the site: 40 buildings, 300 trees, 120 lamp posts, ten scanner stations. They are the same
/// on every run.
struct CampusLayout {
  std::vector<Building> buildings;
  std::vector<Crown> crowns;
  std::vector<Pole> poles;
  std::vector<glm::dvec3> stations;  ///< eyes of the scanners, 1.7 m above ground
};

CampusLayout campus_layout();

/// A position at eye height, 1.7 m above ground and at least 3 m from every building.
glm::dvec3 open_position(const CampusLayout& layout, std::mt19937_64& random);

}  // namespace alidade::bench
