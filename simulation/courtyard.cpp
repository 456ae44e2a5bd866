// SPDX-License-Identifier: MIT
#include "simulation/courtyard.h"

#include <utility>

#include "simulation/courtyard_parts.h"

namespace alidade {

namespace courtyard_parts {

shapes::Ground ground() {
  using glm::dvec2;
  const int cobble = static_cast<int>(Pavement::cobble), slab = static_cast<int>(Pavement::slab),
            gravel = static_cast<int>(Pavement::gravel), asphalt = static_cast<int>(Pavement::asphalt),
            soil = static_cast<int>(Pavement::soil), grass = static_cast<int>(Pavement::grass);
  shapes::Ground ground;
  ground.half_size = {62.0, 54.0};
  ground.core = {34.0, 36.0};
  ground.fade_width = 18.0;
  ground.waves = {{0.75, {0.155, 0.060}, 0.7}, {0.45, {-0.090, 0.245}, 2.1}, {0.18, {0.430, 0.310}, 4.0}};
  ground.patches = {
      {{0.0, 0.0}, {33.0, 26.0}, false, cobble},
      // Lawns, beds and paths of the yard.
      {{-12.65, 7.75}, {8.05, 4.85}, false, grass},
      {{12.65, 7.75}, {8.05, 4.85}, false, grass},
      {{-15.0, -8.85}, {5.8, 4.3}, false, grass},
      {{-10.0, -8.85}, {0.8, 4.3}, false, soil},
      {{-14.2, 15.9}, {9.8, 0.6}, false, soil},
      {{14.2, 15.9}, {9.8, 0.6}, false, soil},
      {{0.0, -0.5}, {8.0, 8.0}, true, gravel},
      {{-5.0, -18.0}, {1.7, 12.4}, false, slab},
      {{0.0, 10.0}, {1.7, 5.6}, false, slab},
      {{0.0, -0.5}, {3.6, 3.6}, true, slab},
      // Street with its pavements.
      {{0.0, -29.2}, {62.0, 3.2}, false, slab},
      {{0.0, -43.2}, {62.0, 2.4}, false, slab},
      {{0.0, -36.6}, {62.0, 4.2}, false, asphalt},
      {{0.0, -36.6}, {62.0, 0.08}, false, static_cast<int>(Pavement::road_marking)},
      {{-5.0, -29.2}, {2.4, 3.2}, false, cobble},
      {{-19.0, -29.5}, {0.9, 0.9}, false, soil},
      {{11.0, -29.5}, {0.9, 0.9}, false, soil},
      {{25.0, -29.5}, {0.9, 0.9}, false, soil},
      // Garden paths.
      {{0.0, 28.0}, {30.0, 1.2}, false, gravel},
      {{0.0, 41.0}, {1.2, 13.0}, false, gravel},
  };
  return ground;
}

}  // namespace courtyard_parts

Site courtyard() {
  using namespace courtyard_parts;
  const shapes::Ground land = ground();
  Objects objects;
  objects.push_back({land, {.material = SiteMaterial::terrain}});
  add_buildings(objects);
  add_neighbours(objects);
  add_plants(objects, land);
  add_furniture(objects);
  add_cars(objects, land);
  return Site(std::move(objects), {690000.0, 5325000.0, 600.0});
}

}  // namespace alidade
