// SPDX-License-Identifier: MIT
#include "octree/point_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "base/huge_memory.h"
#include "octree/local_plane.h"
#include "octree/packed_normal.h"
#include "octree/parallel_loops.h"
#include "octree/query.h"
#include "octree/sheet_edge.h"
#include "octree/simd/moments.h"
#include "octree/spacing.h"

namespace alidade {
namespace {

constexpr double k_least_sheet_trust = 0.8;  // of one of two sheets
constexpr double k_least_trust = 0.7;        // of a plane that is a surface

// 32 bits: one that says "exists", 10 + 10 for the normal, sign and 5 for the height, 5 for the thickness.
constexpr double k_side_steps = 1022.0;
constexpr std::uint32_t k_exists = 0x80000000u, k_below = 0x400u, k_length_mask = 31u;

/// Lengths that five bits stand for, in units: 0, then from 2^-13 up to 4 by factors of the root of 2.
constexpr std::array<double, 32> k_lengths = [] {
  std::array<double, 32> lengths{};
  double whole = 4.0;
  for (std::size_t i = 31; i > 0; --i) {
    lengths[i] = i % 2 == 1 ? whole : 0.70710678118654752 * whole;
    if (i % 2 == 0) whole *= 0.5;
  }
  return lengths;
}();

/// The nearest length.
std::uint32_t nearest_length(double length) {
  const auto above = std::ranges::lower_bound(k_lengths, length);
  if (above == k_lengths.begin()) return 0;
  if (above == k_lengths.end()) return k_length_mask;
  const auto index = static_cast<std::uint32_t>(above - k_lengths.begin());
  return length - k_lengths[index - 1] < k_lengths[index] - length ? index - 1 : index;
}

/// The least length that is not smaller, or the greatest.
std::uint32_t length_above(double length) {
  const auto above = std::ranges::lower_bound(k_lengths, length);
  return above == k_lengths.end() ? k_length_mask : static_cast<std::uint32_t>(above - k_lengths.begin());
}

PointSurface unpack(std::uint32_t packed, double unit) {
  if ((packed & k_exists) == 0) return {};
  const double height = unit * k_lengths[packed >> 5 & k_length_mask];
  return {true, unpack_normal({packed >> 21 & 0x3ffu, packed >> 11 & 0x3ffu}, k_side_steps),
          (packed & k_below) != 0 ? -height : height, unit * k_lengths[packed & k_length_mask]};
}

std::uint32_t pack(const PointSurface& surface, double unit) {
  if (!surface.exists) return 0;
  const glm::uvec2 normal = pack_normal(surface.normal, k_side_steps);
  // Packing keeps the upper one of the two normals.
  const bool turned = surface.normal.z < 0.0;
  const bool below = (surface.height < 0.0) != turned;
  return k_exists | normal.x << 21 | normal.y << 11 | (below ? k_below : 0u) |
         nearest_length(std::fabs(surface.height) / unit) << 5 | length_above(surface.thickness / unit);
}

/// Heights of two sheets above a place, along a normal. Metres.
struct Sheets {
  double lower = 0.0, upper = 0.0;
};

/// Of the points around a place, told from the moments of their heights; empty if they look like one sheet.
std::optional<Sheets> two_sheets(const Octree& octree, const glm::dvec3& place, double reach,
                                 const LocalPlane& plane) {
  const simd::HeightSums sums = simd::moment_sums(octree.instruction_set())
                                    .heights(octree.view(), place, reach, glm::vec3(plane.normal),
                                             static_cast<float>(-plane.height / reach));
  const double mean = sums.powers[0] / sums.weight;
  const double second = sums.powers[1] / sums.weight, third = sums.powers[2] / sums.weight,
               fourth = sums.powers[3] / sums.weight;
  const double square = mean * mean, variance = second - square;
  // Below this, heights are rounding.
  if (!(variance > 1e-10)) return std::nullopt;
  const double third_central = third - 3.0 * mean * second + 2.0 * mean * square;
  const double fourth_central = fourth - 4.0 * mean * third + 6.0 * square * second - 3.0 * square * square;
  const double skewness = third_central / (variance * std::sqrt(variance));
  const double kurtosis = fourth_central / (variance * variance);
  // 1 for two sharp values, 0.56 for an even spread, 0.33 for a bell curve. What looks like two sheets is
  // looked at closely.
  constexpr double k_two_values = 0.4;
  if (!(skewness * skewness + 1.0 > k_two_values * kurtosis)) return std::nullopt;
  const double middle = reach * mean - plane.height, half = 0.5 * reach * std::sqrt(variance);
  const double root = std::sqrt(skewness * skewness + 4.0);
  return Sheets{middle + half * (skewness - root), middle + half * (skewness + root)};
}

/// The plane of the sheet that the place stands on, where there are two; otherwise `plane`.
LocalPlane choose_sheet(const Octree& octree, const glm::dvec3& place, double reach,
                        const LocalPlane& plane) {
  const std::optional<Sheets> sheets = two_sheets(octree, place, reach, plane);
  if (!sheets) return plane;
  const double gap = sheets->upper - sheets->lower;
  const bool on_upper = std::fabs(sheets->upper) < std::fabs(sheets->lower);
  LocalPlane sheet = plane;
  sheet.height = -(on_upper ? sheets->upper : sheets->lower);
  const std::vector<PointHit> around = find(octree, place, PointQuery{.radius = reach});
  std::vector<glm::dvec3> offsets;
  // The first plane leans towards both sheets, the second hardly.
  for (int pass = 0; pass < 2; ++pass) {
    offsets.clear();
    for (const PointHit& point : around) {
      const glm::dvec3 offset = point.position - place;
      if (std::fabs(glm::dot(offset, sheet.normal) + sheet.height) < 0.5 * gap) offsets.push_back(offset);
    }
    sheet = local_plane(offsets, reach);
    if (sheet.trust < k_least_sheet_trust) return plane;
  }
  // Sheets of a plate are parallel to it.
  constexpr double k_apart = 8.0, k_parallel = 0.95;
  const bool is_parallel = std::fabs(glm::dot(sheet.normal, plane.normal)) > k_parallel;
  return is_parallel && gap > k_apart * sheet.thickness ? sheet : plane;
}

/// Whether a point stands so far off the sheet of its neighbours that it is no part of it.
bool off_sheet(const LocalPlane& plane, double reach) {
  constexpr double k_thicknesses = 4.0, k_reaches = 1e-3;
  return std::fabs(plane.height) > k_thicknesses * plane.thickness + k_reaches * reach;
}

/// The surface of a point off the sheet of its neighbours: that of the others, as on the ground at the foot
/// of a wall with many more points; or one of its own beside the sheet. None where it stands far off with few
/// others, like a bird above a field: its distance to its neighbours would make a wide disc of it.
PointSurface surface_beside(const Octree& octree, const glm::dvec3& place, double spacing, double reach,
                            const LocalPlane& sheet) {
  constexpr double k_far = 0.5;  // spacings
  // A third of what a sheet with this spacing has within reach; one that ends here has half.
  const double few = k_surface_neighbours / 3.0 * (reach / spacing) * (reach / spacing);
  std::vector<glm::dvec3> others;
  for (const PointHit& point : find(octree, place, PointQuery{.radius = reach})) {
    LocalPlane from_sheet = sheet;
    const glm::dvec3 offset = point.position - place;
    from_sheet.height += glm::dot(offset, sheet.normal);
    if (off_sheet(from_sheet, reach)) others.push_back(offset);
  }
  const bool is_far = std::fabs(sheet.height) > k_far * spacing;
  if (is_far && static_cast<double>(others.size()) < few) return {};
  const LocalPlane plane = local_plane(others, reach);
  if (plane.trust >= k_least_trust && !off_sheet(plane, reach))
    return {true, plane.normal, plane.height, plane.thickness};
  if (is_far) return {};
  return {true, sheet.normal, 0.0, sheet.thickness};
}

struct FittedSurface {
  PointSurface surface;
  bool may_end = true;  ///< whether an edge of the sheet may be near
};

FittedSurface fit_surface(const Octree& octree, const glm::dvec3& place, double spacing) {
  constexpr double k_reaches[] = {2.5, 1.5, 1.1, 5.0};
  // Near an edge the mean of a sheet's points lies farther inward, in reaches, than it does by chance.
  constexpr double k_centered = 0.1;
  if (!std::isfinite(spacing)) return {};
  for (const double factor : k_reaches) {
    const double reach = factor * spacing;
    const LocalPlane fitted = local_plane(octree, place, reach);
    if (fitted.trust < k_least_trust) continue;
    // Few points look like two sheets by chance.
    const LocalPlane plane = factor < k_reaches[0] ? fitted : choose_sheet(octree, place, reach, fitted);
    if (off_sheet(plane, reach)) return {surface_beside(octree, place, spacing, reach, plane)};
    const bool may_end = factor != k_reaches[0] || plane.off_center > k_centered * reach;
    return {{true, plane.normal, plane.height, plane.thickness}, may_end};
  }
  return {};
}

struct Surfaces {
  std::shared_ptr<const void> octree;  ///< keeps its arrays alive
  HugeArray<std::uint32_t> points;
  HugeArray<std::uint8_t> edges;
};

}  // namespace

Octree with_surfaces(const Octree& octree, const Progress& progress) {
  if (octree.size() == 0 || octree.view().surfaces) return octree;
  const auto made = std::make_shared<Surfaces>();
  made->octree = octree.storage();
  TreeView tree = octree.view();
  made->points = HugeArray<std::uint32_t>(tree.point_count);
  made->edges = HugeArray<std::uint8_t>(tree.point_count);
  tree.surface_unit = automatic_radius(octree);
  for_each_leaf_in_parallel(tree, progress, [&] {
    return [&](const Leaf& leaf) {
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const glm::dvec3 place = to_world(tree.lattice, position_of(tree, leaf, i));
        const double spacing = spacing_at(tree, leaf.place + i);
        const std::uint64_t id = point_id(tree, leaf.place + i);
        const FittedSurface fitted = fit_surface(octree, place, spacing);
        const std::uint32_t packed = pack(fitted.surface, tree.surface_unit);
        made->points[id] = packed;
        made->edges[id] =
            fitted.may_end ? fit_sheet_edge(octree, place, spacing, unpack(packed, tree.surface_unit)) : 0;
      }
    };
  });
  tree.surfaces = made->points.data();
  tree.sheet_edges = made->edges.data();
  return Octree(tree, made, octree.instruction_set());
}

PointSurface surface_of(const TreeView& tree, std::uint64_t point_id) {
  return unpack(tree.surfaces[point_id], tree.surface_unit);
}

}  // namespace alidade
