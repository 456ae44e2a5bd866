// SPDX-License-Identifier: MIT
#include "octree/point_spacing.h"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "base/huge_memory.h"
#include "octree/answer_target.h"
#include "octree/parallel_loops.h"
#include "octree/slot_spacings.h"

namespace alidade {
namespace {

struct Spacings {
  std::shared_ptr<const void> octree;  ///< keeps its arrays alive
  HugeArray<std::uint16_t> points, slots;
};

/// Measures the spacings of points that come leaf by leaf.
class SpacingMeter {
 public:
  SpacingMeter(const Octree& octree, int neighbours)
      : octree_(octree), neighbours_(static_cast<std::size_t>(neighbours)) {}

  void measure(const Leaf& leaf, std::uint16_t* spacings) {
    const TreeView& tree = octree_.view();
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const LatticePosition position = position_of(tree, leaf, i);
      // Points of one place mostly stand one after another.
      if (!known_ || position != last_) bits_ = spacing_bits(spacing(to_world(tree.lattice, position)));
      known_ = true;
      last_ = position;
      spacings[leaf.place + i] = bits_;
    }
  }

 private:
  double spacing(const glm::dvec3& place) {
    // The point itself comes first. Where it has twins, they must not crowd out the others.
    if (const auto found = others(place, {.k = neighbours_ + 1}, neighbours_ + 1)) return *found;
    const auto elsewhere = [](const Candidate& candidate) { return candidate.distance > 0.0; };
    return others(place, {.k = neighbours_, .filter = elsewhere}, neighbours_)
        .value_or(std::numeric_limits<double>::infinity());
  }

  /// Distance of the n-th point elsewhere among the first k.
  std::optional<double> others(const glm::dvec3& place, const PointQuery& query, std::size_t k) {
    nearest_.clear();
    find_into(octree_, place, query, k, 0, nearest_);
    const auto first = std::ranges::find_if(nearest_, [](const PointHit& hit) { return hit.distance > 0.0; });
    if (static_cast<std::size_t>(nearest_.end() - first) < neighbours_) return std::nullopt;
    return (first + static_cast<std::ptrdiff_t>(neighbours_ - 1))->distance;
  }

  const Octree& octree_;
  const std::size_t neighbours_;
  std::vector<PointHit> nearest_;
  bool known_ = false;
  LatticePosition last_{};
  std::uint16_t bits_ = 0;
};

}  // namespace

std::uint16_t spacing_bits(double metres) {
  auto rounded = static_cast<float>(metres);
  if (rounded < metres) rounded = std::nextafter(rounded, std::numeric_limits<float>::infinity());
  return static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(rounded) + 0xffffu) >> 16);
}

Octree with_spacings(const Octree& octree, int neighbours, const Progress& progress) {
  if (neighbours < 1 || neighbours > k_most_spacing_neighbours) {
    throw Error({.problem = "bad number of neighbours for spacings",
                 .expected = fmt::format("1 to {}", k_most_spacing_neighbours),
                 .found = std::to_string(neighbours)});
  }
  if (octree.size() == 0 || octree.view().spacing_neighbours == neighbours) return octree;
  const auto made = std::make_shared<Spacings>();
  made->octree = octree.storage();
  TreeView tree = octree.view();
  made->points = HugeArray<std::uint16_t>(std::size_t{tree.point_count} + k_coordinate_padding);
  for_each_leaf_in_parallel(tree, progress, [&] {
    return [&, meter = SpacingMeter(octree, neighbours)](const Leaf& leaf) mutable {
      meter.measure(leaf, made->points.data());
    };
  });
  std::fill_n(made->points.data() + tree.point_count, k_coordinate_padding, std::uint16_t{0});
  tree.spacings = made->points.data();

  made->slots = HugeArray<std::uint16_t>(std::size_t{k_node_width} * tree.node_count);
  // Children stand behind their parents.
  for (std::uint32_t index = tree.node_count; index-- > 0;) {
    std::ranges::copy(greatest_spacings(tree, made->slots.data(), index),
                      made->slots.data() + std::size_t{k_node_width} * index);
  }
  tree.slot_spacings = made->slots.data();
  tree.spacing_neighbours = neighbours;
  return Octree(tree, made, octree.instruction_set());
}

double sphere_radius(const RayQuery& query, const Hit& hit) {
  // Rounding of t is told apart from other spacings, which differ in eight bits.
  constexpr double k_rounding = 1e-8;
  const double half_chord = hit.t - hit.entry;
  const double radius = std::sqrt(hit.distance * hit.distance + half_chord * half_chord);
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(radius / query.spacing_factor));
  const double spacing = spacing_of(static_cast<std::uint16_t>((bits + 0x8000u) >> 16));
  const double own = own_radius(query, spacing);
  return std::fabs(own - radius) <= k_rounding * radius ? own : query.radius;
}

std::vector<double> spacings_in_order(const TreeView& tree) {
  std::vector<double> spacings(tree.point_count);
  for (std::uint32_t place = 0; place < tree.point_count; ++place)
    spacings[point_id(tree, place)] = spacing_at(tree, place);
  return spacings;
}

}  // namespace alidade
