// SPDX-License-Identifier: MIT
#include <algorithm>
#include <glm/geometric.hpp>

#include "simulation/courtyard_parts.h"
#include "simulation/noise.h"

namespace alidade::simulation::courtyard_parts {

using glm::dvec2;
using glm::dvec3;

namespace {

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

}  // namespace

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

}  // namespace alidade::simulation::courtyard_parts
