// SPDX-License-Identifier: MIT
#include "geo/terrain_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <tuple>
#include <utility>

#include "base/parallel.h"
#include "base/ray_slabs.h"

namespace alidade::geo {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// Levels halve, and a side has fewer than 2^31 cells.
constexpr int k_most_levels = 31;

/// Where a ray may cross the surface of a patch, in order.
struct Roots {
  std::array<double, 2> values{};
  int count = 0;

  void add(double value) { values[static_cast<std::size_t>(count++)] = value; }
};

/// Zeros in [0, length] of the quadratic with this square term and these values at both ends. There is one at
/// least if the ends do not lie on one side of 0, whatever the rounding.
Roots zeros(double square, double at_begin, double at_end, double length) {
  Roots roots;
  const bool is_crossed = (at_begin <= 0.0 && at_end >= 0.0) || (at_begin >= 0.0 && at_end <= 0.0);
  if (!(length > 0.0)) {
    if (at_begin == 0.0) roots.add(0.0);
    return roots;
  }
  const double linear = (at_end - at_begin) / length - square * length;
  double discriminant = linear * linear - 4.0 * square * at_begin;
  if (discriminant < 0.0) {
    if (!is_crossed) return roots;
    discriminant = 0.0;
  }
  // Neither of the two roots loses digits.
  const double q = -0.5 * (linear + std::copysign(std::sqrt(discriminant), linear));
  double one = square != 0.0 ? q / square : k_infinity, other = q != 0.0 ? at_begin / q : one;
  // The quadratic is constant.
  if (square == 0.0 && q == 0.0) other = at_begin == 0.0 ? 0.0 : k_infinity;
  if (other < one) std::swap(one, other);
  const auto is_inside = [length](double root) { return root >= 0.0 && root <= length; };
  if (is_inside(one)) roots.add(one);
  if (is_inside(other) && other != one) roots.add(other);
  if (!is_crossed || roots.count > 0) return roots;
  // Rounding moved the root beyond an end.
  const auto outside = [length](double root) { return std::max(-root, root - length); };
  roots.add(std::clamp(outside(one) <= outside(other) ? one : other, 0.0, length));
  return roots;
}

bool is_before(const TerrainHit& hit, const std::optional<TerrainHit>& best) {
  return !best || std::tuple(hit.t, hit.row, hit.column) < std::tuple(best->t, best->row, best->column);
}

}  // namespace

/// A square of patches, 2^level wide; level 0 is a patch.
struct TerrainSurface::Square {
  int level = 0, column = 0, row = 0;
};

/// A ray on its way over the grid: x and y in cells from the centre of the north-western one, east and south.
class TerrainSurface::Walk : public RaySlabs {
 public:
  Walk(const Ray& ray, const RasterGrid& grid)
      : RaySlabs({(ray.origin.x - grid.north_west.x) / grid.cell_size - 0.5,
                  (grid.north_west.y - ray.origin.y) / grid.cell_size - 0.5, ray.origin.z},
                 {ray.direction.x / grid.cell_size, -ray.direction.y / grid.cell_size, ray.direction.z}),
        t_min(ray.t_min),
        t_max(ray.t_max),
        ray_(ray) {}

  double at(int axis, double t) const { return origin()[axis] + t * direction()[axis]; }
  const Ray& ray() const { return ray_; }

  /// Children of a square, 0 to 3 by column + 2 row, in the order in which the ray meets them.
  std::array<int, 4> order() const {
    const int first = (direction().x < 0.0 ? 1 : 0) + (direction().y < 0.0 ? 2 : 0);
    return {first, first ^ 1, first ^ 2, first ^ 3};
  }

  double t_min, t_max;

 private:
  Ray ray_;
};

