// SPDX-License-Identifier: MIT
#include "cloud/thin.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "base/error.h"
#include "cloud/keep_rows.h"

namespace alidade {
namespace {

constexpr std::size_t k_at_once = 1 << 20;
constexpr std::size_t k_grain = 4096;
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
  Grid(const PointCloud& cloud, double edge) : lattice_(cloud.lattice), edge_(edge) {
    LatticePosition low = cloud.positions.front(), high = low;
    for (const LatticePosition& position : cloud.positions) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], position[axis]);
        high[axis] = std::max(high[axis], position[axis]);
      }
    }
    // The number of a cube never falls when a coordinate grows, so the first and last are those of the box.
    first_ = cube_of(low);
    const glm::dvec3 count = cube_of(high) - first_;
    for (int axis = 0; axis < 3; ++axis) {
      if (count[axis] < static_cast<double>(k_most)) continue;
      throw Error({.problem = "spacing is too fine for a cloud of this size",
                   .expected = fmt::format("at most {} cubes along an axis", k_most),
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
    // Of coordinates that are whole edges up to their rounding none shall fall into the cube below.
    constexpr double k_below = 1e-6;
    const glm::dvec3 place = to_world(lattice_, position);
    return {std::floor(place.x / edge_ + k_below), std::floor(place.y / edge_ + k_below),
            std::floor(place.z / edge_ + k_below)};
  }

  Lattice lattice_;
  double edge_;
  glm::dvec3 first_{0.0};
};

std::vector<Entry> sorted_entries(const PointCloud& cloud, double edge, const Progress& progress) {
  const Grid grid(cloud, edge);
  std::vector<Entry> entries(cloud.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cloud.size(), k_grain),
                    [&](const tbb::blocked_range<std::size_t>& rows) {
                      for (std::size_t row = rows.begin(); row < rows.end(); ++row)
                        entries[row] = {grid(cloud.positions[row]), static_cast<std::uint32_t>(row)};
                    });
  report(progress, 0, cloud.size());
  tbb::parallel_sort(entries.begin(), entries.end());
  return entries;
}

/// The row nearest to the mean of the cube's points. Differences are taken times the number of points, in
/// whole steps, so that equal distances are equal.
std::uint32_t nearest_to_mean(const PointCloud& cloud, std::span<const Entry> cube) {
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

/// Marks the point that stays for a cube, and gives it the means.
void choose(PointCloud& cloud, std::span<const Entry> cube, std::vector<std::uint8_t>& marks) {
  const std::uint32_t chosen = nearest_to_mean(cloud, cube);
  marks[chosen] = 1;
  if (!cloud.colors.empty()) {
    Color16 color;
    for (int channel = 0; channel < 3; ++channel)
      color[channel] = mean(cube, [&](std::uint32_t row) { return cloud.colors[row][channel]; });
    cloud.colors[chosen] = color;
  }
  const auto average = [&](std::vector<std::uint16_t>& column) {
    if (!column.empty()) column[chosen] = mean(cube, [&](std::uint32_t row) { return column[row]; });
  };
  average(cloud.near_infrared);
  average(cloud.intensities);
}

/// Calls choose() for the cubes whose first entry lies in [begin, end).
void choose_in(PointCloud& cloud, std::span<const Entry> entries, std::size_t begin, std::size_t end,
               std::vector<std::uint8_t>& marks) {
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

void thin(PointCloud& cloud, double edge, const Progress& progress) {
  if (!(edge > 0.0 && std::isfinite(edge))) {
    throw Error({.problem = "bad spacing", .expected = "a length above 0", .found = fmt::format("{}", edge)});
  }
  const std::size_t size = cloud.size();
  if (size == 0) return;
  if (size > k_most) {
    throw Error({.problem = "too many points to be thinned",
                 .expected = fmt::format("at most {}", k_most),
                 .found = std::to_string(size)});
  }
  std::vector<std::uint8_t> marks(size, 0);
  {
    const std::vector<Entry> entries = sorted_entries(cloud, edge, progress);
    for (std::size_t first = 0; first < size; first += k_at_once) {
      const std::size_t end = std::min(first + k_at_once, size);
      tbb::parallel_for(tbb::blocked_range<std::size_t>(first, end, k_grain),
                        [&](const tbb::blocked_range<std::size_t>& part) {
                          choose_in(cloud, entries, part.begin(), part.end(), marks);
                        });
      report(progress, end, size);
    }
  }
  keep_rows(cloud, marks);
}

}  // namespace alidade
