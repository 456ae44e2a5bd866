// SPDX-License-Identifier: MIT
#include "simulation/courtyard_houses.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

// Each wall is given from left to right as seen from outside, so the outside is to the right of the direction
// from left to right.

namespace alidade::simulation::courtyard_parts {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr dvec3 k_yellow(0.90, 0.80, 0.575), k_rose(0.86, 0.64, 0.53), k_cream(0.91, 0.865, 0.76),
    k_white(0.90, 0.885, 0.84), k_ochre(0.85, 0.70, 0.46);
constexpr dvec3 k_red_tile(0.605, 0.375, 0.285), k_brown_tile(0.50, 0.335, 0.275), k_slate(0.40, 0.405, 0.43);
const Finish k_stone{.material = SiteMaterial::trim, .tint = {0.80, 0.755, 0.675}};

using Openings = std::vector<WallOpening>;

/// `count` windows evenly over [from, to] of a wall.
struct WindowRow {
  int count;
  double from, to;
};

/// All rows of windows at each height.
Openings windows(std::initializer_list<double> bottoms, const dvec2& size,
                 std::initializer_list<WindowRow> rows) {
  Openings openings;
  for (const double bottom : bottoms)
    for (const WindowRow& row : rows)
      for (int i = 0; i < row.count; ++i)
        openings.push_back({row.from + (row.to - row.from) * (i + 0.5) / row.count, bottom, size});
  return openings;
}

Openings operator+(Openings first, const Openings& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// A plain wall from `base` up to `top`.
WallPlan wall(const dvec2& left, const dvec2& right, double base, double top, const dvec3& tint,
              Openings openings = {}) {
  return {
      .left = left, .right = right, .base = base, .top = top, .tint = tint, .openings = std::move(openings)};
}

/// A dormer on a roof slope that falls to the south: its front is at `position`, the rest is partly
/// inside the roof behind it.
void add_dormer(Objects& objects, const dvec2& position, double bottom) {
  constexpr double k_half = 0.85, k_height = 1.5, k_depth = 3.0;
  const double left = position.x - k_half, right = position.x + k_half, eaves = bottom + k_height;
  WallPlan front = wall({left, position.y}, {right, position.y}, bottom, eaves, k_cream);
  front.openings = {{k_half, bottom + 0.25, {0.85, 1.1}}};
  front.plinth = bottom;
  front.cornice = false;
  add_wall(objects, front);
  for (const double x : {left, right})
    objects.push_back({shapes::Panel{{x, position.y, bottom}, {0, 1, 0}, {0, 0, 1}, {k_depth, k_height}, {}},
                       {.material = SiteMaterial::plaster, .tint = k_cream}});
  add_roof(objects, {{left, position.y},
                     {right, position.y + k_depth},
                     Ridge::along_y,
                     eaves,
                     eaves + 0.8,
                     k_red_tile,
                     k_cream,
                     0.2});
}

/// x -33 .. 33, y 16.5 .. 26: the main house.
void add_north_wing(Objects& objects) {
  constexpr double k_eaves = 8.9;
  WallPlan south = wall({-33, 16.5}, {33, 16.5}, 0.0, k_eaves, k_yellow);
  south.shutters = true;
  for (const double bottom : {1.05, 4.05, 6.75}) {
    const dvec2 size = bottom > 6.0 ? dvec2(1.05, 1.35) : dvec2(1.1, 1.75);
    south.openings = south.openings + windows({bottom}, size, {{7, 9.0, 30.2}, {7, 35.8, 57.0}});
    if (bottom > 2.0) south.openings.push_back({33.0, bottom, {1.5, size.y}});
  }
  south.openings.push_back({33.0, 0.6, {1.9, 2.6}, Filling::door});
  add_wall(objects, south);
  for (int step = 0; step < 3; ++step)
    objects.push_back({upright_box({-2.2 - 0.35 * step, 15.6 - 0.35 * step, -0.1},
                                   {2.2 + 0.35 * step, 16.5, 0.6 - 0.2 * step}),
                       {.material = SiteMaterial::stone, .tint = {0.70, 0.67, 0.61}, .seed = 9}});
  // A small canopy on two columns above the steps.
  for (const double x : {-1.75, 1.75})
    objects.push_back({rod({x, 15.85, 0.6}, {x, 15.85, 3.5}, 0.17, 0.14), k_stone});
  objects.push_back({upright_box({-2.15, 15.35, 3.5}, {2.15, 16.5, 3.85}), k_stone});

  const auto outside = [&](const dvec2& left, const dvec2& right, const WindowRow& row) {
    const Openings openings = windows({1.05, 4.05, 6.75}, {1.1, 1.5}, {row});
    add_wall(objects, wall(left, right, -1.0, k_eaves, k_yellow, openings));
  };
  outside({33, 26}, {-33, 26}, {14, 2.0, 64.0});
  outside({33, 16.5}, {33, 26}, {2, 1.5, 8.0});
  outside({-33, 26}, {-33, 16.5}, {2, 1.5, 8.0});
  add_roof(objects, {{-33, 16.5}, {33, 26}, Ridge::along_x, k_eaves, 12.4, k_red_tile, k_yellow});
  for (const double x : {-19.0, -9.5, 0.0, 9.5, 19.0}) add_dormer(objects, {x, 17.6}, 9.55);
  add_chimney(objects, {-24.0, 22.0}, 10.5, 13.6);
  add_chimney(objects, {5.0, 22.3}, 10.5, 13.6);
  add_chimney(objects, {26.0, 20.4}, 10.5, 13.4);
}

/// x 24.5 .. 33, y -26 .. 21.
void add_east_wing(Objects& objects) {
  constexpr double k_eaves = 7.3;
  WallPlan west = wall({24.5, 16.5}, {24.5, -17.5}, 0.0, k_eaves, k_rose);
  west.openings = windows({4.3}, {1.1, 1.65}, {{9, 0.6, 33.4}}) +
                  windows({1.05}, {1.1, 1.6}, {{4, 0.6, 15.2}, {4, 18.8, 33.4}}) +
                  Openings{{17.0, 0.12, {1.5, 2.5}, Filling::door}};
  west.door_tint = {0.20, 0.30, 0.24};
  add_wall(objects, west);
  const auto outside = [&](const dvec2& left, const dvec2& right, const WindowRow& row) {
    add_wall(objects, wall(left, right, -1.0, k_eaves, k_rose, windows({1.05, 4.3}, {1.1, 1.6}, {row})));
  };
  outside({33, -26}, {33, 21}, {10, 1.0, 42.0});
  outside({24.5, -26}, {33, -26}, {2, 0.8, 7.7});
  add_roof(objects, {{24.5, -26}, {33, 21}, Ridge::along_y, k_eaves, 10.7, k_brown_tile, k_rose});
  add_chimney(objects, {29.6, -12.0}, 9.5, 12.0);
  add_chimney(objects, {27.8, 6.0}, 9.5, 12.0);
}

/// The half cylinder over a passage whose wall ends at `from`.
void add_vault(Objects& objects, const dvec3& from, const dvec3& to, double radius, const Finish& finish) {
  shapes::Frustum vault = rod(from, to, radius, radius);
  vault.keep = {0, 0, 1};
  objects.push_back({vault, finish});
}

/// An arched wall in two skins with reveals between, so that the arcade has pillars of some thickness.
void add_arcade(Objects& objects, double x, double thickness, double from, double to, int arches,
                double width, double crown) {
  const double spring = crown - 0.5 * width, inner = x - thickness;
  WallPlan back = wall({inner, to}, {inner, from}, -0.1, 3.9, k_white);
  back.cornice = false;
  for (int i = 0; i < arches; ++i) {
    const double pitch = (to - from) / arches, y = from + pitch * (i + 0.5);
    back.openings.push_back({to - y, -0.1, {width, crown + 0.1}, Filling::passage});
    for (const double side : {-0.5, 0.5})
      objects.push_back(
          {shapes::Panel{
               {inner, y + side * width, -0.1}, {1, 0, 0}, {0, 0, 1}, {thickness, spring + 0.1}, {}},
           k_stone});
    add_vault(objects, {inner, y, spring}, {x, y, spring}, 0.5 * width, k_stone);
    // Imposts: the little ledges the arches spring from.
    for (const double side : {-1.0, 1.0}) {
      const double near = y + side * (0.5 * width - 0.05), far = y + side * (0.5 * width + 0.16);
      objects.push_back({upright_box({inner - 0.04, std::min(near, far), spring - 0.16},
                                     {x + 0.06, std::max(near, far), spring}),
                         k_stone});
    }
  }
  add_wall(objects, back);
}

/// x -33 .. -24.5, y -26 .. 21: an arcade to the yard below, windows above.
void add_west_wing(Objects& objects) {
  constexpr double k_eaves = 6.6, k_crown = 3.1, k_width = 2.7;
  constexpr int k_arches = 9;
  WallPlan east = wall({-24.5, -17.5}, {-24.5, 16.5}, -0.1, k_eaves, k_white);
  WallPlan behind = wall({-28.3, -17.5}, {-28.3, 16.5}, -0.1, 3.9, k_cream);
  east.openings = windows({4.2}, {1.1, 1.55}, {{k_arches, 0.0, 34.0}});
  east.plinth = -0.1;
  behind.cornice = false;
  for (int i = 0; i < k_arches; ++i) {
    const double u = 34.0 / k_arches * (i + 0.5);
    east.openings.push_back({u, -0.1, {k_width, k_crown + 0.1}, Filling::passage});
    behind.openings.push_back(i % 3 == 1 ? WallOpening{u, 0.1, {1.3, 2.4}, Filling::door}
                                         : WallOpening{u, 1.0, {1.1, 1.5}});
  }
  add_wall(objects, east);
  add_arcade(objects, -24.5, 0.55, -17.5, 16.5, k_arches, k_width, k_crown);
  add_wall(objects, behind);
  objects.push_back({upright_box({-28.4, -17.6, 3.8}, {-24.9, 16.6, 4.0}),
                     {.material = SiteMaterial::plaster, .tint = k_cream}});
  objects.push_back({upright_box({-28.4, -17.5, -0.1}, {-24.35, 16.5, 0.1}),
                     {.material = SiteMaterial::stone, .tint = {0.68, 0.64, 0.58}, .seed = 17}});
  const auto outside = [&](const dvec2& left, const dvec2& right, const WindowRow& row) {
    add_wall(objects, wall(left, right, -1.0, k_eaves, k_white, windows({1.05, 4.2}, {1.1, 1.55}, {row})));
  };
  outside({-33, 21}, {-33, -26}, {10, 5.0, 46.0});
  outside({-33, -26}, {-24.5, -26}, {2, 0.8, 7.7});
  add_roof(objects, {{-33, -26}, {-24.5, 21}, Ridge::along_y, k_eaves, 9.9, k_red_tile, k_white});
  add_chimney(objects, {-29.8, 3.0}, 8.8, 11.2);
}

/// x -24.5 .. 24.5, y -26 .. -17.5, with the gateway at x = -5.
void add_south_wing(Objects& objects) {
  constexpr double k_eaves = 6.1, k_gate_x = -5.0, k_gate_width = 4.2, k_gate_crown = 4.3;
  const auto gate = [&](double u) {
    return Openings{{u, 0.0, {k_gate_width, k_gate_crown}, Filling::passage}};
  };
  WallPlan north = wall({24.5, -17.5}, {-24.5, -17.5}, 0.0, k_eaves, k_cream);
  north.openings = windows({3.75}, {1.1, 1.5}, {{7, 0.8, 26.0}, {4, 33.0, 48.2}}) +
                   windows({0.95}, {1.1, 1.5}, {{3, 15.6, 26.0}, {4, 33.0, 48.2}});
  for (const double u : {3.4, 7.6, 11.8})
    north.openings.push_back({u, 0.05, {2.8, 2.5}, Filling::door});  // garages
  north.openings = north.openings + gate(24.5 - k_gate_x);
  north.door_tint = {0.33, 0.24, 0.17};
  add_wall(objects, north);
  add_wall(objects, wall({-24.5, -26}, {24.5, -26}, -1.0, k_eaves, k_cream,
                         windows({0.95, 3.75}, {1.1, 1.5}, {{4, 0.8, 16.0}, {7, 23.0, 48.2}}) +
                             gate(24.5 + k_gate_x)));

  const double spring = k_gate_crown - 0.5 * k_gate_width;
  for (const double side : {-0.5, 0.5})
    objects.push_back(
        {shapes::Panel{
             {k_gate_x + side * k_gate_width, -26, -0.3}, {0, 1, 0}, {0, 0, 1}, {8.5, spring + 0.3}, {}},
         {.material = SiteMaterial::plaster, .tint = k_cream, .size = {0.0, 1.0}, .seed = 40}});
  add_vault(objects, {k_gate_x, -26, spring}, {k_gate_x, -17.5, spring}, 0.5 * k_gate_width,
            {.material = SiteMaterial::trim, .tint = k_cream});
  add_roof(objects, {{-28.7, -26}, {28.7, -17.5}, Ridge::along_x, k_eaves, 9.4, k_red_tile, k_cream, 0.0});
  add_chimney(objects, {9.0, -22.6}, 8.4, 10.8);
}

/// A plain house with windows on all sides.
struct House {
  dvec2 min, max;
  Ridge run;
  double eaves, ridge;
  dvec3 tint, tiles;
};

void add_house(Objects& objects, const House& house) {
  const auto& [min, max, run, eaves, ridge, tint, tiles] = house;
  const dvec2 corners[] = {min, {max.x, min.y}, max, {min.x, max.y}};
  for (int side = 0; side < 4; ++side) {
    WallPlan plan = wall(corners[side], corners[(side + 1) % 4], -2.5, eaves, tint);
    plan.plinth = 0.9;
    const double width = glm::length(plan.right - plan.left);
    const WindowRow row{static_cast<int>(width / 3.1), 0.6, width - 0.6};
    for (double bottom = 1.5; bottom + 1.9 < eaves; bottom += 3.0)
      plan.openings = plan.openings + windows({bottom}, {1.1, 1.45}, {row});
    add_wall(objects, plan);
  }
  add_roof(objects, {min, max, run, eaves, ridge, tiles, tint});
  add_chimney(objects, 0.5 * (min + max) + dvec2(0.8, 0.8), ridge - 1.5, ridge + 1.0);
}

}  // namespace

void add_buildings(Objects& objects) {
  add_north_wing(objects);
  add_east_wing(objects);
  add_west_wing(objects);
  add_south_wing(objects);
}

void add_neighbours(Objects& objects) {
  // Across the street, and neighbours to both sides.
  const House houses[] = {{{-58, -53}, {-38, -45.5}, Ridge::along_x, 7.0, 10.0, k_ochre, k_brown_tile},
                          {{-34, -53}, {-12, -45.5}, Ridge::along_x, 8.6, 11.8, k_cream, k_red_tile},
                          {{-9, -53}, {9, -45.5}, Ridge::along_x, 7.6, 11.0, k_rose, k_slate},
                          {{14, -53}, {40, -45.5}, Ridge::along_x, 6.4, 9.6, k_white, k_red_tile},
                          {{46, -18}, {57, -2}, Ridge::along_y, 6.2, 9.8, k_ochre, k_red_tile},
                          {{-58, 8}, {-47, 26}, Ridge::along_y, 6.2, 9.6, k_cream, k_brown_tile}};
  for (const House& house : houses) add_house(objects, house);
}

}  // namespace alidade::simulation::courtyard_parts
