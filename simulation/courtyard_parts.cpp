// SPDX-License-Identifier: MIT
#include "simulation/courtyard_parts.h"

#include <glm/geometric.hpp>
#include <utility>

#include "simulation/noise.h"

namespace alidade::simulation::courtyard_parts {

using glm::dmat3;
using glm::dvec2;
using glm::dvec3;

namespace {

const Finish k_trim{.material = SiteMaterial::trim, .tint = {0.80, 0.755, 0.675}};

std::uint32_t seed_of(const dvec3& position) {
  return static_cast<std::uint32_t>(cell_noise(16.0 * (position.x + 7.0 * position.z), 16.0 * position.y, 5) *
                                    4294967295.0);
}

/// A wall's own frame: u along it, v up, `outward` away from the house.
struct WallFrame {
  dvec3 corner, along, outward;

  /// A box that covers [u_min, u_max] x [z_min, z_max] and reaches from `behind` to
  /// `front` of the wall's face.
  shapes::Box box(double u_min, double u_max, double z_min, double z_max, double behind, double front) const {
    const dvec3 face = corner + 0.5 * (u_min + u_max) * along;
    const dvec3 center = dvec3(face.x, face.y, 0.5 * (z_min + z_max)) + 0.5 * (front - behind) * outward;
    return {center, dmat3(along, k_up, outward),
            dvec3(0.5 * (u_max - u_min), 0.5 * (z_max - z_min), 0.5 * (front + behind))};
  }
};

void add_niche(Objects& objects, const WallPlan& plan, const WallFrame& frame, const WallOpening& opening) {
  constexpr double k_depth = 0.22;
  constexpr double k_lap = 0.002;  // wider than the hole, so that no ray slips between them
  const bool is_door = opening.filling == Filling::door;
  const double u_min = opening.u - 0.5 * opening.size.x, u_max = opening.u + 0.5 * opening.size.x;
  const shapes::Box box = frame.box(u_min - k_lap, u_max + k_lap, opening.bottom - k_lap,
                                    opening.bottom + opening.size.y + k_lap, k_depth, 0.0);
  objects.push_back({shapes::Niche{box},
                     {.material = is_door ? SiteMaterial::door : SiteMaterial::window,
                      .tint = is_door ? plan.door_tint : plan.tint,
                      .size = opening.size,
                      .seed = seed_of(box.center)}});
}

void add_frame(Objects& objects, const WallFrame& frame, const WallOpening& opening) {
  constexpr double k_width = 0.14, k_front = 0.035;
  const double left = opening.u - 0.5 * opening.size.x, right = opening.u + 0.5 * opening.size.x;
  const double bottom = opening.bottom, top = opening.bottom + opening.size.y;
  objects.push_back({frame.box(left - k_width, left, bottom, top, 0.0, k_front), k_trim});
  objects.push_back({frame.box(right, right + k_width, bottom, top, 0.0, k_front), k_trim});
  objects.push_back(
      {frame.box(left - k_width, right + k_width, top, top + 1.3 * k_width, 0.0, 1.6 * k_front), k_trim});
  // Sill of a window, step of a door.
  const bool is_window = opening.filling == Filling::window;
  const double beside = is_window ? 1.3 * k_width : 0.25, height = is_window ? 0.09 : 0.6;
  objects.push_back(
      {frame.box(left - beside, right + beside, bottom - height, bottom, 0.0, is_window ? 0.13 : 0.55),
       k_trim});
}

void add_shutters(Objects& objects, const WallPlan& plan, const WallFrame& frame,
                  const WallOpening& opening) {
  const double half = 0.5 * opening.size.x, leaf_width = half - 0.02, gap = 0.15;
  const double top = opening.bottom + opening.size.y;
  for (const double left : {opening.u - half - gap - leaf_width, opening.u + half + gap}) {
    const shapes::Box box =
        frame.box(left, left + leaf_width, opening.bottom + 0.02, top - 0.02, -0.02, 0.06);
    objects.push_back(
        {box, {.material = SiteMaterial::wood, .tint = plan.shutter_tint, .seed = seed_of(box.center)}});
  }
}

}  // namespace

shapes::Box upright_box(const dvec3& min, const dvec3& max) {
  return {0.5 * (min + max), dmat3(1.0), 0.5 * (max - min)};
}

shapes::Box turned_box(const dvec3& center, const dvec2& forward, const dvec3& half_size) {
  return {center, dmat3(dvec3(forward.x, forward.y, 0.0), dvec3(-forward.y, forward.x, 0.0), k_up),
          half_size};
}

shapes::Frustum rod(const dvec3& from, const dvec3& to, double from_radius, double to_radius) {
  const double length = glm::length(to - from);
  return {from, (to - from) / length, length, from_radius, to_radius, dvec3(0.0)};
}

void add_wall(Objects& objects, const WallPlan& plan) {
  const dvec2 run = plan.right - plan.left;
  const double width = glm::length(run);
  const dvec3 along(run.x / width, run.y / width, 0.0);
  const WallFrame frame{{plan.left.x, plan.left.y, plan.base}, along, glm::cross(along, k_up)};

  shapes::Panel panel{frame.corner, along, k_up, {width, plan.top - plan.base}, {}};
  for (const WallOpening& opening : plan.openings) {
    const double bottom = opening.bottom - plan.base;
    const dvec2 half(0.5 * opening.size.x, 0.0);
    panel.openings.push_back({dvec2(opening.u, bottom) - half,
                              dvec2(opening.u, bottom + opening.size.y) + half,
                              opening.filling == Filling::passage});
    if (opening.filling == Filling::passage) continue;
    add_niche(objects, plan, frame, opening);
    add_frame(objects, frame, opening);
    if (plan.shutters && opening.filling == Filling::window) add_shutters(objects, plan, frame, opening);
  }
  objects.push_back({std::move(panel),
                     {.material = SiteMaterial::plaster,
                      .tint = plan.tint,
                      .size = {0.0, plan.plinth - plan.base},
                      .seed = seed_of(frame.corner)}});
  if (!plan.cornice) return;
  objects.push_back({frame.box(0.0, width, plan.top - 0.34, plan.top - 0.10, 0.0, 0.10), k_trim});
  objects.push_back({frame.box(0.0, width, plan.top - 0.10, plan.top, 0.0, 0.20), k_trim});
}

void add_roof(Objects& objects, const RoofPlan& plan) {
  constexpr double k_thickness = 0.16, k_eaves_overhang = 0.55;
  const dvec3 min(plan.min, 0.0), max(plan.max, 0.0);
  const bool is_along_x = plan.run == Ridge::along_x;
  const dvec3 along(is_along_x, !is_along_x, 0), across(!is_along_x, is_along_x, 0);
  const double length = glm::dot(max - min, along);
  const double half_depth = 0.5 * glm::dot(max - min, across);
  const dvec3 middle = 0.5 * (min + max);
  const dvec3 ridge_middle = dvec3(middle.x, middle.y, plan.ridge);
  const double reach = 0.5 * length + plan.gable_overhang;

  for (const double side : {-1.0, 1.0}) {
    const dvec3 to_eaves = half_depth * side * across + dvec3(0, 0, plan.eaves - plan.ridge);
    const double slope_length = glm::length(to_eaves) + k_eaves_overhang;
    const dvec3 down = glm::normalize(to_eaves), up_slope = -down;
    dvec3 normal = glm::cross(along, up_slope);
    dvec3 sideways = along;
    if (normal.z < 0.0) normal = -normal, sideways = -along;
    const dvec3 center = ridge_middle + 0.5 * slope_length * down + 0.5 * k_thickness * normal;
    objects.push_back(
        {shapes::Box{
             center, dmat3(sideways, up_slope, normal), {reach, 0.5 * slope_length, 0.5 * k_thickness}},
         {.material = SiteMaterial::roof_tile, .tint = plan.tint, .seed = seed_of(center)}});
    const dvec3 eaves = ridge_middle + (slope_length + 0.05) * down;
    shapes::Frustum gutter = rod(eaves - reach * along, eaves + reach * along, 0.085, 0.085);
    gutter.keep = {0.0, 0.0, -1.0};
    objects.push_back({gutter, {.material = SiteMaterial::metal, .tint = {0.36, 0.31, 0.27}}});
  }
  const dvec3 crest = ridge_middle + dvec3(0, 0, 0.12);
  objects.push_back({rod(crest - reach * along, crest + reach * along, 0.14, 0.14),
                     {.material = SiteMaterial::trim, .tint = 0.88 * plan.tint}});
  for (const double end : {-1.0, 1.0}) {
    const dvec3 apex = ridge_middle + 0.5 * length * end * along;
    const dvec3 foot(apex.x, apex.y, plan.eaves);
    objects.push_back({shapes::Polygon{{foot - half_depth * across, foot + half_depth * across, apex}},
                       {.material = SiteMaterial::plaster, .tint = plan.gable_tint, .seed = seed_of(apex)}});
  }
}

void add_chimney(Objects& objects, const dvec2& position, double bottom, double top) {
  objects.push_back({upright_box({position.x - 0.45, position.y - 0.35, bottom},
                                 {position.x + 0.45, position.y + 0.35, top}),
                     {.material = SiteMaterial::brick, .tint = {0.56, 0.33, 0.26}, .seed = 3}});
  objects.push_back({upright_box({position.x - 0.53, position.y - 0.43, top},
                                 {position.x + 0.53, position.y + 0.43, top + 0.14}),
                     k_trim});
}

}  // namespace alidade::simulation::courtyard_parts
