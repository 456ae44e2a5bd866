// SPDX-License-Identifier: MIT
#include "octree/spacing.h"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "base/huge_memory.h"
#include "base/parallel.h"
#include "octree/answer_target.h"
#include "octree/tree_walk.h"

namespace alidade {
namespace {

// The radius that closes a surface of randomly scattered points, as a multiple of the nearest-neighbour
// distance that nine points in ten stay below. Points of density n leave a share exp(-n pi r^2) of a surface
// open, and their 90th percentile is sqrt(ln 10 / (pi n)); so the factor f leaves open 10^(-f^2), here 0.3 %.
constexpr double k_radius_factor = 1.6;

/// Finds the n-th nearest of the points that are at another position.
class Neighbours {
 public:
  Neighbours(const Octree& octree, int number, int max_level = k_all_levels)
      : octree_(octree), number_(static_cast<std::size_t>(number)), max_level_(max_level) {}

  /// Appends the distance to it from the position of each of some points; infinite if there are fewer. Fast
  /// where each is near the one before, that of the last call included.
  void spacings(std::span<const glm::dvec3> positions, std::vector<double>& spacings) {
    nearest_.clear();
    ends_.clear();
    // The point itself comes first. Where it has twins, they must not crowd out the others.
    const PointQuery query{.k = number_ + 1, .max_level = max_level_};
    find_in_turn(octree_, positions, query, reach_, nearest_, ends_);
    std::size_t begin = 0;
    for (std::size_t i = 0; i < positions.size(); begin = ends_[i++]) {
      const auto found = elsewhere(std::span(nearest_).subspan(begin, ends_[i] - begin));
      spacings.push_back(found ? *found : among_twins(positions[i]));
    }
  }

  /// The same as they are stored; for all levels.
  void spacings(std::span<const glm::dvec3> positions, std::uint16_t* bits) {
    const TreeView& tree = octree_.view();
    const bool suits = std::ranges::all_of(positions, [&](const glm::dvec3& position) {
      return simd::suits_lanes(tree, position, PointQuery{});
    });
    if (suits) {
      simd::search<glm::dvec3>(octree_.instruction_set())
          .spacings_in_turn(tree, positions, number_, reach_, bits);
    } else {
      std::fill_n(bits, positions.size(), simd::k_unknown_spacing);
    }
    left_.clear();
    for (std::size_t i = 0; i < positions.size(); ++i)
      if (bits[i] == simd::k_unknown_spacing) left_.push_back(positions[i]);
    distances_.clear();
    const double reach = reach_;
    spacings(left_, distances_);
    // A few positions that are left are mostly outliers.
    if (2 * left_.size() < positions.size()) reach_ = reach;
    for (std::size_t i = 0, next = 0; i < positions.size(); ++i)
      if (bits[i] == simd::k_unknown_spacing) bits[i] = spacing_bits(distances_[next++]);
  }

  double spacing(const glm::dvec3& position) {
    std::vector<double> spacing;
    spacings(std::span(&position, 1), spacing);
    return spacing.front();
  }

 private:
  double among_twins(const glm::dvec3& position) const {
    const auto is_elsewhere = [](const Candidate& candidate) { return candidate.distance > 0.0; };
    std::vector<PointHit> nearest;
    find_into(octree_, position, PointQuery{.k = number_, .max_level = max_level_, .filter = is_elsewhere},
              number_, 0, nearest);
    return elsewhere(nearest).value_or(std::numeric_limits<double>::infinity());
  }

  /// Distance of the n-th point elsewhere.
  std::optional<double> elsewhere(std::span<const PointHit> nearest) const {
    const auto first = std::ranges::find_if(nearest, [](const PointHit& hit) { return hit.distance > 0.0; });
    if (static_cast<std::size_t>(nearest.end() - first) < number_) return std::nullopt;
    return (first + static_cast<std::ptrdiff_t>(number_ - 1))->distance;
  }

