// SPDX-License-Identifier: MIT
#include "cloud/copc/plan_copc.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>

#include "base/bytes.h"
#include "base/error.h"
#include "base/morton.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

constexpr int k_grid_bits = 7;  ///< cells of a node's grid along a side
constexpr int k_deepest = k_morton_bits - k_grid_bits;
constexpr int k_page_levels = 4;
constexpr std::size_t k_most_page_nodes = 1024;

/// A point by its position along Morton's curve.
struct SortedPoint {
  std::uint64_t code = 0;
  std::uint32_t row = 0;

  bool operator<(const SortedPoint& other) const {
    return code != other.code ? code < other.code : row < other.row;
  }
};

CopcInfo root_of(const PointCloud& cloud) {
  CopcInfo info;
  const Bounds bounds = cloud.bounds();
  const glm::dvec3 size = bounds.size();
  const double step = std::max({cloud.lattice.scale.x, cloud.lattice.scale.y, cloud.lattice.scale.z});
  info.centre = bounds.empty() ? cloud.lattice.offset : bounds.center();
  // A step more than half, so that no point lies on the border.
  info.half_size = 0.5 * std::max({size.x, size.y, size.z}) + step;
  info.spacing = 2.0 * info.half_size / (1 << k_grid_bits);
  return info;
}

std::vector<SortedPoint> sorted_points(const PointCloud& cloud, const CopcInfo& info) {
  std::vector<SortedPoint> points(cloud.size());
  const glm::dvec3 low = info.centre - info.half_size;
  const double cells = std::ldexp(1.0, k_morton_bits) / (2.0 * info.half_size);
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t row) {
    const glm::dvec3 position = cells * (cloud.world(row) - low);
    glm::uvec3 cell;
    for (int axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<std::uint32_t>(
          std::clamp(std::floor(position[axis]), 0.0, std::ldexp(1.0, k_morton_bits) - 1.0));
    points[row] = {morton_key(cell.x, cell.y, cell.z), static_cast<std::uint32_t>(row)};
  });
  tbb::parallel_sort(points.begin(), points.end());
  return points;
}

/// The number of a point's cube on a level.
std::uint64_t cube_of(std::uint64_t code, int level) {
  return code >> 3 * (k_morton_bits - level);
}

/// Points of a cube that no node above it takes.
struct Rest {
  std::size_t begin = 0, end = 0;
};

