// SPDX-License-Identifier: MIT
#include "cloud/select_points.h"

#include <fmt/format.h>
#include <tbb/parallel_sort.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "cloud/rows.h"

namespace alidade {

namespace {

constexpr std::size_t k_most_strips = 1 << 16;
/// Most strips of an edge, on average.
constexpr std::size_t k_most_strips_per_edge = 4;

/// How far outside a point still counts as on the border, per axis.
glm::dvec3 border_of(const Lattice& lattice) {
  glm::dvec3 border;
  for (int axis = 0; axis < 3; ++axis)
    border[axis] = std::max(1e-3 * lattice.scale[axis], 1e-15 * std::abs(lattice.offset[axis]));
  return border;
}

/// Calls work(begin, end) for parts of [0, size), from many threads.
template <class Work>
void for_parts(std::size_t size, const Progress& progress, const Work& work) {
  constexpr std::size_t k_at_once = 1 << 20, k_grain = 4096;
  for (std::size_t first = 0; first < size; first += k_at_once) {
    const std::size_t end = std::min(first + k_at_once, size);
    in_blocks(end - first, k_grain,
              [&](std::size_t part, std::size_t part_end) { work(first + part, first + part_end); });
    report(progress, end, size);
  }
}

/// Keeps the points for whose world position `stays` returns true; many threads call it.
template <class Stays>
void keep_where(PointCloud& cloud, const Stays& stays, const Progress& progress) {
  std::vector<std::uint8_t> marks(cloud.size());
  for_parts(cloud.size(), progress, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) marks[row] = stays(cloud.world(row)) ? 1 : 0;
  });
  keep_rows(cloud, marks);
}

constexpr std::uint64_t k_most = std::numeric_limits<std::uint32_t>::max();

/// A point and its cube, counted from the lowest one of the cloud.
struct Entry {
  std::array<std::uint32_t, 3> cube;
  std::uint32_t row;
  bool operator<(const Entry& other) const {
    return cube != other.cube ? cube < other.cube : row < other.row;
  }
};

/// The cubes of the grid.
class Grid {
 public:
  Grid(const ThinnedColumns& cloud, double edge) : lattice_(cloud.lattice), edge_(edge) {
    LatticeExtent extent;
    for (const LatticePosition& position : cloud.positions) extent.grow(position);
    // Numbers of cubes never decrease with a coordinate, so the first and last are those of the box.
    first_ = cube_of(extent.low);
    const glm::dvec3 count = cube_of(extent.high) - first_;
    for (int axis = 0; axis < 3; ++axis) {
      if (count[axis] < static_cast<double>(k_most)) continue;
      throw Error({.problem = "spacing too small for the extent of the cloud",
                   .expected = fmt::format("at most {} cells along an axis", k_most),
                   .found = fmt::format("a spacing of {}", edge)});
    }
  }

  std::array<std::uint32_t, 3> operator()(const LatticePosition& position) const {
    const glm::dvec3 cube = cube_of(position) - first_;
    return {static_cast<std::uint32_t>(cube.x), static_cast<std::uint32_t>(cube.y),
            static_cast<std::uint32_t>(cube.z)};
  }

 private:
  glm::dvec3 cube_of(const LatticePosition& position) const {
    // So that coordinates that are multiples of the edge, up to rounding, are not in the cube below.
    constexpr double k_below = 1e-6;
    const glm::dvec3 world = to_world(lattice_, position);
    return {std::floor(world.x / edge_ + k_below), std::floor(world.y / edge_ + k_below),
            std::floor(world.z / edge_ + k_below)};
  }

  Lattice lattice_;
  double edge_;
  glm::dvec3 first_{0.0};
};

HugeArray<Entry> sorted_entries(const ThinnedColumns& cloud, double edge, const ScratchFolder& scratch,
                                const Progress& progress) {
  const Grid grid(cloud, edge);
  const std::size_t size = cloud.positions.size();
  HugeArray<Entry> entries(size, scratch);
  for_parts(size, {}, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      entries[row] = {grid(cloud.positions[row]), static_cast<std::uint32_t>(row)};
  });
  report(progress, 0, size);
  tbb::parallel_sort(entries.data(), entries.data() + size);
  return entries;
}

