// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "base/bounds.h"
#include "base/surfaces.h"
#include "geo/raster.h"

namespace alidade::geo {

/// Where a ray meets a terrain.
struct TerrainHit {
  double t = 0.0;                    ///< along the ray, metres
  int column = 0, row = 0;           ///< of the cell whose centre is the patch's north-western corner
  glm::dvec3 normal{0.0, 0.0, 1.0};  ///< unit, towards the side the ray came from

  bool operator==(const TerrainHit&) const = default;
};

/// Whether a hit counts. Must be a pure function of the hit, which many threads call at once.
using TerrainFilter = std::function<bool(const TerrainHit&)>;

/// The surface of an elevation raster: the centres of cells have the heights, and the patch between four of
/// them is bilinear. A patch exists if all four heights are finite; so a raster of one row or column has
/// none. Rays meet it from above and below alike. Safe to use from many threads.
///
/// The answer is that of a loop over all patches, bit for bit: least t first, then the northernmost row, then
/// the westernmost column. Patches share their edges, with one height for both, so that rays do not slip
/// through between two of them. t is right to 1e-8 m where the ray does not graze the surface.
class TerrainSurface final : public Surfaces {
 public:
  /// Heights in the unit of the grid; those that are not finite are holes. Memory: 7 B per cell, the heights
  /// included. Cost: 10 ns per cell. Requires: as many values as cells.
  explicit TerrainSurface(Raster<float> heights);

  /// The first one with t_min <= t <= t_max that counts; a ray can meet a patch twice. Cost: a ray passes
  /// over or through what is far from it in a few steps, and takes some 50 ns per patch near it.
  std::optional<TerrainHit> closest(const Ray& ray, const TerrainFilter& counts = {}) const;
  /// Whether there is one: faster.
  bool occluded(const Ray& ray, const TerrainFilter& counts) const;

  std::optional<Hit> nearest(const Ray& ray) const override;
  bool occluded(const Ray& ray) const override { return occluded(ray, {}); }
  const Bounds& bounds() const override { return bounds_; }  ///< of all patches

  /// The answer to closest() from a loop over all patches, for tests.
  std::optional<TerrainHit> closest_by_brute_force(const Ray& ray, const TerrainFilter& counts = {}) const;

  /// The highest slope, height over horizontal distance, at which the surface is seen from `eye` along a
  /// horizontal direction of length 1: a line of sight that rises less meets the surface or goes below it,
  /// one that rises more is free. `least` (at least 0) if nothing is seen above that. At an eye on the
  /// surface the slope of the surface itself counts. Exact but for rounding: the greatest value of the
  /// quadratics of all patches along the direction. Cost: some 1 to 3 microseconds; what cannot rise above
  /// the highest slope so far is passed over in a few steps.
  double horizon_slope(const glm::dvec3& eye, const glm::dvec2& direction, double least = 0.0) const;

  /// Whether `box` accepts the box (world) of any patch. It must accept every box that holds one that it
  /// accepts.
  bool any(const std::function<bool(const Bounds&)>& box) const;

  const Raster<float>& heights() const { return heights_; }  ///< holes are NaN
  std::uint64_t patch_count() const { return patch_count_; }

 private:
  /// Heights of a square of patches; low > high: none of them exists.
  struct Range {
    float low, high;
  };
  /// Level n has a range for every 2^n x 2^n patches.
  struct Level {
    int columns = 0, rows = 0;
    std::vector<Range> ranges;
  };
  struct Square;
  class Walk;

  /// Squares of a level in a row and in a column; of level 0 patches.
  glm::ivec2 size_of(int level) const;
  Range patch_range(int column, int row) const;
  Range range_of(const Square& square) const;
  Bounds box_of(const Square& square, const Range& range) const;
  template <class Keep, class Still, class Visit>
  void descend(const Walk& walk, const Keep& keep, const Still& still, const Visit& visit) const;
  template <class Visit>
  void for_patches(const Walk& walk, const double& limit, const Visit& visit) const;
  bool any_within(const Square& square, const std::function<bool(const Bounds&)>& box) const;
  std::optional<TerrainHit> meet(const Walk& walk, int column, int row, const TerrainFilter& counts) const;

  Raster<float> heights_;
  double slack_ = 0.0;         ///< by which boxes of patches are higher and lower, metres
  std::vector<Level> levels_;  ///< from level 1 on: a patch's range is that of its corners
  Bounds bounds_;
  std::uint64_t patch_count_ = 0;
};

}  // namespace alidade::geo