/// Takes one point of every cell of a cube's grid, in the order of the curve; the others close up at the beginning of
/// the range, whose end is moved.
std::vector<std::uint32_t> take_grid(std::vector<SortedPoint>& points, Rest& rest, int level) {
  std::vector<std::uint32_t> taken;
  std::size_t kept = rest.begin;
  for (std::size_t first = rest.begin; first < rest.end;) {
    const std::uint64_t cell = cube_of(points[first].code, level + k_grid_bits);
    std::size_t last = first + 1;
    while (last < rest.end && cube_of(points[last].code, level + k_grid_bits) == cell) ++last;
    const std::size_t middle = (first + last) / 2;
    taken.push_back(points[middle].row);
    for (std::size_t i = first; i < last; ++i)
      if (i != middle) points[kept++] = points[i];
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

CopcPlan plan_copc(PointCloud& cloud, std::size_t most_points) {
  // A node's count has 31 bits, and one node may have to take all.
  if (cloud.size() > std::numeric_limits<std::int32_t>::max())
    throw input_error("too many points for COPC", "at most 2147483647", std::to_string(cloud.size()));
  CopcPlan plan;
  plan.info = root_of(cloud);
  std::vector<SortedPoint> points = sorted_points(cloud, plan.info);
  std::vector<std::uint32_t> order;
  order.reserve(points.size());
  std::vector<Rest> level_rests{{0, points.size()}};
  for (int level = 0; !level_rests.empty() && !points.empty(); ++level) {
    std::vector<std::vector<std::uint32_t>> taken(level_rests.size());
    std::vector<std::uint64_t> cubes(level_rests.size());
    tbb::parallel_for(std::size_t{0}, level_rests.size(), [&](std::size_t i) {
      Rest& rest = level_rests[i];
      cubes[i] = cube_of(points[rest.begin].code, level);
      if (rest.end - rest.begin > most_points && level < k_deepest) {
        taken[i] = take_grid(points, rest, level);
        return;
      }
      for (std::size_t point = rest.begin; point < rest.end; ++point) taken[i].push_back(points[point].row);
      rest.end = rest.begin;
    });
    std::vector<Rest> next;
    for (std::size_t i = 0; i < level_rests.size(); ++i) {
      plan.nodes.push_back({{level, static_cast<std::int32_t>(morton_coordinate(cubes[i], 0)),
                             static_cast<std::int32_t>(morton_coordinate(cubes[i], 1)),
                             static_cast<std::int32_t>(morton_coordinate(cubes[i], 2))},
                            static_cast<std::uint32_t>(taken[i].size())});
      order.insert(order.end(), taken[i].begin(), taken[i].end());
      for (std::size_t first = level_rests[i].begin; first < level_rests[i].end;) {
        const auto in_other_cube = [&,
                                    cube = cube_of(points[first].code, level + 1)](const SortedPoint& point) {
          return cube_of(point.code, level + 1) != cube;
        };
        const auto end = points.begin() + static_cast<std::ptrdiff_t>(level_rests[i].end);
        const auto last =
            std::find_if(points.begin() + static_cast<std::ptrdiff_t>(first), end, in_other_cube);
        next.push_back({first, static_cast<std::size_t>(last - points.begin())});
        first = next.back().end;
      }
    }
    level_rests = std::move(next);
  }
  assert(order.size() == cloud.size());
  points = {};
  reorder_attributes(cloud, order);
  std::vector<LatticePosition> positions(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) positions[i] = cloud.positions[order[i]];
  cloud.positions = std::move(positions);
  return plan;
}

VariableLengthRecord copc_info_record(const CopcInfo& info, const PointCloud& cloud) {
  VariableLengthRecord record{
      .user_id = "copc", .record_id = 1, .description = "COPC info", .data = std::vector<std::uint8_t>(160)};
  std::byte* const at = std::as_writable_bytes(std::span(record.data)).data();
  for (int axis = 0; axis < 3; ++axis) store(at + 8 * axis, info.centre[axis]);
  store(at + 24, info.half_size);
  store(at + 32, info.spacing);
  store(at + 40, info.root_page);
  store(at + 48, info.root_page_size);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double time : cloud.gps_times) {
    if (!std::isfinite(time)) continue;
    low = std::min(low, time);
    high = std::max(high, time);
  }
  if (low <= high) {
    store(at + 56, low);
    store(at + 64, high);
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
  struct Place {
    std::uint64_t offset, size;
  };
  std::map<CopcKey, Place> places;
  std::uint64_t end = plan.info.root_page;
  for (const auto& [key, nodes] : pages) {
    places[key] = {end, 32 * (nodes.size() + below[key].size())};
    end += places[key].size;
  }
  VariableLengthRecord record{
      .user_id = "copc", .record_id = 1000, .description = "COPC hierarchy", .data = {}, .extended = true};
  for (const auto& [key, nodes] : pages) {
    for (const std::size_t i : nodes)
      put_node(record.data, plan.nodes[i].key, chunks[i].offset, chunks[i].byte_count,
               static_cast<std::int32_t>(chunks[i].point_count));
    for (const CopcKey& page : below[key])
      put_node(record.data, page, places[page].offset, places[page].size, -1);
  }
  // A root without points.
  if (plan.nodes.empty()) {
    put_node(record.data, CopcKey{}, 0, 0, 0);
    places[CopcKey{}].size = record.data.size();
  }
  plan.info.root_page_size = places[CopcKey{}].size;
  return record;
}

}  // namespace alidade