/// The row nearest to the mean of the cube's points. Differences are multiplied by the number of points, so
/// that they are whole steps and equal distances are equal.
std::uint32_t nearest_to_mean(const ThinnedColumns& cloud, std::span<const Entry> cube) {
  const glm::i64vec3 origin(cloud.positions[cube.front().row]);
  glm::i64vec3 sum(0);
  for (const Entry& entry : cube) sum += glm::i64vec3(cloud.positions[entry.row]) - origin;
  const double count = static_cast<double>(cube.size());
  std::uint32_t nearest = cube.front().row;
  double least = std::numeric_limits<double>::infinity();
  for (const Entry& entry : cube) {
    const glm::dvec3 steps =
        count * glm::dvec3(glm::i64vec3(cloud.positions[entry.row]) - origin) - glm::dvec3(sum);
    const glm::dvec3 away = cloud.lattice.scale * steps;
    const double distance = away.x * away.x + away.y * away.y + away.z * away.z;
    if (distance < least) {
      least = distance;
      nearest = entry.row;
    }
  }
  return nearest;
}

/// Mean of value(row) over the cube, rounded.
template <class Value>
std::uint16_t mean(std::span<const Entry> cube, const Value& value) {
  std::uint64_t sum = 0;
  for (const Entry& entry : cube) sum += value(entry.row);
  return static_cast<std::uint16_t>((sum + cube.size() / 2) / cube.size());
}

/// Marks the point of a cube that is kept, and sets its values to the means.
void choose(const ThinnedColumns& cloud, std::span<const Entry> cube, HugeVector<std::uint8_t>& marks) {
  const std::uint32_t chosen = nearest_to_mean(cloud, cube);
  marks[chosen] = 1;
  if (!cloud.colors.empty()) {
    Color16 color;
    for (int channel = 0; channel < 3; ++channel)
      color[channel] = mean(cube, [&](std::uint32_t row) { return cloud.colors[row][channel]; });
    cloud.colors[chosen] = color;
  }
  const auto average = [&](std::span<std::uint16_t> column) {
    if (!column.empty()) column[chosen] = mean(cube, [&](std::uint32_t row) { return column[row]; });
  };
  average(cloud.near_infrared);
  average(cloud.intensities);
}

/// Calls choose() for the cubes whose first entry lies in [begin, end).
void choose_in(const ThinnedColumns& cloud, std::span<const Entry> entries, std::size_t begin,
               std::size_t end, HugeVector<std::uint8_t>& marks) {
  std::size_t first = begin;
  while (first > 0 && first < end && entries[first].cube == entries[first - 1].cube) ++first;
  while (first < end) {
    std::size_t behind = first + 1;
    while (behind < entries.size() && entries[behind].cube == entries[first].cube) ++behind;
    choose(cloud, entries.subspan(first, behind - first), marks);
    first = behind;
  }
}

}  // namespace

