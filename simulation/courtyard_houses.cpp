// SPDX-License-Identifier: MIT

#include <glm/geometric.hpp>

#include "simulation/courtyard_parts.h"

// Each wall is given from left to right as one stands before it, so the outside lies on the right hand of
// left -> right.

namespace alidade::simulation::courtyard_parts {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr dvec3 k_yellow(0.90, 0.80, 0.575), k_rose(0.86, 0.64, 0.53), k_cream(0.91, 0.865, 0.76),
    k_white(0.90, 0.885, 0.84), k_stone(0.80, 0.755, 0.675);
constexpr dvec3 k_red_tile(0.605, 0.375, 0.285), k_brown_tile(0.50, 0.335, 0.275);

/// A dormer on a roof slope that falls to the south: its front stands at `place`, the roof behind it swallows
/// the rest.
void add_dormer(Objects& objects, const dvec2& place, double bottom) {
  constexpr double k_half = 0.85, k_height = 1.5, k_depth = 3.0;
  WallPlan front{.left = {place.x - k_half, place.y},
                 .right = {place.x + k_half, place.y},
                 .base = bottom,
                 .top = bottom + k_height,
                 .tint = k_cream,
                 .plinth = bottom,
                 .cornice = false};
  front.openings.push_back({k_half, bottom + 0.25, {0.85, 1.1}, Filling::window});
  add_wall(objects, front);
  for (const double side : {-1.0, 1.0})
    objects.push_back(
        {shapes::Panel{
             {place.x + side * k_half, place.y, bottom}, {0, 1, 0}, {0, 0, 1}, {k_depth, k_height}, {}},
         {.material = SiteMaterial::plaster, .tint = k_cream}});
  add_roof(objects, {.min = {place.x - k_half, place.y},
                     .max = {place.x + k_half, place.y + k_depth},
                     .ridge_along_x = false,
                     .eaves = bottom + k_height,
                     .ridge = bottom + k_height + 0.8,
                     .tint = k_red_tile,
                     .gable_tint = k_cream,
                     .gable_overhang = 0.2});
}

/// x -33 .. 33, y 16.5 .. 26: the main house.
void add_north_wing(Objects& objects) {
  constexpr double k_eaves = 8.9;
  WallPlan south{
      .left = {-33, 16.5}, .right = {33, 16.5}, .top = k_eaves, .tint = k_yellow, .shutters = true};
  for (const double bottom : {1.05, 4.05, 6.75}) {
    const dvec2 size = bottom > 6.0 ? dvec2(1.05, 1.35) : dvec2(1.1, 1.75);
    add_windows(south, 7, 9.0, 30.2, bottom, size);
    add_windows(south, 7, 35.8, 57.0, bottom, size);
    if (bottom > 2.0) add_windows(south, 1, 31.0, 35.0, bottom, {1.5, size.y});
  }
  south.openings.push_back({33.0, 0.6, {1.9, 2.6}, Filling::door});
  add_wall(objects, south);
  for (int step = 0; step < 3; ++step)
    objects.push_back({upright_box({-2.2 - 0.35 * step, 15.6 - 0.35 * step, -0.1},
                                   {2.2 + 0.35 * step, 16.5, 0.6 - 0.2 * step}),
                       {.material = SiteMaterial::stone, .tint = {0.70, 0.67, 0.61}, .seed = 9}});
  // A small canopy on two columns above the steps.
  for (const double x : {-1.75, 1.75})
    objects.push_back({rod({x, 15.85, 0.6}, {x, 15.85, 3.5}, 0.17, 0.14),
                       {.material = SiteMaterial::trim, .tint = k_stone}});
  objects.push_back({upright_box({-2.15, 15.35, 3.5}, {2.15, 16.5, 3.85}),
                     {.material = SiteMaterial::trim, .tint = k_stone}});

  WallPlan north{.left = {33, 26}, .right = {-33, 26}, .base = -1.0, .top = k_eaves, .tint = k_yellow};
  WallPlan east{.left = {33, 16.5}, .right = {33, 26}, .base = -1.0, .top = k_eaves, .tint = k_yellow};
  WallPlan west{.left = {-33, 26}, .right = {-33, 16.5}, .base = -1.0, .top = k_eaves, .tint = k_yellow};
  for (const double bottom : {1.05, 4.05, 6.75}) {
    add_windows(north, 14, 2.0, 64.0, bottom, {1.1, 1.5});
    add_windows(east, 2, 1.5, 8.0, bottom, {1.1, 1.5});
    add_windows(west, 2, 1.5, 8.0, bottom, {1.1, 1.5});
  }
  add_wall(objects, north);
  add_wall(objects, east);
  add_wall(objects, west);
  add_roof(objects, {.min = {-33, 16.5},
                     .max = {33, 26},
                     .ridge_along_x = true,
                     .eaves = k_eaves,
                     .ridge = 12.4,
                     .tint = k_red_tile,
                     .gable_tint = k_yellow});
  for (const double x : {-19.0, -9.5, 0.0, 9.5, 19.0}) add_dormer(objects, {x, 17.6}, 9.55);
  add_chimney(objects, {-24.0, 22.0}, 10.5, 13.6);
  add_chimney(objects, {5.0, 22.3}, 10.5, 13.6);
  add_chimney(objects, {26.0, 20.4}, 10.5, 13.4);
}

/// x 24.5 .. 33, y -26 .. 21.
void add_east_wing(Objects& objects) {
  constexpr double k_eaves = 7.3;
  WallPlan west{.left = {24.5, 16.5}, .right = {24.5, -17.5}, .top = k_eaves, .tint = k_rose};
  add_windows(west, 9, 0.6, 33.4, 4.3, {1.1, 1.65});
  add_windows(west, 4, 0.6, 15.2, 1.05, {1.1, 1.6});
  add_windows(west, 4, 18.8, 33.4, 1.05, {1.1, 1.6});
  west.openings.push_back({17.0, 0.12, {1.5, 2.5}, Filling::door});
  west.door_tint = {0.20, 0.30, 0.24};
  add_wall(objects, west);
  WallPlan east{.left = {33, -26}, .right = {33, 21}, .base = -1.0, .top = k_eaves, .tint = k_rose};
  WallPlan south{.left = {24.5, -26}, .right = {33, -26}, .base = -1.0, .top = k_eaves, .tint = k_rose};
  for (const double bottom : {1.05, 4.3}) {
    add_windows(east, 10, 1.0, 42.0, bottom, {1.1, 1.6});
    add_windows(south, 2, 0.8, 7.7, bottom, {1.1, 1.6});
  }
  add_wall(objects, east);
  add_wall(objects, south);
  add_roof(objects, {.min = {24.5, -26},
                     .max = {33, 21},
                     .ridge_along_x = false,
                     .eaves = k_eaves,
                     .ridge = 10.7,
                     .tint = k_brown_tile,
                     .gable_tint = k_rose});
  add_chimney(objects, {29.6, -12.0}, 9.5, 12.0);
  add_chimney(objects, {27.8, 6.0}, 9.5, 12.0);
}

/// An arched wall in two skins with reveals between, so that the arcade has pillars of some thickness.
void add_arcade(Objects& objects, double x, double thickness, double from, double to, int arches,
                double width, double crown) {
  const double spring = crown - 0.5 * width;
  const Finish stone{.material = SiteMaterial::trim, .tint = k_stone};
  WallPlan back{.left = {x - thickness, to},
                .right = {x - thickness, from},
                .base = -0.1,
                .top = 3.9,
                .tint = k_white,
                .cornice = false};
  for (int i = 0; i < arches; ++i) {
    const double pitch = (to - from) / arches, y = from + pitch * (i + 0.5);
    back.openings.push_back({to - y, -0.1, {width, crown + 0.1}, Filling::passage});
    for (const double side : {-0.5, 0.5})
      objects.push_back(
          {shapes::Panel{
               {x - thickness, y + side * width, -0.1}, {1, 0, 0}, {0, 0, 1}, {thickness, spring + 0.1}, {}},
           stone});
    shapes::Frustum vault = rod({x - thickness, y, spring}, {x, y, spring}, 0.5 * width, 0.5 * width);
    vault.keep = {0, 0, 1};
    objects.push_back({vault, stone});
    // Imposts: the little ledges the arches spring from.
    for (const double side : {-1.0, 1.0}) {
      const double near = y + side * (0.5 * width - 0.05), far = y + side * (0.5 * width + 0.16);
      objects.push_back({upright_box({x - thickness - 0.04, std::min(near, far), spring - 0.16},
                                     {x + 0.06, std::max(near, far), spring}),
                         stone});
    }
  }
  add_wall(objects, back);
}

/// x -33 .. -24.5, y -26 .. 21: an arcade to the yard below, windows above.
void add_west_wing(Objects& objects) {
  constexpr double k_eaves = 6.6, k_crown = 3.1, k_width = 2.7;
  constexpr int k_arches = 9;
  WallPlan east{.left = {-24.5, -17.5},
                .right = {-24.5, 16.5},
                .base = -0.1,
                .top = k_eaves,
                .tint = k_white,
                .plinth = -0.1};
  add_windows(east, k_arches, 0.0, 34.0, 4.2, {1.1, 1.55});
  for (int i = 0; i < k_arches; ++i)
    east.openings.push_back({34.0 / k_arches * (i + 0.5), -0.1, {k_width, k_crown + 0.1}, Filling::passage});
  add_wall(objects, east);
  add_arcade(objects, -24.5, 0.55, -17.5, 16.5, k_arches, k_width, k_crown);
  WallPlan behind{.left = {-28.3, -17.5},
                  .right = {-28.3, 16.5},
                  .base = -0.1,
                  .top = 3.9,
                  .tint = k_cream,
                  .cornice = false};
  for (int i = 0; i < k_arches; ++i) {
    const double u = 34.0 / k_arches * (i + 0.5);
    if (i % 3 == 1)
      behind.openings.push_back({u, 0.1, {1.3, 2.4}, Filling::door});
    else
      behind.openings.push_back({u, 1.0, {1.1, 1.5}, Filling::window});
  }
  add_wall(objects, behind);
  objects.push_back({upright_box({-28.4, -17.6, 3.8}, {-24.9, 16.6, 4.0}),
                     {.material = SiteMaterial::plaster, .tint = k_cream}});
  objects.push_back({upright_box({-28.4, -17.5, -0.1}, {-24.35, 16.5, 0.1}),
                     {.material = SiteMaterial::stone, .tint = {0.68, 0.64, 0.58}, .seed = 17}});

  WallPlan west{.left = {-33, 21}, .right = {-33, -26}, .base = -1.0, .top = k_eaves, .tint = k_white};
  WallPlan south{.left = {-33, -26}, .right = {-24.5, -26}, .base = -1.0, .top = k_eaves, .tint = k_white};
  for (const double bottom : {1.05, 4.2}) {
    add_windows(west, 10, 5.0, 46.0, bottom, {1.1, 1.55});
    add_windows(south, 2, 0.8, 7.7, bottom, {1.1, 1.55});
  }
  add_wall(objects, west);
  add_wall(objects, south);
  add_roof(objects, {.min = {-33, -26},
                     .max = {-24.5, 21},
                     .ridge_along_x = false,
                     .eaves = k_eaves,
                     .ridge = 9.9,
                     .tint = k_red_tile,
                     .gable_tint = k_white});
  add_chimney(objects, {-29.8, 3.0}, 8.8, 11.2);
}

/// x -24.5 .. 24.5, y -26 .. -17.5, with the gateway at x = -5.
void add_south_wing(Objects& objects) {
  constexpr double k_eaves = 6.1, k_gate_x = -5.0, k_gate_width = 4.2, k_gate_crown = 4.3;
  WallPlan north{.left = {24.5, -17.5}, .right = {-24.5, -17.5}, .top = k_eaves, .tint = k_cream};
  add_windows(north, 7, 0.8, 26.0, 3.75, {1.1, 1.5});
  add_windows(north, 4, 33.0, 48.2, 3.75, {1.1, 1.5});
  add_windows(north, 3, 15.6, 26.0, 0.95, {1.1, 1.5});
  add_windows(north, 4, 33.0, 48.2, 0.95, {1.1, 1.5});
  for (const double u : {3.4, 7.6, 11.8})
    north.openings.push_back({u, 0.05, {2.8, 2.5}, Filling::door});  // garages
  north.openings.push_back({24.5 - k_gate_x, 0.0, {k_gate_width, k_gate_crown}, Filling::passage});
  north.door_tint = {0.33, 0.24, 0.17};
  add_wall(objects, north);
  WallPlan south{.left = {-24.5, -26}, .right = {24.5, -26}, .base = -1.0, .top = k_eaves, .tint = k_cream};
  for (const double bottom : {0.95, 3.75}) {
    add_windows(south, 4, 0.8, 16.0, bottom, {1.1, 1.5});
    add_windows(south, 7, 23.0, 48.2, bottom, {1.1, 1.5});
  }
  south.openings.push_back({24.5 + k_gate_x, 0.0, {k_gate_width, k_gate_crown}, Filling::passage});
  add_wall(objects, south);

  const double spring = k_gate_crown - 0.5 * k_gate_width;
  for (const double side : {-0.5, 0.5})
    objects.push_back(
        {shapes::Panel{
             {k_gate_x + side * k_gate_width, -26, -0.3}, {0, 1, 0}, {0, 0, 1}, {8.5, spring + 0.3}, {}},
         {.material = SiteMaterial::plaster, .tint = k_cream, .size = {0.0, 1.0}, .seed = 40}});
  shapes::Frustum vault =
      rod({k_gate_x, -26, spring}, {k_gate_x, -17.5, spring}, 0.5 * k_gate_width, 0.5 * k_gate_width);
  vault.keep = {0, 0, 1};
  objects.push_back({vault, {.material = SiteMaterial::trim, .tint = k_cream}});
  add_roof(objects, {.min = {-28.7, -26},
                     .max = {28.7, -17.5},
                     .ridge_along_x = true,
                     .eaves = k_eaves,
                     .ridge = 9.4,
                     .tint = k_red_tile,
                     .gable_tint = k_cream,
                     .gable_overhang = 0.0});
  add_chimney(objects, {9.0, -22.6}, 8.4, 10.8);
}

}  // namespace

void add_buildings(Objects& objects) {
  add_north_wing(objects);
  add_east_wing(objects);
  add_west_wing(objects);
  add_south_wing(objects);
}

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr dvec3 k_ochre(0.85, 0.70, 0.46), k_slate(0.40, 0.405, 0.43);

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

}  // namespace alidade::simulation::courtyard_parts
