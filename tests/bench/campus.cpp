// SPDX-License-Identifier: MIT
#include "tests/bench/campus.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "simulation/noise.h"
#include "tests/bench/alias_table.h"

namespace alidade::bench {

using namespace simulation;

namespace {

/// A small piece of surface: corner + u * across + v * along for u, v in [0, 1), or one of the round kinds.
struct Patch {
  enum class Kind { flat, crown, pole } kind;
  glm::vec3 corner;  ///< crown: centre; pole: foot
  glm::vec3 across;  ///< crown and pole: x is the radius
  glm::vec3 along;   ///< pole: z is the height
};

double area(const Patch& patch) {
  switch (patch.kind) {
    case Patch::Kind::flat:
      return glm::length(glm::cross(patch.across, patch.along));
    case Patch::Kind::crown:
      return 4.0 * std::numbers::pi * patch.across.x * patch.across.x;
    case Patch::Kind::pole:
      return 2.0 * std::numbers::pi * patch.across.x * patch.along.z;
  }
  return 0.0;
}

glm::vec3 middle(const Patch& patch) {
  switch (patch.kind) {
    case Patch::Kind::flat:
      return patch.corner + 0.5f * (patch.across + patch.along);
    case Patch::Kind::crown:
      return patch.corner;
    case Patch::Kind::pole:
      return patch.corner + 0.5f * patch.along;
  }
  return patch.corner;
}

void add_flat(std::vector<Patch>& patches, const glm::dvec3& corner, const glm::dvec3& u,
              const glm::dvec3& v) {
  const int columns = static_cast<int>(std::ceil(glm::length(u))),
            rows = static_cast<int>(std::ceil(glm::length(v)));
  const glm::dvec3 across = u / double(columns), along = v / double(rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const glm::dvec3 at = corner + double(column) * across + double(row) * along;
      patches.push_back({Patch::Kind::flat, at, across, along});
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

/// Square metres, except under buildings. The terrain is flat within one to a millimetre.
void add_ground(std::vector<Patch>& patches, const CampusLayout& layout) {
  for (double y = 0; y < k_campus_side; ++y) {
    for (double x = 0; x < k_campus_side; ++x) {
      const bool covered = std::ranges::any_of(layout.buildings, [&](const Building& b) {
        return x + 0.5 > b.low.x && x + 0.5 < b.high.x && y + 0.5 > b.low.y && y + 0.5 < b.high.y;
      });
      if (covered) continue;
      const double height = terrain_height(x, y);
      patches.push_back({Patch::Kind::flat,
                         {x, y, height},
                         {1.0, 0.0, terrain_height(x + 1.0, y) - height},
                         {0.0, 1.0, terrain_height(x, y + 1.0) - height}});
    }
  }
}

std::vector<Patch> campus_patches(const CampusLayout& layout) {
  std::vector<Patch> patches;
  add_ground(patches, layout);
  for (const Building& building : layout.buildings) add_building(patches, building);
  for (const Crown& crown : layout.crowns)
    patches.push_back({Patch::Kind::crown, crown.center, {crown.radius, 0, 0}, glm::vec3(0)});
  for (const Pole& pole : layout.poles)
    patches.push_back({Patch::Kind::pole, pole.foot, {pole.radius, 0, 0}, {0, 0, pole.height}});
  return patches;
}

/// Near a normal distribution of deviation 1: four uniform numbers added.
double bell(std::uint64_t bits) {
  const auto part = [&](int shift) { return static_cast<double>(bits >> shift & 0xffffu); };
  constexpr double k_deviation_of_sum = 0x1p16 * std::numbers::inv_sqrt3;
  return (part(0) + part(16) + part(32) + part(48) - 2.0 * 0xffff) / k_deviation_of_sum;
}

glm::vec3 position_on(const Patch& patch, float u, float v, float depth) {
  if (patch.kind == Patch::Kind::flat) return patch.corner + u * patch.across + v * patch.along;
  const float angle = 2.0f * std::numbers::pi_v<float> * u, radius = patch.across.x;
  const glm::vec3 outward(std::cos(angle), std::sin(angle), 0.0f);
  if (patch.kind == Patch::Kind::pole) return patch.corner + radius * outward + v * patch.along;
  // Leaves are not only on the outside.
  const float z = 2.0f * v - 1.0f, ring = std::sqrt(std::max(0.0f, 1.0f - z * z));
  return patch.corner + radius * (0.6f + 0.4f * depth) * (ring * outward + glm::vec3(0, 0, z));
}

}  // namespace

PointCloud campus_cloud(const CampusLayout& layout, std::size_t point_count) {
  const std::vector<Patch> patches = campus_patches(layout);
  std::vector<double> even, around_stations;
  for (const Patch& patch : patches) {
    double density = 0.0;
    for (const glm::dvec3& station : layout.stations) {
      // Scanners do not see what is below their tripod.
      const glm::dvec3 apart = glm::dvec3(middle(patch)) - station;
      density += 1.0 / std::max(4.0, glm::dot(apart, apart));
    }
    even.push_back(area(patch));
    around_stations.push_back(area(patch) * density);
  }
  const AliasTable from_drone(even), from_stations(around_stations);

  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.001), k_campus_origin};
  cloud.positions.resize(point_count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, point_count, 65536), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      std::uint64_t counter = 8 * i;
      const auto bits = [&] { return mix_bits(counter++); };
      const auto unit = [&] { return static_cast<float>(bits() >> 40) * 0x1p-24f; };
      const Patch& patch = patches[(i % 2 ? from_drone : from_stations).draw(bits())];
      const float u = unit(), v = unit(), depth = unit();
      const glm::vec3 position = position_on(patch, u, v, depth);
      for (int axis = 0; axis < 3; ++axis) {
        const double millimetres = 1000.0 * position[axis] + 10.0 * bell(bits());
        cloud.positions[i][axis] = static_cast<std::int32_t>(millimetres + (millimetres < 0.0 ? -0.5 : 0.5));
      }
    }
  });
  return cloud;
}

}  // namespace alidade::bench
