// SPDX-License-Identifier: MIT
#include "tests/bench/campus.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "simulation/noise.h"

namespace alidade::bench {
namespace {

/// A small piece of surface: corner + u * across + v * along for u, v in [0, 1), or one of the round kinds.
struct Patch {
  enum class Kind { flat, ground, crown, pole } kind;
  glm::dvec3 corner;  ///< crown: centre; pole: foot
  glm::dvec3 across;  ///< crown and pole: x is the radius
  glm::dvec3 along;   ///< pole: z is the height
  double area;
  glm::dvec3 middle;
};

void add_flat(std::vector<Patch>& patches, const glm::dvec3& corner, const glm::dvec3& u,
              const glm::dvec3& v) {
  const int columns = static_cast<int>(std::ceil(glm::length(u))),
            rows = static_cast<int>(std::ceil(glm::length(v)));
  const glm::dvec3 across = u / double(columns), along = v / double(rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const glm::dvec3 at = corner + double(column) * across + double(row) * along;
      patches.push_back({Patch::Kind::flat, at, across, along, glm::length(glm::cross(across, along)),
                         at + 0.5 * (across + along)});
    }
  }
}

void add_building(std::vector<Patch>& patches, const Building& building) {
  const glm::dvec3 low = building.low, size = building.high - building.low;
  const glm::dvec3 x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z);
  add_flat(patches, low + z, x, y);
  add_flat(patches, low, x, z);
  add_flat(patches, low + y, x, z);
  add_flat(patches, low, y, z);
  add_flat(patches, low + x, y, z);
}

/// Square metres, except under buildings.
void add_ground(std::vector<Patch>& patches, const CampusLayout& layout) {
  for (double y = 0; y < k_campus_side; ++y) {
    for (double x = 0; x < k_campus_side; ++x) {
      const glm::dvec3 middle(x + 0.5, y + 0.5, terrain_height(x + 0.5, y + 0.5));
      const bool covered = std::ranges::any_of(layout.buildings, [&](const Building& b) {
        return middle.x > b.low.x && middle.x < b.high.x && middle.y > b.low.y && middle.y < b.high.y;
      });
      if (!covered) patches.push_back({Patch::Kind::ground, {x, y, 0}, {1, 0, 0}, {0, 1, 0}, 1.0, middle});
    }
  }
}

std::vector<Patch> campus_patches(const CampusLayout& layout) {
  std::vector<Patch> patches;
  add_ground(patches, layout);
  for (const Building& building : layout.buildings) add_building(patches, building);
  for (const Crown& crown : layout.crowns) {
    patches.push_back({Patch::Kind::crown,
                       crown.center,
                       {crown.radius, 0, 0},
                       {0, 0, 0},
                       4.0 * std::numbers::pi * crown.radius * crown.radius,
                       crown.center});
  }
  for (const Pole& pole : layout.poles) {
    patches.push_back({Patch::Kind::pole,
                       pole.foot,
                       {pole.radius, 0, 0},
                       {0, 0, pole.height},
                       2.0 * std::numbers::pi * pole.radius * pole.height,
                       pole.foot + glm::dvec3(0, 0, 0.5 * pole.height)});
  }
  return patches;
}

/// Draws an index with given weights in constant time: Walker's alias method (1977).
class AliasTable {
 public:
  explicit AliasTable(const std::vector<double>& weights) : slots_(weights.size()) {
    const double mean =
        std::accumulate(weights.begin(), weights.end(), 0.0) / static_cast<double>(weights.size());
    std::vector<std::uint32_t> small, large;
    std::vector<double> share(weights.size());
    for (std::uint32_t i = 0; i < weights.size(); ++i) {
      share[i] = weights[i] / mean;
      (share[i] < 1.0 ? small : large).push_back(i);
    }
    for (std::uint32_t i = 0; i < weights.size(); ++i) slots_[i] = {1.0f, i};
    while (!small.empty() && !large.empty()) {
      const std::uint32_t low = small.back(), high = large.back();
      small.pop_back();
      slots_[low] = {static_cast<float>(share[low]), high};
      share[high] -= 1.0 - share[low];
      if (share[high] < 1.0) {
        large.pop_back();
        small.push_back(high);
      }
    }
  }

  std::uint32_t draw(std::uint64_t bits) const {
    const auto slot = static_cast<std::uint32_t>((bits >> 32) * slots_.size() >> 32);
    const float place = static_cast<float>(static_cast<std::uint32_t>(bits) >> 8) * 0x1p-24f;
    return place < slots_[slot].share ? slot : slots_[slot].other;
  }

 private:
  struct Slot {
    float share;
    std::uint32_t other;
  };
  std::vector<Slot> slots_;
};

/// Near a normal distribution of deviation 1: four uniform numbers added.
double bell(std::uint64_t bits) {
  const auto part = [&](int shift) { return static_cast<double>(bits >> shift & 0xffffu); };
  constexpr double k_deviation_of_sum = 0x1p16 * std::numbers::inv_sqrt3;
  return (part(0) + part(16) + part(32) + part(48) - 2.0 * 0xffff) / k_deviation_of_sum;
}

glm::dvec3 place_on(const Patch& patch, double u, double v, std::uint64_t depth_bits) {
  if (patch.kind == Patch::Kind::crown || patch.kind == Patch::Kind::pole) {
    const double angle = 2.0 * std::numbers::pi * u;
    if (patch.kind == Patch::Kind::pole)
      return patch.corner + glm::dvec3(patch.across.x * std::cos(angle), patch.across.x * std::sin(angle),
                                       v * patch.along.z);
    // Leaves are not only on the outside.
    const double radius = patch.across.x * (0.6 + 0.4 * unit_of(depth_bits)), z = 2.0 * v - 1.0;
    const double ring = std::sqrt(std::max(0.0, 1.0 - z * z));
    return patch.corner + radius * glm::dvec3(ring * std::cos(angle), ring * std::sin(angle), z);
  }
  glm::dvec3 place = patch.corner + u * patch.across + v * patch.along;
  if (patch.kind == Patch::Kind::ground) place.z = terrain_height(place.x, place.y);
  return place;
}

}  // namespace

PointCloud campus_cloud(const CampusLayout& layout, std::size_t point_count) {
  const std::vector<Patch> patches = campus_patches(layout);
  std::vector<double> even, around_stations;
  for (const Patch& patch : patches) {
    even.push_back(patch.area);
    double density = 0.0;
    for (const glm::dvec3& station : layout.stations) {
      // Scanners do not see what is below their tripod.
      const glm::dvec3 apart = patch.middle - station;
      density += 1.0 / std::max(4.0, glm::dot(apart, apart));
    }
    around_stations.push_back(patch.area * density);
  }
  const AliasTable from_drone(even), from_stations(around_stations);

  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.001), k_campus_origin};
  cloud.positions.resize(point_count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, point_count, 65536), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      std::uint64_t state = mix_bits(i);
      const auto bits = [&] { return state = mix_bits(state); };
      const Patch& patch = patches[(i % 2 ? from_drone : from_stations).draw(bits())];
      const double u = unit_of(bits()), v = unit_of(bits());
      const glm::dvec3 place = place_on(patch, u, v, bits());
      constexpr double k_noise = 0.01, k_steps_per_metre = 1000.0;
      for (int axis = 0; axis < 3; ++axis) {
        cloud.positions[i][axis] = static_cast<std::int32_t>(
            std::lround((place[axis] + k_noise * bell(bits())) * k_steps_per_metre));
      }
    }
  });
  return cloud;
}

}  // namespace alidade::bench
