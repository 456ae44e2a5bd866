// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "simulation/shapes.h"
#include "simulation/site.h"

// What the houses and things of courtyard() are made of. Positions are in the site's own frame: metres, x
// east, y north, the yard's paving at z = 0.

namespace alidade::simulation::courtyard_parts {

using Objects = std::vector<SiteObject>;

constexpr glm::dvec3 k_up(0.0, 0.0, 1.0);

/// Box along the axes from corner to corner.
shapes::Box upright_box(const glm::dvec3& min, const glm::dvec3& max);
/// Box turned about the vertical: its own x axis points along `forward` (level, length 1), z up.
shapes::Box turned_box(const glm::dvec3& center, const glm::dvec2& forward, const glm::dvec3& half_size);
/// A post, pipe or branch between two points.
shapes::Frustum rod(const glm::dvec3& from, const glm::dvec3& to, double from_radius, double to_radius);

enum class Filling { window, door, passage };

/// An opening in a wall, seen from outside: `u` is its middle from the wall's left end, `bottom` a height
/// above z = 0.
struct WallOpening {
  double u = 0.0, bottom = 1.0;
  glm::dvec2 size{1.1, 1.6};
  Filling filling = Filling::window;
};

/// A house wall from left to right as seen from outside.
struct WallPlan {
  glm::dvec2 left{0.0}, right{1.0, 0.0};
  double base = 0.0, top = 6.0;  ///< heights
  glm::dvec3 tint{0.8};
  double plinth = 0.7;  ///< height of its upper edge above z = 0
  std::vector<WallOpening> openings{};
  glm::dvec3 door_tint{0.30, 0.20, 0.13};
  bool shutters = false;
  glm::dvec3 shutter_tint{0.25, 0.37, 0.30};
  bool cornice = true;
};

/// The wall with niches behind its windows and doors, their stone frames and sills, and
/// a cornice below the eaves.
void add_wall(Objects& objects, const WallPlan& plan);

enum class Ridge { along_x, along_y };

/// A gable roof over a rectangle, with gutters and ridge tiles. Gable walls are closed at both ends.
struct RoofPlan {
  glm::dvec2 min{0.0}, max{1.0};  ///< of the walls below
  Ridge run = Ridge::along_x;
  double eaves = 6.0, ridge = 9.0;  ///< heights
  glm::dvec3 tint{0.62, 0.33, 0.22};
  glm::dvec3 gable_tint{0.8};
  double gable_overhang = 0.25;
};
void add_roof(Objects& objects, const RoofPlan& plan);

void add_chimney(Objects& objects, const glm::dvec2& position, double bottom, double top);

}  // namespace alidade::simulation::courtyard_parts