TerrainSurface::TerrainSurface(Raster<float> heights) : heights_(std::move(heights)) {
  const RasterGrid& grid = heights_.grid;
  float highest = 0.0f;
  for (float& height : heights_.values) {
    if (!std::isfinite(height)) height = std::numeric_limits<float>::quiet_NaN();
    highest = std::max(highest, std::fabs(height));
  }
  // A flat box must not lose rays to the rounding of its sides.
  slack_ = 0x1p-40 * (1.0 + highest);
  Level below{std::max(grid.columns - 1, 0), std::max(grid.rows - 1, 0), {}};
  while (below.columns > 0 && below.rows > 0 && (levels_.empty() || below.columns > 1 || below.rows > 1)) {
    Level level{(below.columns + 1) / 2, (below.rows + 1) / 2, {}};
    level.ranges.resize(static_cast<std::size_t>(level.columns) * static_cast<std::size_t>(level.rows));
    const int level_below = static_cast<int>(levels_.size());
    in_parallel(level.rows, 16, [&](int row) {
      for (int column = 0; column < level.columns; ++column) {
        Range range{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
        for (int child = 0; child < 4; ++child) {
          const Square square{level_below, 2 * column + (child & 1), 2 * row + (child >> 1)};
          if (square.column >= below.columns || square.row >= below.rows) continue;
          const Range part = range_of(square);
          range = {std::min(range.low, part.low), std::max(range.high, part.high)};
        }
        level.ranges[static_cast<std::size_t>(row) * level.columns + column] = range;
      }
    });
    below = {level.columns, level.rows, {}};
    levels_.push_back(std::move(level));
  }
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const Range range = patch_range(column, row);
      if (range.low > range.high) continue;
      ++patch_count_;
      bounds_.grow(box_of({0, column, row}, range));
    }
  }
}

glm::ivec2 TerrainSurface::size_of(int level) const {
  if (level == 0) return {heights_.grid.columns - 1, heights_.grid.rows - 1};
  const Level& of_all = levels_[static_cast<std::size_t>(level - 1)];
  return {of_all.columns, of_all.rows};
}

