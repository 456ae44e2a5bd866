// SPDX-License-Identifier: MIT
#include "simulation/courtyard.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "cloud/las/write_las.h"
#include "simulation/courtyard_houses.h"
#include "simulation/noise.h"

namespace alidade::simulation {

using namespace courtyard_parts;
using glm::dvec2;
using glm::dvec3;

namespace {

const glm::dvec3 k_origin(690000.0, 5325000.0, 600.0);

const Finish k_iron{.material = SiteMaterial::metal, .tint = {0.17, 0.18, 0.18}};

void add_fountain(Objects& objects, const dvec2& position) {
  const auto at = [&](double height) { return dvec3(position, height); };
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
void add_bench(Objects& objects, const dvec2& position, const dvec2& forward) {
  const Finish wood{.material = SiteMaterial::wood, .tint = {0.56, 0.39, 0.24}, .seed = 110};
  const auto at = [&](double ahead, double sideways, double height) {
    return dvec3(position + ahead * forward + sideways * dvec2(-forward.y, forward.x), height);
  };
  for (const double ahead : {-0.2, -0.06, 0.08, 0.22})
    objects.push_back({turned_box(at(ahead, 0.0, 0.45), forward, {0.06, 0.9, 0.02}), wood});
  for (const double height : {0.62, 0.77, 0.92})
    objects.push_back(
        {turned_box(at(-0.30 - 0.1 * (height - 0.6), 0.0, height), forward, {0.018, 0.9, 0.055}), wood});
  for (const double side : {-0.7, 0.7}) {
    objects.push_back({turned_box(at(0.0, side, 0.215), forward, {0.24, 0.03, 0.215}), k_iron});
    objects.push_back({turned_box(at(-0.335, side, 0.5), forward, {0.02, 0.03, 0.5}), k_iron});
  }
}

void add_lamp_post(Objects& objects, const dvec2& position) {
  const auto at = [&](double height) { return dvec3(position, height); };
  objects.push_back({rod(at(-0.1), at(0.7), 0.13, 0.10), k_iron});
  objects.push_back({rod(at(0.7), at(3.6), 0.065, 0.045), k_iron});
  objects.push_back({rod(at(3.6), at(3.72), 0.05, 0.16), k_iron});
  objects.push_back({rod(at(3.72), at(4.12), 0.14, 0.21),
                     {.material = SiteMaterial::lamp_glass, .tint = {0.88, 0.86, 0.78}}});
  objects.push_back({rod(at(4.12), at(4.36), 0.27, 0.05), k_iron});
  objects.push_back({shapes::Disc{at(4.12), k_up, 0.27, 0.0}, k_iron});
  objects.push_back({shapes::Sphere{at(4.4), 0.06}, k_iron});
}

void add_barrel(Objects& objects, const dvec2& position) {
  const Finish wood{.material = SiteMaterial::wood, .tint = {0.50, 0.36, 0.24}, .seed = 120};
  const Finish hoop{.material = SiteMaterial::metal, .tint = {0.30, 0.28, 0.26}};
  const auto at = [&](double height) { return dvec3(position, height); };
  objects.push_back({rod(at(0.0), at(0.45), 0.30, 0.36), wood});
  objects.push_back({rod(at(0.45), at(0.90), 0.36, 0.30), wood});
  objects.push_back({shapes::Disc{at(0.87), k_up, 0.31, 0.0}, wood});
  for (const double height : {0.14, 0.70})
    objects.push_back({rod(at(height), at(height + 0.06), 0.345, 0.345), hoop});
}

/// A stone ball on a low block.
void add_stone_ball(Objects& objects, const dvec2& position) {
  const Finish stone{.material = SiteMaterial::stone, .tint = {0.68, 0.66, 0.62}, .seed = 130};
  objects.push_back(
      {upright_box({position.x - 0.36, position.y - 0.36, -0.1}, {position.x + 0.36, position.y + 0.36, 0.4}),
       stone});
  objects.push_back({shapes::Sphere{{position.x, position.y, 0.78}, 0.40}, stone});
}

/// A white sphere on a pole, with which surveyors register their stations.
void add_target(Objects& objects, const dvec2& position) {
  objects.push_back({rod({position, 0.0}, {position, 1.3}, 0.02, 0.02),
                     {.material = SiteMaterial::metal, .tint = {0.55, 0.55, 0.56}}});
  objects.push_back(
      {shapes::Sphere{{position, 1.4}, 0.1}, {.material = SiteMaterial::target, .tint = dvec3(0.95)}});
}

/// A car's own frame: x ahead, y to the left, z up from the road.
struct CarFrame {
  dvec3 origin;
  dvec3 ahead, left;

  dvec3 direction(const dvec3& v) const { return v.x * ahead + v.y * left + dvec3(0, 0, v.z); }
  dvec3 position(const dvec3& v) const { return origin + direction(v); }
};

/// One side of the bodywork: a point of its plane and a normal of any length, in the car's frame.
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
  const auto dark = [](double shade) {
    return Finish{.material = SiteMaterial::car_body, .tint = dvec3(shade)};
  };
  objects.push_back({rod(at(0.66), at(0.905), k_radius, k_radius), tyre});
  objects.push_back({shapes::Disc{at(0.905), outward, k_radius, 0.0}, tyre});
  objects.push_back({shapes::Disc{at(0.66), outward, k_radius, 0.0}, dark(0.08)});
  objects.push_back({shapes::Disc{at(0.893), outward, 0.395, 0.0}, dark(0.07)});
}

void add_car(Objects& objects, const dvec3& position, const dvec2& forward, const dvec3& tint) {
  const CarFrame frame{position, dvec3(forward, 0.0), dvec3(-forward.y, forward.x, 0.0)};
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

/// A sequence of pseudo-random numbers.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : seed_(mix_bits(seed)) {}
  double between(double low, double high) { return low + (high - low) * unit_of(hash_of(seed_, counter_++)); }
  std::uint32_t bits() { return static_cast<std::uint32_t>(hash_of(seed_, counter_++) >> 32); }
  /// A direction, evenly distributed.
  dvec3 direction() {
    while (true) {
      const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
      const dvec3 in_cube(x, y, z);
      const double length_sq = glm::dot(in_cube, in_cube);
      if (length_sq <= 1.0 && length_sq > 1e-4) return glm::normalize(in_cube);
    }
  }

 private:
  std::uint64_t seed_, counter_ = 0;
};

struct TreePlan {
  dvec2 position{0.0};
  double height = 9.0, crown_radius = 3.0, trunk_radius = 0.22;
  int leaf_count = 2400;
  double leaf_radius = 0.15;
  dvec3 tint{0.33, 0.47, 0.17};
  std::uint32_t seed = 1;
};

/// A trunk, some branches, and a crown of leaves in clumps with gaps for beams between them.
void add_tree(Objects& objects, const TreePlan& plan, const shapes::Ground& ground) {
  Dice dice(plan.seed);
  const dvec3 foot(plan.position, shapes::height_at(ground, plan.position).height);
  const dvec3 crown = foot + dvec3(0, 0, 0.62 * plan.height);
  const dvec3 crown_radii(plan.crown_radius, plan.crown_radius, 0.36 * plan.height);

  // One draw per statement, since the order of evaluation within a statement is not defined.
  const double lean_x = dice.between(-0.2, 0.2);
  const double lean_y = dice.between(-0.2, 0.2);
  const dvec3 fork = foot + dvec3(lean_x, lean_y, 0.36 * plan.height);
  // Radii in units of the trunk's radius.
  const auto add_wood = [&](const dvec3& from, const dvec3& to, double from_radius, double to_radius) {
    const Finish bark{.material = SiteMaterial::bark, .tint = {0.40, 0.335, 0.27}, .seed = dice.bits()};
    objects.push_back({rod(from, to, from_radius * plan.trunk_radius, to_radius * plan.trunk_radius), bark});
  };
  add_wood(foot - dvec3(0, 0, 0.3), foot + dvec3(0, 0, 0.35), 1.7, 1.05);
  add_wood(foot + dvec3(0, 0, 0.3), fork, 1.05, 0.75);
  add_wood(fork, crown + dvec3(0, 0, 0.4 * crown_radii.z), 0.75, 0.15);

  struct Clump {
    dvec3 center;
    double radius;
  };
  constexpr int k_clump_count = 34, k_branch_count = 9;
  std::vector<Clump> clumps;
  for (int i = 0; i < k_clump_count; ++i) {
    const dvec3 outward = dice.direction();
    const double reach = dice.between(0.45, 0.82);
    clumps.push_back({crown + reach * outward * crown_radii, dice.between(0.26, 0.42) * plan.crown_radius});
  }
  for (int i = 0; i < k_branch_count; ++i)
    add_wood(fork + dvec3(0, 0, 0.12 * i), clumps[i].center, 0.42, 0.1);

  for (int i = 0; i < plan.leaf_count; ++i) {
    const Clump& clump = clumps[static_cast<std::size_t>(i % k_clump_count)];
    const dvec3 outward = dice.direction();
    // More leaves outside than inside.
    const double reach = std::max(dice.between(0.1, 1.0), dice.between(0.1, 1.0));
    const dvec3 position = clump.center + clump.radius * reach * outward;
    const dvec3 facing = glm::normalize(outward + 0.9 * dice.direction() + dvec3(0, 0, 0.5));
    const double height_share = (position.z - crown.z) / crown_radii.z;  // sunlit leaves on top are yellower
    const dvec3 tint = plan.tint * (1.0 + 0.10 * height_share);
    objects.push_back({shapes::Disc{position, facing, plan.leaf_radius * dice.between(0.7, 1.15), 0.0},
                       {.material = SiteMaterial::leaf, .tint = tint, .seed = dice.bits()}});
  }
}

void add_hedge(Objects& objects, const dvec2& min, const dvec2& max, double height) {
  objects.push_back({upright_box({min.x, min.y, -0.05}, {max.x, max.y, height}),
                     {.material = SiteMaterial::hedge, .tint = {0.25, 0.36, 0.15}, .seed = 70}});
}

/// A clipped ball in a pot.
void add_topiary(Objects& objects, const dvec2& position, double base) {
  const dvec3 foot(position, base);
  const Finish clay{.material = SiteMaterial::trim, .tint = {0.66, 0.40, 0.29}};
  objects.push_back({rod(foot, foot + dvec3(0, 0, 0.5), 0.24, 0.34), clay});
  objects.push_back({shapes::Disc{foot + dvec3(0, 0, 0.46), {0, 0, 1}, 0.33, 0.0},
                     {.material = SiteMaterial::bark, .tint = {0.28, 0.21, 0.15}}});
  objects.push_back({shapes::Ellipsoid{foot + dvec3(0, 0, 0.92), {0.46, 0.46, 0.50}},
                     {.material = SiteMaterial::hedge, .tint = {0.24, 0.38, 0.15}, .seed = 71}});
}

/// A bed of small leaves and flowers on the ground.
void add_flowers(Objects& objects, const dvec2& min, const dvec2& max, int count, std::uint32_t seed) {
  const dvec3 blossoms[] = {{0.80, 0.20, 0.22}, {0.93, 0.80, 0.30}, {0.93, 0.90, 0.90}, {0.66, 0.36, 0.66}};
  Dice dice(seed);
  for (int i = 0; i < count; ++i) {
    const double x = dice.between(min.x, max.x), y = dice.between(min.y, max.y), z = dice.between(0.08, 0.5);
    const bool blossom = z > 0.33;
    const dvec3 facing = glm::normalize(dice.direction() + dvec3(0, 0, 1.1));
    const dvec3 tint = blossom ? blossoms[static_cast<int>(4.0 * cell_noise(0.8 * x, 0.8 * y, seed))]
                               : dvec3(0.27, 0.42, 0.16);
    objects.push_back(
        {shapes::Disc{{x, y, z}, facing, blossom ? dice.between(0.06, 0.10) : dice.between(0.08, 0.15), 0.0},
         {.material = SiteMaterial::leaf, .tint = tint, .seed = dice.bits()}});
  }
}

/// Trees, hedges and clipped balls.
void add_plants(Objects& objects, const shapes::Ground& ground) {
  const dvec3 linden(0.36, 0.49, 0.17), maple(0.40, 0.47, 0.16), beech(0.46, 0.27, 0.20),
      oak(0.29, 0.42, 0.16);
  const TreePlan trees[] = {
      {{-13.0, 8.2}, 10.5, 3.7, 0.26, 7000, 0.115, linden, 1},
      {{13.5, 8.4}, 9.2, 3.2, 0.22, 6000, 0.11, maple, 2},
      {{-15.5, -9.0}, 7.4, 2.5, 0.17, 4200, 0.10, oak, 3},
      {{-24.0, 38.0}, 12.0, 4.2, 0.32, 2600, 0.20, oak, 4},
      {{-7.0, 43.0}, 10.0, 3.6, 0.25, 2200, 0.19, linden, 5},
      {{9.0, 35.5}, 8.0, 2.8, 0.20, 2000, 0.17, beech, 6},
      {{24.0, 42.5}, 11.5, 4.0, 0.30, 2400, 0.20, maple, 7},
      {{41.0, 32.0}, 9.5, 3.4, 0.24, 2200, 0.18, linden, 8},
      {{-46.0, 40.0}, 11.0, 3.9, 0.28, 2400, 0.20, maple, 9},
      {{-42.0, -7.0}, 10.5, 3.7, 0.27, 2400, 0.19, oak, 10},
      {{-52.0, -23.0}, 9.0, 3.3, 0.22, 2200, 0.18, linden, 11},
      {{42.0, 12.0}, 9.5, 3.3, 0.24, 2200, 0.18, beech, 12},
      {{52.0, 21.0}, 10.5, 3.7, 0.26, 2400, 0.19, oak, 13},
      {{45.0, -29.5}, 8.0, 2.6, 0.18, 2000, 0.16, linden, 14},
      {{-19.0, -29.5}, 8.0, 2.5, 0.17, 2000, 0.15, linden, 15},
      {{11.0, -29.5}, 7.6, 2.4, 0.17, 2000, 0.15, linden, 16},
      {{25.0, -29.5}, 8.2, 2.6, 0.18, 2000, 0.15, linden, 17},
  };
  for (const TreePlan& tree : trees) add_tree(objects, tree, ground);

  // Low hedges along the lawns, open towards the fountain.
  add_hedge(objects, {-21.2, 12.6}, {-4.6, 13.1}, 0.62);
  add_hedge(objects, {-21.2, 3.4}, {-20.7, 12.6}, 0.62);
  add_hedge(objects, {4.6, 12.6}, {21.2, 13.1}, 0.62);
  add_hedge(objects, {20.7, 3.4}, {21.2, 12.6}, 0.62);
  add_hedge(objects, {-21.2, -13.6}, {-9.2, -13.1}, 0.62);
  add_hedge(objects, {-21.2, -13.1}, {-20.7, -4.6}, 0.62);

  for (const double x : {-3.4, 3.4}) add_topiary(objects, {x, 15.6}, 0.0);
  for (const double y : {-1.9, 0.9}) add_topiary(objects, {23.6, y}, 0.0);
  add_flowers(objects, {-23.8, 15.5}, {-4.6, 16.35}, 1100, 81);
  add_flowers(objects, {4.6, 15.5}, {23.8, 16.35}, 1100, 82);
  add_flowers(objects, {-10.6, -12.2}, {-9.4, -5.4}, 420, 83);
}

/// Fountain, benches, lamp posts, barrels, stone balls, survey targets.
void add_furniture(Objects& objects) {
  add_fountain(objects, {0.0, -0.5});
  constexpr double k_diagonal = 0.70710678118654752;
  for (const dvec2 direction : {dvec2(1, 1), dvec2(-1, 1), dvec2(-1, -1), dvec2(1, -1)})
    add_bench(objects, dvec2(0.0, -0.5) + 6.0 * (k_diagonal * direction), -k_diagonal * direction);
  add_bench(objects, {-23.6, 2.0}, {1.0, 0.0});
  for (const dvec2 position : {dvec2(-8.6, -13.0), dvec2(1.6, -13.0), dvec2(-8.0, 13.9), dvec2(8.0, 13.9),
                               dvec2(-30.0, -31.2), dvec2(2.0, -31.2), dvec2(34.0, -31.2)})
    add_lamp_post(objects, position);
  for (const dvec2 position : {dvec2(-23.5, -11.6), dvec2(-22.9, -12.2), dvec2(-23.7, -12.5)})
    add_barrel(objects, position);
  for (const double x : {-7.9, -2.1}) {
    add_stone_ball(objects, {x, -16.8});
    add_stone_ball(objects, {x, -26.8});
  }
  for (const dvec2 position : {dvec2(5.6, 10.4), dvec2(-17.5, 0.5), dvec2(9.0, -6.0), dvec2(20.5, 1.6)})
    add_target(objects, position);
}

/// Two cars in the yard's corner and one in the street.
void add_cars(Objects& objects, const shapes::Ground& ground) {
  add_car(objects, {11.6, -9.0, 0.0}, {-0.6, 0.8}, {0.66, 0.12, 0.11});
  add_car(objects, {14.8, -3.4, 0.0}, {-0.28, -0.96}, {0.17, 0.30, 0.52});
  const dvec2 street(17.0, -33.4);
  add_car(objects, dvec3(street, shapes::height_at(ground, street).height), {-1.0, 0.0}, {0.80, 0.80, 0.79});
}

/// The rolling ground with lawns, paths and streets. Trees and houses outside the yard
/// are placed on its height.
shapes::Ground courtyard_ground() {
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

}  // namespace

Site courtyard() {
  const shapes::Ground land = courtyard_ground();
  Objects objects;
  objects.push_back({land, {.material = SiteMaterial::terrain}});
  add_buildings(objects);
  add_neighbours(objects);
  add_plants(objects, land);
  add_furniture(objects);
  add_cars(objects, land);
  return Site(std::move(objects), k_origin);
}

ScanOptions courtyard_scan(std::uint64_t point_count, std::uint64_t seed) {
  ScanOptions options;
  options.point_count = point_count;
  options.seed = seed;
  // Seven in the yard, three in the street.
  const glm::dvec2 positions[] = {{-16.5, -1.5}, {-3.2, 9.5},   {8.0, 3.0},     {19.5, 9.8},
                                  {18.2, -8.4},  {5.2, -12.6},  {-11.9, -14.8}, {-5.0, -30.5},
                                  {28.0, -38.0}, {-36.0, -36.5}};
  const shapes::Ground ground = courtyard_ground();
  constexpr double k_tripod = 1.7;
  for (const glm::dvec2& position : positions)
    options.stations.push_back(
        {k_origin + glm::dvec3(position, shapes::height_at(ground, position).height + k_tripod)});

  constexpr double k_height = 60.0;
  // Straight down along x; then along y looking ahead, there and back, for the walls.
  for (const double y : {-26.0, 0.0, 26.0})
    options.flight_lines.push_back(
        {k_origin + glm::dvec3(-59.0, y, k_height), k_origin + glm::dvec3(59.0, y, k_height), 0.0, 46.0});
  for (const double x : {-36.0, -12.0, 12.0, 36.0}) {
    const double direction = x == -36.0 || x == 12.0 ? 1.0 : -1.0;
    options.flight_lines.push_back({k_origin + glm::dvec3(x, -direction * 86.0, k_height),
                                    k_origin + glm::dvec3(x, direction * 14.0, k_height), 30.0, 32.0});
  }
  return options;
}

void generate_courtyard(const std::filesystem::path& path, const GenerateOptions& options) {
  const Site site = courtyard();
  LasWriter writer(path, scan_header(site), scan_attributes(), {.overwrite = options.overwrite});
  scan(
      site, courtyard_scan(options.point_count, options.seed),
      [&](const PointCloud& batch) { writer.write(batch); }, options.progress);
  writer.finish();
}

}  // namespace alidade::simulation
