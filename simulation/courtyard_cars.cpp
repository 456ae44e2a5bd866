// SPDX-License-Identifier: MIT
#include <glm/geometric.hpp>
#include <utility>

#include "simulation/courtyard_parts.h"

namespace alidade::courtyard_parts {

using glm::dvec2;
using glm::dvec3;

namespace {

/// A car's own frame: x ahead, y to the left, z up from the road.
struct CarFrame {
  dvec3 place;
  dvec3 ahead, left;

  dvec3 direction(const dvec3& v) const { return v.x * ahead + v.y * left + dvec3(0, 0, v.z); }
  dvec3 position(const dvec3& v) const { return place + direction(v); }
};

/// One side of the bodywork: through a place, facing along a normal of any length, both in the car's frame.
struct Side {
  dvec3 through, normal;
};

shapes::ConvexSolid bodywork(const CarFrame& frame, const std::vector<Side>& sides, const dvec3& min,
                             const dvec3& max) {
  shapes::ConvexSolid solid;
  for (const Side& side : sides) {
    const dvec3 normal = frame.direction(glm::normalize(side.normal));
    solid.sides.push_back({normal, glm::dot(normal, frame.position(side.through))});
  }
  for (const double x : {min.x, max.x})
    for (const double y : {min.y, max.y})
      for (const double z : {min.z, max.z}) solid.bounds.grow(frame.position({x, y, z}));
  return solid;
}

void add_wheel(Objects& objects, const CarFrame& frame, double x, double side) {
  constexpr double k_radius = 0.33;
  const auto at = [&](double y) { return frame.position({x, side * y, k_radius}); };
  const dvec3 outward = side * frame.left;
  const Finish tyre{.material = SiteMaterial::tyre};
  objects.push_back({rod(at(0.66), at(0.905), k_radius, k_radius), tyre});
  objects.push_back({shapes::Disc{at(0.905), outward, k_radius, 0.0}, tyre});
  objects.push_back({shapes::Disc{at(0.66), outward, k_radius, 0.0},
                     {.material = SiteMaterial::car_body, .tint = dvec3(0.08)}});
  objects.push_back({shapes::Disc{at(0.893), outward, 0.395, 0.0},
                     {.material = SiteMaterial::car_body, .tint = dvec3(0.07)}});
}

void add_car(Objects& objects, const dvec3& place, const dvec2& forward, const dvec3& tint) {
  const CarFrame frame{place, dvec3(forward, 0.0), dvec3(-forward.y, forward.x, 0.0)};
  std::vector<Side> body = {{{0, 0, 0.24}, {0, 0, -1}},        {{0, 0, 0.93}, {0, 0, 1}},
                            {{2.18, 0, 0.5}, {1, 0, 0.10}},    {{2.18, 0, 0.45}, {0.8, 0, -0.6}},
                            {{1.05, 0, 0.93}, {0.11, 0, 1}},   {{2.08, 0, 0.76}, {0.7, 0, 0.7}},
                            {{-2.15, 0, 0.6}, {-1, 0, 0.06}},  {{-2.15, 0, 0.42}, {-0.8, 0, -0.6}},
                            {{-2.08, 0, 0.88}, {-0.7, 0, 0.7}}};
  std::vector<Side> cabin = {{{0, 0, 0.85}, {0, 0, -1}},          {{0, 0, 1.46}, {0, 0, 1}},
                             {{1.08, 0, 0.90}, {0.70, 0, 0.714}}, {{-1.95, 0, 0.90}, {-0.84, 0, 0.54}},
                             {{0.30, 0, 1.44}, {0.25, 0, 0.96}},  {{-1.1, 0, 1.43}, {-0.22, 0, 0.97}}};
  for (const double side : {-1.0, 1.0}) {
    body.push_back({{0, side * 0.89, 0.55}, {0, side, 0}});
    body.push_back({{0, side * 0.89, 0.50}, {0, side * 0.97, -0.24}});
    body.push_back({{0, side * 0.88, 0.80}, {0, side * 0.85, 0.52}});
    body.push_back({{2.16, side * 0.60, 0.5}, {0.72, side * 0.69, 0}});
    body.push_back({{-2.13, side * 0.66, 0.5}, {-0.72, side * 0.69, 0}});
    cabin.push_back({{0, side * 0.80, 0.92}, {0, side * 0.93, 0.36}});
    cabin.push_back({{0, side * 0.52, 1.45}, {0, side * 0.32, 0.947}});
  }
  objects.push_back({bodywork(frame, body, {-2.25, -0.9, 0.2}, {2.25, 0.9, 0.95}),
                     {.material = SiteMaterial::car_body, .tint = tint}});
  objects.push_back({bodywork(frame, cabin, {-2.0, -0.9, 0.8}, {1.2, 0.9, 1.5}),
                     {.material = SiteMaterial::car_cabin, .tint = tint}});

  const Finish paint{.material = SiteMaterial::metal, .tint = 0.97 * tint};
  const Finish light{.material = SiteMaterial::metal, .tint = {0.88, 0.89, 0.88}},
      rear_light{.material = SiteMaterial::metal, .tint = {0.60, 0.08, 0.08}};
  const auto pillar = [&](const dvec3& foot, const dvec3& head, double radius) {
    objects.push_back({rod(frame.position(foot), frame.position(head), radius, radius), paint});
  };
  for (const double side : {-1.0, 1.0}) {
    add_wheel(objects, frame, 1.36, side);
    add_wheel(objects, frame, -1.34, side);
    pillar({1.06, side * 0.78, 0.91}, {0.50, side * 0.60, 1.42}, 0.035);
    pillar({-0.30, side * 0.805, 0.91}, {-0.34, side * 0.61, 1.43}, 0.04);
    pillar({-1.90, side * 0.77, 0.91}, {-1.50, side * 0.59, 1.41}, 0.06);
    pillar({0.50, side * 0.60, 1.42}, {-1.50, side * 0.59, 1.42}, 0.03);
    objects.push_back({shapes::Sphere{frame.position({2.03, side * 0.60, 0.66}), 0.115}, light});
    objects.push_back({shapes::Sphere{frame.position({-2.03, side * 0.64, 0.72}), 0.105}, rear_light});
    objects.push_back({shapes::Sphere{frame.position({0.78, side * 0.93, 0.98}), 0.085}, paint});
  }
  for (const double end : {2.17, -2.14})
    objects.push_back({turned_box(frame.position({end, 0.0, 0.50}), forward, {0.03, 0.26, 0.055}),
                       {.material = SiteMaterial::metal, .tint = dvec3(0.9)}});
}

}  // namespace

void add_cars(Objects& objects, const shapes::Ground& ground) {
  add_car(objects, {11.6, -9.0, 0.0}, {-0.6, 0.8}, {0.66, 0.12, 0.11});
  add_car(objects, {14.8, -3.4, 0.0}, {-0.28, -0.96}, {0.17, 0.30, 0.52});
  const dvec2 street(17.0, -33.4);
  add_car(objects, dvec3(street, shapes::height_at(ground, street).height), {-1.0, 0.0}, {0.80, 0.80, 0.79});
}

}  // namespace alidade::courtyard_parts