TerrainSurface::Range TerrainSurface::patch_range(int column, int row) const {
  const float* const north = &heights_.at(column, row);
  const float* const south = north + heights_.grid.columns;
  // NaN if one of them is.
  if (std::isnan(north[0] + north[1] + south[0] + south[1]))
    return {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  return {std::min(std::min(north[0], north[1]), std::min(south[0], south[1])),
          std::max(std::max(north[0], north[1]), std::max(south[0], south[1]))};
}

TerrainSurface::Range TerrainSurface::range_of(const Square& square) const {
  if (square.level == 0) return patch_range(square.column, square.row);
  const Level& level = levels_[static_cast<std::size_t>(square.level - 1)];
  return level.ranges[static_cast<std::size_t>(square.row) * level.columns + square.column];
}

Bounds TerrainSurface::box_of(const Square& square, const Range& range) const {
  const RasterGrid& grid = heights_.grid;
  const auto last = [&square](int first, int most) {
    return static_cast<int>(std::min<std::int64_t>((std::int64_t{first} + 1) << square.level, most));
  };
  const glm::dvec2 north_west = grid.center(square.column << square.level, square.row << square.level),
                   south_east =
                       grid.center(last(square.column, grid.columns - 1), last(square.row, grid.rows - 1));
  return {{north_west.x, south_east.y, range.low}, {south_east.x, north_west.y, range.high}};
}

/// Calls visit(column, row, stretch) for the patches that the ray passes over or under, the near ones first,
/// until visit returns true. Leaves out a patch unless keep(range, stretch) accepts it and all squares that
/// hold it. keep() must accept a square if it accepts a patch of it, with its stretch and heights within
/// those of the square; it may accept fewer later: still(range, stretch) is called when a square's turn has
/// come, and may be cheaper.
template <class Keep, class Still, class Visit>
void TerrainSurface::descend(const Walk& walk, const Keep& keep, const Still& still,
                             const Visit& visit) const {
  struct Waiting {
    Square square;
    Range range;
    Stretch stretch;
  };
  if (levels_.empty()) return;
  const glm::ivec2 most = size_of(0);
  // Both halves of a square along an axis.
  const auto halves = [&walk](int axis, int first, int level, int last) {
    const std::int64_t low = std::int64_t{first} << level, half = std::int64_t{1} << (level - 1);
    const auto line = [last](std::int64_t at) {
      return static_cast<double>(std::min<std::int64_t>(at, last));
    };
    return std::array{walk.between(axis, line(low), line(low + half)),
                      walk.between(axis, line(low + half), line(low + 2 * half))};
  };
  const std::array<int, 4> order = walk.order();
  std::array<Waiting, 3 * k_most_levels + 1> waiting;
  int count = 0;
  const Square top{static_cast<int>(levels_.size()), 0, 0};
  waiting[count++] = {top, range_of(top), {walk.t_min, walk.t_max}};
  while (count > 0) {
    const Waiting one = waiting[--count];
    const Square& square = one.square;
    if (!still(one.range, one.stretch)) continue;
    const auto x = halves(0, square.column, square.level, most.x),
               y = halves(1, square.row, square.level, most.y);
    const int level = square.level - 1;
    const glm::ivec2 size = size_of(level);
    std::array<Waiting, 4> found;
    int found_count = 0;
    for (const int child : order) {
      const Square part{level, 2 * square.column + (child & 1), 2 * square.row + (child >> 1)};
      if (part.column >= size.x || part.row >= size.y) continue;
      Stretch stretch{walk.t_min, walk.t_max};
      stretch.cut(x[child & 1]);
      stretch.cut(y[child >> 1]);
      if (stretch.empty()) continue;
      const Range range = range_of(part);
      if (range.low > range.high || !keep(range, stretch)) continue;
      if (level > 0)
        found[found_count++] = {part, range, stretch};
      else if (visit(part.column, part.row, stretch))
        return;
    }
    while (found_count > 0) waiting[count++] = found[--found_count];
  }
}

/// Calls visit(column, row, stretch) as descend() for the patches that the ray may meet up to t = limit,
/// which may decrease meanwhile. meet() would reject those that are left out: the stretches of a square hold
/// those of its patches, and heights of the ray are compared with more slack.
template <class Visit>
void TerrainSurface::for_patches(const Walk& walk, const double& limit, const Visit& visit) const {
  const double slack = slack_ + 0x1p-40 * std::fabs(walk.ray().origin.z);
  descend(
      walk,
      [&](const Range& range, const Stretch& stretch) {
        if (stretch.begin > limit) return false;
        const double from = walk.at(2, stretch.begin), to = walk.at(2, stretch.end);
        const double low = range.low - slack, high = range.high + slack;
        return !((from < low && to < low) || (from > high && to > high));
      },
      [&](const Range&, const Stretch& stretch) { return stretch.begin <= limit; },
      [&](int column, int row, const Stretch&) { return visit(column, row); });
}

double TerrainSurface::horizon_slope(const glm::dvec3& eye, const glm::dvec2& direction, double least) const {
  const RasterGrid& grid = heights_.grid;
  const Walk walk({eye, {direction.x, direction.y, 0.0}, 0.0, k_infinity}, grid);
  // What is nearer than this rises as the patch does there: its share of a slope is lost to rounding.
  const double nearest = 1e-6 * grid.cell_size;
  double best = least;
  const auto may_rise = [&](const Range& range, const Stretch& stretch) {
    return range.high - eye.z > best * std::max(stretch.begin, 0.0);
  };
  descend(walk, may_rise, may_rise, [&](int column, int row, const Stretch& stretch) {
    const double nw = heights_.at(column, row), ne = heights_.at(column + 1, row),
                 sw = heights_.at(column, row + 1), se = heights_.at(column + 1, row + 1);
    // The height along the ray is start + linear t + square t^2, t from the eye on.
    const double twist = (se - sw) - (ne - nw), east = walk.at(0, 0.0) - column,
                 south = walk.at(1, 0.0) - row;
    const double along_x = walk.direction().x, along_y = walk.direction().y;
    const double rise = nw + (ne - nw) * east + (sw - nw) * south + twist * east * south - eye.z,
                 linear = (ne - nw + twist * south) * along_x + (sw - nw + twist * east) * along_y,
                 square = twist * along_x * along_y;
    if (stretch.end < nearest) return false;
    const auto take = [&](double t) { best = std::max(best, rise / t + linear + square * t); };
    const double begin = std::max(stretch.begin, nearest);
    if (stretch.begin < nearest && std::fabs(rise) < nearest) best = std::max(best, linear);
    take(begin);
    take(stretch.end);
    if (rise * square > 0.0) {
      const double between = std::sqrt(rise / square);
      if (between > begin && between < stretch.end) take(between);
    }
    return false;
  });
  return best;
}

/// The first hit of a patch that exists. Both patches of an edge compute one height where the ray crosses it:
/// so the ray is above or below it for both.
std::optional<TerrainHit> TerrainSurface::meet(const Walk& walk, int column, int row,
                                               const TerrainFilter& counts) const {
  const Range range = patch_range(column, row);
  const Stretch x = walk.between(0, column, column + 1), y = walk.between(1, row, row + 1);
  Stretch stretch{walk.t_min, walk.t_max};
  stretch.cut(x);
  stretch.cut(y);
  stretch.cut(walk.between(2, range.low - slack_, range.high + slack_));
  if (stretch.empty()) return std::nullopt;
  const double nw = heights_.at(column, row), ne = heights_.at(column + 1, row),
               sw = heights_.at(column, row + 1), se = heights_.at(column + 1, row + 1);
  const double twist = (se - sw) - (ne - nw);
  const auto east_of = [&](double t) { return std::clamp(walk.at(0, t) - column, 0.0, 1.0); };
  const auto south_of = [&](double t) { return std::clamp(walk.at(1, t) - row, 0.0, 1.0); };
  const auto edge = [](double from, double to, double share) { return from + share * (to - from); };
  // How far the ray is above the surface; on an edge by its two heights alone.
  const auto above = [&](double t) {
    const bool is_first = t == stretch.begin;
    const bool on_column = t == (is_first ? x.begin : x.end), on_row = t == (is_first ? y.begin : y.end);
    const bool in_east = on_column && (walk.direction().x > 0.0) != is_first,
               in_south = on_row && (walk.direction().y > 0.0) != is_first;
    double height;
    if (on_column && on_row)
      height = in_east ? (in_south ? se : ne) : (in_south ? sw : nw);
    else if (on_column)
      height = in_east ? edge(ne, se, south_of(t)) : edge(nw, sw, south_of(t));
    else if (on_row)
      height = in_south ? edge(sw, se, east_of(t)) : edge(nw, ne, east_of(t));
    else
      height = edge(edge(nw, ne, east_of(t)), edge(sw, se, east_of(t)), south_of(t));
    return walk.at(2, t) - height;
  };
  const double square = -twist * walk.direction().x * walk.direction().y;
  const Roots roots = zeros(square, above(stretch.begin), above(stretch.end), stretch.end - stretch.begin);
  for (int i = 0; i < roots.count; ++i) {
    TerrainHit hit{.t = std::min(stretch.begin + roots.values[static_cast<std::size_t>(i)], stretch.end),
                   .column = column,
                   .row = row};
    const double size = heights_.grid.cell_size;
    // South is against y.
    hit.normal = unit_direction(
        {-((ne - nw) + twist * south_of(hit.t)) / size, ((sw - nw) + twist * east_of(hit.t)) / size, 1.0});
    if (glm::dot(hit.normal, walk.ray().direction) > 0.0) hit.normal = -hit.normal;
    if (!counts || counts(hit)) return hit;
  }
  return std::nullopt;
}

std::optional<TerrainHit> TerrainSurface::closest(const Ray& ray, const TerrainFilter& counts) const {
  const Walk walk(ray, heights_.grid);
  std::optional<TerrainHit> best;
  double limit = ray.t_max;
  for_patches(walk, limit, [&](int column, int row) {
    const std::optional<TerrainHit> hit = meet(walk, column, row, counts);
    if (hit && is_before(*hit, best)) {
      best = hit;
      limit = hit->t;
    }
    return false;
  });
  return best;
}

std::optional<Surfaces::Hit> TerrainSurface::nearest(const Ray& ray) const {
  const std::optional<TerrainHit> met = closest(ray);
  return met ? std::optional(Hit{.t = met->t, .normal = met->normal}) : std::nullopt;
}

bool TerrainSurface::occluded(const Ray& ray, const TerrainFilter& counts) const {
  const Walk walk(ray, heights_.grid);
  bool is_met = false;
  for_patches(walk, ray.t_max,
              [&](int column, int row) { return is_met = meet(walk, column, row, counts).has_value(); });
  return is_met;
}

std::optional<TerrainHit> TerrainSurface::closest_by_brute_force(const Ray& ray,
                                                                 const TerrainFilter& counts) const {
  const Walk walk(ray, heights_.grid);
  std::optional<TerrainHit> best;
  for (int row = 0; row + 1 < heights_.grid.rows; ++row) {
    for (int column = 0; column + 1 < heights_.grid.columns; ++column) {
      const Range range = patch_range(column, row);
      if (range.low > range.high) continue;
      const std::optional<TerrainHit> hit = meet(walk, column, row, counts);
      if (hit && is_before(*hit, best)) best = hit;
    }
  }
  return best;
}

bool TerrainSurface::any(const std::function<bool(const Bounds&)>& box) const {
  return !levels_.empty() && any_within({static_cast<int>(levels_.size()), 0, 0}, box);
}

bool TerrainSurface::any_within(const Square& square, const std::function<bool(const Bounds&)>& box) const {
  const Range range = range_of(square);
  if (range.low > range.high || !box(box_of(square, range))) return false;
  if (square.level == 0) return true;
  const int level = square.level - 1;
  const glm::ivec2 size = size_of(level);
  for (int child = 0; child < 4; ++child) {
    const Square part{level, 2 * square.column + (child & 1), 2 * square.row + (child >> 1)};
    if (part.column < size.x && part.row < size.y && any_within(part, box)) return true;
  }
  return false;
}

}  // namespace alidade::geo
