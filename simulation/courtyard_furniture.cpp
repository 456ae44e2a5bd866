// SPDX-License-Identifier: MIT
#include <glm/geometric.hpp>

#include "simulation/courtyard_parts.h"

namespace alidade::courtyard_parts {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr dvec3 k_up(0.0, 0.0, 1.0);
constexpr dvec3 k_iron(0.17, 0.18, 0.18);

void add_fountain(Objects& objects, const dvec2& place) {
  const dvec3 foot(place, 0.0);
  const auto at = [&](double height) { return foot + height * k_up; };
  const Finish stone{.material = SiteMaterial::stone, .tint = {0.72, 0.69, 0.63}, .seed = 101};
  const Finish water{.material = SiteMaterial::water, .seed = 102};
  objects.push_back({rod(at(-0.1), at(0.55), 2.55, 2.5), stone});
  objects.push_back({rod(at(0.55), at(0.68), 2.68, 2.68), stone});
  objects.push_back({shapes::Disc{at(0.55), k_up, 2.68, 2.45}, stone});
  objects.push_back({shapes::Disc{at(0.68), k_up, 2.68, 2.2}, stone});
  objects.push_back({rod(at(0.3), at(0.68), 2.2, 2.2), stone});
  objects.push_back({shapes::Disc{at(0.5), k_up, 2.2, 0.0}, water});
  objects.push_back({rod(at(0.3), at(0.8), 0.5, 0.3), stone});
  objects.push_back({rod(at(0.8), at(1.6), 0.24, 0.2), stone});
  objects.push_back({rod(at(1.55), at(1.95), 0.22, 1.1), stone});
  objects.push_back({shapes::Disc{at(1.95), k_up, 1.1, 0.98}, stone});
  objects.push_back({shapes::Disc{at(1.91), k_up, 0.99, 0.0}, water});
  objects.push_back({rod(at(1.9), at(2.5), 0.16, 0.11), stone});
  objects.push_back({shapes::Sphere{at(2.68), 0.24}, stone});
}

/// A slatted bench that faces `forward`.
void add_bench(Objects& objects, const dvec2& place, const dvec2& forward) {
  const Finish wood{.material = SiteMaterial::wood, .tint = {0.56, 0.39, 0.24}, .seed = 110};
  const Finish iron{.material = SiteMaterial::metal, .tint = k_iron};
  const auto at = [&](double ahead, double sideways, double height) {
    return dvec3(place + ahead * forward + sideways * dvec2(-forward.y, forward.x), height);
  };
  for (const double ahead : {-0.2, -0.06, 0.08, 0.22})
    objects.push_back({turned_box(at(ahead, 0.0, 0.45), forward, {0.06, 0.9, 0.02}), wood});
  for (const double height : {0.62, 0.77, 0.92})
    objects.push_back(
        {turned_box(at(-0.30 - 0.1 * (height - 0.6), 0.0, height), forward, {0.018, 0.9, 0.055}), wood});
  for (const double side : {-0.7, 0.7}) {
    objects.push_back({turned_box(at(0.0, side, 0.215), forward, {0.24, 0.03, 0.215}), iron});
    objects.push_back({turned_box(at(-0.335, side, 0.5), forward, {0.02, 0.03, 0.5}), iron});
  }
}

void add_lamp_post(Objects& objects, const dvec2& place) {
  const Finish iron{.material = SiteMaterial::metal, .tint = k_iron};
  const dvec3 foot(place, 0.0);
  const auto at = [&](double height) { return foot + height * k_up; };
  objects.push_back({rod(at(-0.1), at(0.7), 0.13, 0.10), iron});
  objects.push_back({rod(at(0.7), at(3.6), 0.065, 0.045), iron});
  objects.push_back({rod(at(3.6), at(3.72), 0.05, 0.16), iron});
  objects.push_back({rod(at(3.72), at(4.12), 0.14, 0.21),
                     {.material = SiteMaterial::lamp_glass, .tint = {0.88, 0.86, 0.78}}});
  objects.push_back({rod(at(4.12), at(4.36), 0.27, 0.05), iron});
  objects.push_back({shapes::Disc{at(4.12), k_up, 0.27, 0.0}, iron});
  objects.push_back({shapes::Sphere{at(4.4), 0.06}, iron});
}

void add_barrel(Objects& objects, const dvec2& place) {
  const Finish wood{.material = SiteMaterial::wood, .tint = {0.50, 0.36, 0.24}, .seed = 120};
  const Finish hoop{.material = SiteMaterial::metal, .tint = {0.30, 0.28, 0.26}};
  const auto at = [&](double height) { return dvec3(place, height); };
  objects.push_back({rod(at(0.0), at(0.45), 0.30, 0.36), wood});
  objects.push_back({rod(at(0.45), at(0.90), 0.36, 0.30), wood});
  objects.push_back({shapes::Disc{at(0.87), k_up, 0.31, 0.0}, wood});
  for (const double height : {0.14, 0.70})
    objects.push_back({rod(at(height), at(height + 0.06), 0.345, 0.345), hoop});
}

/// A stone ball on a low block.
void add_stone_ball(Objects& objects, const dvec2& place) {
  const Finish stone{.material = SiteMaterial::stone, .tint = {0.68, 0.66, 0.62}, .seed = 130};
  objects.push_back(
      {upright_box({place.x - 0.36, place.y - 0.36, -0.1}, {place.x + 0.36, place.y + 0.36, 0.4}), stone});
  objects.push_back({shapes::Sphere{{place.x, place.y, 0.78}, 0.40}, stone});
}

/// The white sphere surveyors join their stations by, on a pole.
void add_target(Objects& objects, const dvec2& place) {
  objects.push_back({rod({place, 0.0}, {place, 1.3}, 0.02, 0.02),
                     {.material = SiteMaterial::metal, .tint = {0.55, 0.55, 0.56}}});
  objects.push_back(
      {shapes::Sphere{{place, 1.4}, 0.1}, {.material = SiteMaterial::target, .tint = dvec3(0.95)}});
}

}  // namespace

void add_furniture(Objects& objects) {
  add_fountain(objects, {0.0, -0.5});
  constexpr double k_diagonal = 0.70710678118654752;
  for (const dvec2 direction : {dvec2(k_diagonal, k_diagonal), dvec2(-k_diagonal, k_diagonal),
                                dvec2(-k_diagonal, -k_diagonal), dvec2(k_diagonal, -k_diagonal)})
    add_bench(objects, dvec2(0.0, -0.5) + 6.0 * direction, -direction);
  add_bench(objects, {-23.6, 2.0}, {1.0, 0.0});
  for (const dvec2 place : {dvec2(-8.6, -13.0), dvec2(1.6, -13.0), dvec2(-8.0, 13.9), dvec2(8.0, 13.9),
                            dvec2(-30.0, -31.2), dvec2(2.0, -31.2), dvec2(34.0, -31.2)})
    add_lamp_post(objects, place);
  for (const dvec2 place : {dvec2(-23.5, -11.6), dvec2(-22.9, -12.2), dvec2(-23.7, -12.5)})
    add_barrel(objects, place);
  for (const double x : {-7.9, -2.1}) {
    add_stone_ball(objects, {x, -16.8});
    add_stone_ball(objects, {x, -26.8});
  }
  for (const dvec2 place : {dvec2(5.6, 10.4), dvec2(-17.5, 0.5), dvec2(9.0, -6.0), dvec2(20.5, 1.6)})
    add_target(objects, place);
}

}  // namespace alidade::courtyard_parts
