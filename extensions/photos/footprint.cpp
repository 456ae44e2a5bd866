// SPDX-License-Identifier: MIT
#include "extensions/photos/footprint.h"

#include <algorithm>
#include <cmath>
#include <glm/vec2.hpp>
#include <unordered_map>
#include <utility>

namespace alidade::visibility {
namespace {

/// A corner of cells, by column and row of the cell south-east of it.
using Corner = glm::ivec2;

// Directions along the sides of cells; the next one is to the left.
enum Direction { east, north, west, south };
constexpr Corner k_steps[] = {{1, 0}, {0, -1}, {-1, 0}, {0, 1}};
// The cell to the left of a side that leaves a corner, by direction; the cell to its right is
// that of the direction before.
constexpr Corner k_left_cells[] = {{0, -1}, {-1, -1}, {-1, 0}, {0, 0}};

/// A closed line along sides of cells, with marked cells to its left.
struct Ring {
  std::vector<Corner> corners;
  std::uint32_t component = 0;  ///< of the cells to its left
};

class Tracer {
 public:
  Tracer(const geo::RasterGrid& grid, std::span<const std::uint8_t> marked)
      : grid_(grid), marked_(marked), components_(grid.size(), 0), is_traced_(grid.size()) {
    label();
  }

  std::uint32_t component_count() const { return count_; }

  std::vector<Ring> rings() {
    std::vector<Ring> all;
    for (int row = 0; row < grid_.rows; ++row) {
      for (int column = 0; column < grid_.columns; ++column) {
        const Corner start(column, row + 1);
        if (leaves(start, east) && is_traced_[grid_.index(column, row)] == 0) trace(start, all);
      }
    }
    return all;
  }

 private:
  bool is_marked(const Corner& cell) const {
    return cell.x >= 0 && cell.y >= 0 && cell.x < grid_.columns && cell.y < grid_.rows &&
           marked_[grid_.index(cell.x, cell.y)] != 0;
  }

  /// Whether the side in that direction is on an outline.
  bool leaves(const Corner& corner, int direction) const {
    return is_marked(corner + k_left_cells[direction]) &&
           !is_marked(corner + k_left_cells[(direction + 3) % 4]);
  }

  /// Numbers the connected components of cells, from 1.
  void label() {
    std::vector<Corner> open;
    for (int row = 0; row < grid_.rows; ++row) {
      for (int column = 0; column < grid_.columns; ++column) {
        if (!is_marked({column, row}) || component_at({column, row}) != 0) continue;
        component_at({column, row}) = ++count_;
        open.emplace_back(column, row);
        while (!open.empty()) {
          const Corner cell = open.back();
          open.pop_back();
          for (const Corner& step : k_steps) {
            if (!is_marked(cell + step) || component_at(cell + step) != 0) continue;
            component_at(cell + step) = count_;
            open.push_back(cell + step);
          }
        }
      }
    }
  }
  std::uint32_t& component_at(const Corner& cell) { return components_[grid_.index(cell.x, cell.y)]; }

  /// Follows an outline from an eastward side, and cuts it where it returns to a corner.
  void trace(const Corner& start, std::vector<Ring>& all) {
    std::vector<Corner> path{start};
    std::unordered_map<std::uint64_t, std::size_t> indices{{key_of(start), 0}};
    Corner at = start;
    int direction = east;
    do {
      const Corner cell = at + k_left_cells[direction];
      if (direction == east) is_traced_[grid_.index(cell.x, cell.y)] = 1;
      at += k_steps[direction];
      // Left first: where four cells meet and two opposite ones are marked, an outline follows its own cells.
      int next = (direction + 1) % 4;
      while (!leaves(at, next)) next = (next + 3) % 4;
      if (next != direction) arrive(at, path, indices, all);
      direction = next;
    } while (at != start || direction != east);
  }

  /// `indices`: of the corners in the path.
  void arrive(const Corner& at, std::vector<Corner>& path,
              std::unordered_map<std::uint64_t, std::size_t>& indices, std::vector<Ring>& all) {
    const auto [found, is_new] = indices.emplace(key_of(at), path.size());
    if (is_new) {
      path.push_back(at);
      return;
    }
    const std::size_t begin = found->second;
    Ring& ring = all.emplace_back();
    ring.corners.assign(path.begin() + static_cast<std::ptrdiff_t>(begin), path.end());
    for (std::size_t i = begin + 1; i < path.size(); ++i) indices.erase(key_of(path[i]));
    path.resize(begin + 1);
    ring.component = component_at(ring.corners[0] + k_left_cells[direction_of(ring)]);
  }

  static int direction_of(const Ring& ring) {
    const Corner step = ring.corners[1] - ring.corners[0];
    return step.x > 0 ? east : step.y < 0 ? north : step.x < 0 ? west : south;
  }
  static std::uint64_t key_of(const Corner& corner) {
    return std::uint64_t{static_cast<std::uint32_t>(corner.y)} << 32 | static_cast<std::uint32_t>(corner.x);
  }

  const geo::RasterGrid& grid_;
  std::span<const std::uint8_t> marked_;
  std::vector<std::uint32_t> components_;
  std::vector<std::uint8_t> is_traced_;  ///< by cell: its southern side
  std::uint32_t count_ = 0;
};

/// Twice the area, positive counter-clockwise with north up.
std::int64_t doubled_ring_area(const Ring& ring) {
  std::int64_t area = 0;
  for (std::size_t i = 0; i < ring.corners.size(); ++i) {
    const Corner &a = ring.corners[i], &b = ring.corners[(i + 1) % ring.corners.size()];
    area += std::int64_t{b.x} * a.y - std::int64_t{a.x} * b.y;
  }
  return area;
}

std::vector<glm::dvec2> world_ring(const geo::RasterGrid& grid, const Ring& ring) {
  std::vector<glm::dvec2> corners;
  for (const Corner& corner : ring.corners)
    corners.emplace_back(grid.north_west.x + corner.x * grid.cell_size,
                         grid.north_west.y - corner.y * grid.cell_size);
  return corners;
}

}  // namespace

std::vector<PlanePolygon> outline(const geo::RasterGrid& grid, std::span<const std::uint8_t> marked) {
  Tracer tracer(grid, marked);
  const std::vector<Ring> rings = tracer.rings();
  std::vector<PlanePolygon> polygons(tracer.component_count());
  for (const bool is_outer : {true, false}) {
    for (const Ring& ring : rings)
      if ((doubled_ring_area(ring) > 0) == is_outer)
        polygons[ring.component - 1].rings.push_back(world_ring(grid, ring));
  }
  return polygons;
}

double footprint_cell(const Bounds& area, double median_spacing) {
  constexpr double k_most_cells = 1 << 20;
  const glm::dvec3 size = area.max - area.min;
  const double least =
      std::max(2.0 * median_spacing, std::sqrt(std::max(size.x * size.y, 0.0) / k_most_cells));
  const double longest = std::max(size.x, size.y) / k_most_cells;
  const double wanted = std::max(least, longest), power = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= wanted * (1.0 - 1e-9)) return factor * power;
  return 10.0 * power;
}

}  // namespace alidade::visibility
