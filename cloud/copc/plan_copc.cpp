// SPDX-License-Identifier: MIT
#include "cloud/copc/plan_copc.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>

#include "base/bytes.h"
#include "base/error.h"
#include "base/morton.h"
#include "base/parallel.h"
#include "cloud/sorted_points.h"

namespace alidade {
namespace {

constexpr int k_grid_bits = 7;  ///< cells of a node's grid along a side
constexpr int k_deepest = k_morton_bits - k_grid_bits;
constexpr int k_page_levels = 4;
constexpr std::size_t k_most_page_nodes = 1024;

using Points = SortedPoints<NarrowEntry>;

CopcInfo root_of(const Lattice& lattice, const LatticeExtent& extent, bool is_empty) {
  CopcInfo info;
  Bounds bounds;
  if (!is_empty) {
    bounds.grow(to_world(lattice, extent.low));
    bounds.grow(to_world(lattice, extent.high));
  }
  const glm::dvec3 size = bounds.size();
  const double step = std::max({lattice.scale.x, lattice.scale.y, lattice.scale.z});
  info.centre = is_empty ? lattice.offset : bounds.center();
  // Half of the size and a step, so that no point lies on the border.
  info.half_size = 0.5 * std::max({size.x, size.y, size.z}) + step;
  info.spacing = 2.0 * info.half_size / (1 << k_grid_bits);
  return info;
}

/// The points sorted by their cells of the deepest grid, which replace the positions.
Points sorted_points(const Lattice& lattice, std::span<LatticePosition> positions, const CopcInfo& info,
                     const ScratchSpace& scratch) {
  constexpr std::size_t k_at_once = std::size_t{1} << 14;
  const glm::dvec3 low = info.centre - info.half_size;
  const double cells = std::ldexp(1.0, k_morton_bits) / (2.0 * info.half_size);
  in_parallel(positions.size(), k_at_once, [&](std::size_t row) {
    const glm::dvec3 position = cells * (to_world(lattice, positions[row]) - low);
    for (int axis = 0; axis < 3; ++axis)
      positions[row][axis] = static_cast<std::int32_t>(
          std::clamp(std::floor(position[axis]), 0.0, std::ldexp(1.0, k_morton_bits) - 1.0));
  });
  return sort_points<NarrowEntry>({LatticePosition(0), k_morton_bits}, positions, scratch);
}

/// The number of a point's cube on a level.
std::uint64_t cube_of(std::uint64_t code, int level) {
  return code >> 3 * (k_morton_bits - level);
}

/// Points of a cube that no node above it takes.
struct Rest {
  std::size_t begin = 0, end = 0;
};

/// Takes one point of every cell of a cube's grid, in the order of the curve. The others move to the
/// beginning of the range, whose end is adapted.
std::vector<std::uint32_t> take_grid(Points& points, Rest& rest, int level) {
  NarrowEntry* const all = points.data();
  std::vector<std::uint32_t> taken;
  std::size_t kept = rest.begin;
  for (std::size_t first = rest.begin; first < rest.end;) {
    const std::uint64_t cell = cube_of(all[first].key(), level + k_grid_bits);
    std::size_t last = first + 1;
    while (last < rest.end && cube_of(all[last].key(), level + k_grid_bits) == cell) ++last;
    const std::size_t middle = (first + last) / 2;
    taken.push_back(all[middle].id);
    for (std::size_t i = first; i < last; ++i)
      if (i != middle) all[kept++] = all[i];
    first = last;
  }
  rest.end = kept;
  return taken;
}

void put_node(std::vector<std::uint8_t>& page, const CopcKey& key, std::uint64_t offset, std::uint64_t size,
              std::int32_t count) {
  const std::size_t size_before = page.size();
  page.resize(size_before + 32);
  std::byte* const at = std::as_writable_bytes(std::span(page)).data() + size_before;
  const std::int32_t numbers[] = {key.level, key.x, key.y, key.z};
  for (std::size_t i = 0; i < 4; ++i) store(at + 4 * i, numbers[i]);
  store(at + 16, offset);
  store(at + 24, static_cast<std::int32_t>(size));
  store(at + 28, count);
}

/// The node whose page has the entry of a node.
CopcKey page_of(CopcKey key) {
  while (key.level % k_page_levels != 0) key = key.parent();
  return key;
}

}  // namespace

std::vector<std::uint32_t> CopcPlan::counts() const {
  std::vector<std::uint32_t> all;
  for (const Node& node : nodes) all.push_back(node.point_count);
  return all;
}

CopcPlan plan_copc(const Lattice& lattice, const LatticeExtent& extent, std::span<LatticePosition> positions,
                   const ScratchSpace& scratch, std::size_t most_points) {
  const std::size_t count = positions.size();
  // A node's count has 31 bits, and one node may have all points.
  if (count > std::numeric_limits<std::int32_t>::max())
    throw input_error("too many points for COPC", "at most 2147483647", std::to_string(count));
  CopcPlan plan;
  plan.info = root_of(lattice, extent, count == 0);
  if (count == 0) return plan;
  Points points = sorted_points(lattice, positions, plan.info, scratch);
  plan.order = HugeArray<std::uint32_t>(count, scratch.folder);
  std::uint32_t* next_row = plan.order.data();
  std::vector<Rest> level_rests{{0, count}};
  for (int level = 0; !level_rests.empty(); ++level) {
    std::vector<std::vector<std::uint32_t>> taken(level_rests.size());
    std::vector<std::uint64_t> cubes(level_rests.size());
    in_parallel(level_rests.size(), 1, [&](std::size_t i) {
      Rest& rest = level_rests[i];
      cubes[i] = cube_of(points[rest.begin].key(), level);
      if (rest.end - rest.begin > most_points && level < k_deepest) taken[i] = take_grid(points, rest, level);
    });
    std::vector<Rest> next;
    for (std::size_t i = 0; i < level_rests.size(); ++i) {
      const Rest& rest = level_rests[i];
      const std::size_t node_points = taken[i].empty() ? rest.end - rest.begin : taken[i].size();
      plan.nodes.push_back({{level, static_cast<std::int32_t>(morton_coordinate(cubes[i], 0)),
                             static_cast<std::int32_t>(morton_coordinate(cubes[i], 1)),
                             static_cast<std::int32_t>(morton_coordinate(cubes[i], 2))},
                            static_cast<std::uint32_t>(node_points)});
      next_row = std::ranges::copy(taken[i], next_row).out;
      if (taken[i].empty()) {
        for (std::size_t point = rest.begin; point < rest.end; ++point) *next_row++ = points[point].id;
        continue;
      }
      for (std::size_t first = rest.begin; first < rest.end;) {
        const std::uint64_t cube = cube_of(points[first].key(), level + 1);
        std::size_t last = first + 1;
        while (last < rest.end && cube_of(points[last].key(), level + 1) == cube) ++last;
        next.push_back({first, last});
        first = last;
      }
    }
    level_rests = std::move(next);
  }
  assert(next_row == plan.order.data() + count);
  return plan;
}

VariableLengthRecord copc_info_record(const CopcInfo& info, const Interval& times) {
  VariableLengthRecord record{
      .user_id = "copc", .record_id = 1, .description = "COPC info", .data = std::vector<std::uint8_t>(160)};
  std::byte* const at = std::as_writable_bytes(std::span(record.data)).data();
  for (int axis = 0; axis < 3; ++axis) store(at + 8 * axis, info.centre[axis]);
  store(at + 24, info.half_size);
  store(at + 32, info.spacing);
  store(at + 40, info.root_page);
  store(at + 48, info.root_page_size);
  if (times.low <= times.high) {
    store(at + 56, times.low);
    store(at + 64, times.high);
  }
  return record;
}

VariableLengthRecord copc_hierarchy_record(CopcPlan& plan, std::span<const LazChunk> chunks) {
  assert(chunks.size() == plan.nodes.size());
  const bool has_pages = plan.nodes.size() > k_most_page_nodes;
  // Keys are ordered by level, so the root's page is the first.
  std::map<CopcKey, std::vector<std::size_t>> pages;
  pages[CopcKey{}];
  for (std::size_t i = 0; i < plan.nodes.size(); ++i)
    pages[has_pages ? page_of(plan.nodes[i].key) : CopcKey{}].push_back(i);
  // Every page but the first has an entry in that of its node's parent.
  std::map<CopcKey, std::vector<CopcKey>> below;
  for (const auto& [key, nodes] : pages)
    if (key.level > 0) below[page_of(key.parent())].push_back(key);
  struct PageExtent {
    std::uint64_t offset, size;
  };
  std::map<CopcKey, PageExtent> extents;
  std::uint64_t end = plan.info.root_page;
  for (const auto& [key, nodes] : pages) {
    extents[key] = {end, 32 * (nodes.size() + below[key].size())};
    end += extents[key].size;
  }
  VariableLengthRecord record{
      .user_id = "copc", .record_id = 1000, .description = "COPC hierarchy", .data = {}, .extended = true};
  for (const auto& [key, nodes] : pages) {
    for (const std::size_t i : nodes)
      put_node(record.data, plan.nodes[i].key, chunks[i].offset, chunks[i].byte_count,
               static_cast<std::int32_t>(chunks[i].point_count));
    for (const CopcKey& page : below[key])
      put_node(record.data, page, extents[page].offset, extents[page].size, -1);
  }
  // A root without points.
  if (plan.nodes.empty()) {
    put_node(record.data, CopcKey{}, 0, 0, 0);
    extents[CopcKey{}].size = record.data.size();
  }
  plan.info.root_page_size = extents[CopcKey{}].size;
  return record;
}

}  // namespace alidade