/// The edges of polygons, sorted into strips from south to north, to test many positions.
class PolygonStrips {
 public:
  /// Positions up to `border` outside count as on the border. Corners are finite.
  PolygonStrips(std::span<const PlanePolygon> polygons, double border)
      : border_(border),
        low_(std::numeric_limits<double>::infinity()),
        high_(-std::numeric_limits<double>::infinity()) {
    for (std::size_t polygon = 0; polygon < polygons.size(); ++polygon) {
      for (const std::vector<glm::dvec2>& ring : polygons[polygon].rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
          edges_.push_back({ring[i], ring[i + 1 < ring.size() ? i + 1 : 0], polygon});
          for (int axis = 0; axis < 2; ++axis) {
            low_[axis] = std::min(low_[axis], ring[i][axis] - border_);
            high_[axis] = std::max(high_[axis], ring[i][axis] + border_);
          }
        }
      }
    }
    strip_count_ = std::clamp<std::size_t>(edges_.size(), 1, k_most_strips);
    begins_ = strip_begins();
    // Edges that run from south to north are in all strips: with many of them, fewer strips.
    while (strip_count_ > 1 && begins_.back() > k_most_strips_per_edge * edges_.size()) {
      strip_count_ /= 2;
      begins_ = strip_begins();
    }
    strip_edges_.resize(begins_.back());
    std::vector<std::size_t> next = begins_;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const auto [south, north] = std::minmax(edges_[i].a.y, edges_[i].b.y);
      for (std::size_t strip = strip_of(south - border_); strip <= strip_of(north + border_); ++strip)
        strip_edges_[next[strip]++] = i;
    }
  }

  /// Whether a position lies in one of the polygons or on a border.
  bool contains(const glm::dvec2& position) const {
    if (!(position.x >= low_.x && position.x <= high_.x && position.y >= low_.y && position.y <= high_.y))
      return false;
    const std::size_t strip = strip_of(position.y);
    bool inside = false;
    std::size_t polygon = 0;
    for (std::size_t i = begins_[strip]; i < begins_[strip + 1]; ++i) {
      const Edge& edge = edges_[strip_edges_[i]];
      if (edge.polygon != polygon) {
        if (inside) return true;
        polygon = edge.polygon;
      }
      if (on_border(edge, position)) return true;
      // An edge includes its southern end and not its northern one, so that a corner counts once.
      if ((edge.a.y <= position.y) == (edge.b.y <= position.y)) continue;
      const double crossing =
          edge.a.x + (position.y - edge.a.y) / (edge.b.y - edge.a.y) * (edge.b.x - edge.a.x);
      if (crossing > position.x) inside = !inside;
    }
    return inside;
  }

 private:
  struct Edge {
    glm::dvec2 a, b;
    std::size_t polygon;
  };

  std::size_t strip_of(double y) const {
    const double strip = (y - low_.y) / (high_.y - low_.y) * static_cast<double>(strip_count_);
    // Also for polygons without height, whose quotient is NaN.
    if (!(strip > 0.0)) return 0;
    return strip < static_cast<double>(strip_count_) ? static_cast<std::size_t>(strip) : strip_count_ - 1;
  }

  /// The index in `strip_edges_` of each strip's first edge, and behind the last strip that of their end.
  std::vector<std::size_t> strip_begins() const {
    // The edges of a strip are those begun in it or before, without those that ended before it.
    std::vector<std::size_t> begun(strip_count_, 0), ended(strip_count_ + 1, 0);
    for (const Edge& edge : edges_) {
      const auto [south, north] = std::minmax(edge.a.y, edge.b.y);
      ++begun[strip_of(south - border_)];
      ++ended[strip_of(north + border_) + 1];
    }
    std::vector<std::size_t> begins(strip_count_ + 1, 0);
    std::size_t present = 0;
    for (std::size_t strip = 0; strip < strip_count_; ++strip) {
      present += begun[strip] - ended[strip];
      begins[strip + 1] = begins[strip] + present;
    }
    return begins;
  }

  bool on_border(const Edge& edge, const glm::dvec2& position) const {
    for (int axis = 0; axis < 2; ++axis) {
      if (position[axis] < std::min(edge.a[axis], edge.b[axis]) - border_ ||
          position[axis] > std::max(edge.a[axis], edge.b[axis]) + border_)
        return false;
    }
    const glm::dvec2 along = edge.b - edge.a, from = position - edge.a;
    const double length = along.x * along.x + along.y * along.y;
    const double share =
        length > 0.0 ? std::clamp((from.x * along.x + from.y * along.y) / length, 0.0, 1.0) : 0.0;
    const glm::dvec2 beside = from - share * along;
    return beside.x * beside.x + beside.y * beside.y <= border_ * border_;
  }

  std::vector<Edge> edges_;  ///< those of one polygon are contiguous
  double border_;
  glm::dvec2 low_, high_;  ///< box of all edges with their border
  std::size_t strip_count_ = 1;
  std::vector<std::size_t> begins_;       ///< see strip_begins()
  std::vector<std::size_t> strip_edges_;  ///< of each strip, in the order of `edges_`
};

void crop(PointCloud& cloud, const Bounds& box, const Progress& progress) {
  const glm::dvec3 border = border_of(cloud.lattice);
  const Bounds wider{box.min - border, box.max + border};
  keep_where(
      cloud, [&](const glm::dvec3& position) { return wider.contains(position); }, progress);
}

void crop(PointCloud& cloud, std::span<const PlanePolygon> polygons, const Progress& progress) {
  const glm::dvec3 border = border_of(cloud.lattice);
  const PolygonStrips strips(polygons, std::max(border.x, border.y));
  keep_where(
      cloud,
      [&](const glm::dvec3& position) {
        return strips.contains({position.x, position.y});
      },
      progress);
}

HugeVector<std::uint8_t> mark_thinned(const ThinnedColumns& cloud, double edge, const ScratchFolder& scratch,
                                      const Progress& progress) {
  if (!(edge > 0.0 && std::isfinite(edge))) {
    throw Error(
        {.problem = "invalid spacing", .expected = "a positive length", .found = fmt::format("{}", edge)});
  }
  const std::size_t size = cloud.positions.size();
  if (size > k_most) {
    throw Error({.problem = "too many points to thin",
                 .expected = fmt::format("at most {}", k_most),
                 .found = std::to_string(size)});
  }
  HugeVector<std::uint8_t> marks(size, 0, scratch);
  if (size == 0) return marks;
  const HugeArray<Entry> entries = sorted_entries(cloud, edge, scratch, progress);
  for_parts(size, progress, [&](std::size_t begin, std::size_t end) {
    choose_in(cloud, {entries.data(), size}, begin, end, marks);
  });
  return marks;
}

void thin(PointCloud& cloud, double edge, const Progress& progress) {
  const ThinnedColumns columns{cloud.lattice, cloud.positions, cloud.colors, cloud.near_infrared,
                               cloud.intensities};
  keep_rows(cloud, mark_thinned(columns, edge, {}, progress));
}

}  // namespace alidade