  const Octree& octree_;
  const std::size_t number_;
  const int max_level_;
  double reach_ = 0.0;
  std::vector<PointHit> nearest_;
  std::vector<std::size_t> ends_;
  std::vector<glm::dvec3> left_;
  std::vector<double> distances_;
};

bool before(const glm::dvec3& a, const glm::dvec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

struct Spacings {
  HugeArray<std::uint16_t> points, slots;
};

/// Measures the spacings of points that come leaf by leaf.
class SpacingMeter {
 public:
  SpacingMeter(const Octree& octree, int neighbours)
      : tree_(octree.view()), neighbours_(octree, neighbours) {}

  void measure(const Leaf& leaf, std::uint16_t* spacings) {
    positions_.clear();
    std::size_t numbers[k_max_leaf_size];
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const LatticePosition position = position_of(tree_, leaf, i);
      // Points of one position are mostly adjacent.
      if (!known_ || position != last_) positions_.push_back(to_world(tree_.lattice, position));
      known_ = true;
      last_ = position;
      numbers[i] = positions_.size();
    }
    neighbours_.spacings(positions_, bits_ + 1);
    for (std::uint32_t i = 0; i < leaf.count; ++i) spacings[leaf.first + i] = bits_[numbers[i]];
    bits_[0] = bits_[positions_.size()];
  }

 private:
  const TreeView& tree_;
  Neighbours neighbours_;
  bool known_ = false;
  LatticePosition last_{};
  std::vector<glm::dvec3> positions_;
  /// Those of the positions, behind that of the last one of the leaf before.
  std::uint16_t bits_[k_max_leaf_size + 1] = {};
};

}  // namespace

std::vector<glm::dvec3> sample_positions(const Octree& octree, std::size_t sample_count, int max_level) {
  const TreeView& tree = octree.view();
  std::uint64_t point_count = tree.point_count;
  const bool all_levels = max_level >= tree.level_count - 1;
  if (!all_levels) {
    point_count = 0;
    for_each_leaf(tree, [&](const Leaf& leaf) { point_count += leaf.depth <= max_level ? leaf.count : 0; });
  }
  const std::uint64_t wanted = std::max<std::size_t>(sample_count, 1);
  const std::uint64_t stride = std::max<std::uint64_t>(1, (point_count + wanted - 1) / wanted);
  std::vector<glm::dvec3> samples;
  std::uint64_t seen = 0;
  for_each_leaf(tree, [&](const Leaf& leaf) {
    if (leaf.depth > max_level) return;
    // The points of some levels are not contiguous; they are counted as they come.
    const std::uint64_t first = all_levels ? leaf.first : seen;
    for (std::uint64_t number = (first + stride - 1) / stride * stride; number < first + leaf.count;
         number += stride) {
      samples.push_back(
          to_world(tree.lattice, position_of(tree, leaf, static_cast<std::uint32_t>(number - first))));
    }
    seen += leaf.count;
  });
  return samples;
}

Spacing measure_spacing(const Octree& octree, std::size_t sample_count, int max_level) {
  std::vector<glm::dvec3> samples = sample_positions(octree, sample_count, max_level);
  std::ranges::sort(samples, before);
  const auto twins = std::ranges::unique(samples);
  samples.erase(twins.begin(), twins.end());
  std::vector<double> distances(samples.size());
  in_parallel(samples.size(), 64,
              [&](std::size_t i) { distances[i] = Neighbours(octree, 1, max_level).spacing(samples[i]); });
  std::erase_if(distances, [](double d) { return std::isinf(d); });
  if (distances.empty()) return {};
  std::ranges::sort(distances);
  const double sum = std::accumulate(distances.begin(), distances.end(), 0.0);
  return {distances[distances.size() / 2], distances[distances.size() * 9 / 10],
          sum / static_cast<double>(distances.size()), distances.size()};
}

double automatic_radius(const Octree& octree, int max_level) {
  constexpr std::size_t k_sample_count = 20000;
  const double spacing = measure_spacing(octree, k_sample_count, max_level).percentile_90;
  if (spacing > 0.0) return k_radius_factor * spacing;
  const glm::dvec3 size = octree.bounds().size();
  const double diagonal = std::sqrt(size.x * size.x + size.y * size.y + size.z * size.z);
  return diagonal > 0.0 ? 0.001 * diagonal : 0.01;
}

std::uint16_t spacing_bits(double metres) {
  auto rounded = static_cast<float>(metres);
  if (rounded < metres) rounded = std::nextafter(rounded, std::numeric_limits<float>::infinity());
  return static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(rounded) + 0xffffu) >> 16);
}

Octree with_spacings(const Octree& octree, int neighbours, const Progress& progress) {
  if (neighbours < 1 || neighbours > k_most_spacing_neighbours) {
    throw Error({.problem = "invalid number of neighbours for spacings",
                 .expected = fmt::format("1 to {}", k_most_spacing_neighbours),
                 .found = std::to_string(neighbours)});
  }
  if (octree.size() == 0 || octree.layers().spacing_neighbours == neighbours) return octree;
  const auto made = std::make_shared<Spacings>();
  const TreeView& tree = octree.view();
  made->points =
      HugeArray<std::uint16_t>(std::size_t{tree.point_count} + k_coordinate_padding, octree.scratch());
  for_each_leaf_in_parallel(tree, progress, [&] {
    return [&, meter = SpacingMeter(octree, neighbours)](const Leaf& leaf) mutable {
      meter.measure(leaf, made->points.data());
    };
  });
  std::fill_n(made->points.data() + tree.point_count, k_coordinate_padding, std::uint16_t{0});

  made->slots = HugeArray<std::uint16_t>(std::size_t{k_node_width} * tree.node_count, octree.scratch());
  PointLayers layers = octree.layers();
  layers.spacings = made->points.data();
  layers.slot_spacings = made->slots.data();
  layers.spacing_neighbours = neighbours;
  // Children are behind their parents.
  for (std::uint32_t index = tree.node_count; index-- > 0;) {
    std::ranges::copy(greatest_spacings(tree, layers, index),
                      made->slots.data() + std::size_t{k_node_width} * index);
  }
  return octree.with_layers(layers, made);
}

HugeVector<float> spacings_in_order(const Octree& octree) {
  const TreeView& tree = octree.view();
  HugeVector<float> spacings(tree.point_count, octree.scratch());
  for (std::uint32_t index = 0; index < tree.point_count; ++index)
    spacings[point_id(tree, index)] = spacing_of(octree.layers().spacings[index]);
  return spacings;
}

}  // namespace alidade
