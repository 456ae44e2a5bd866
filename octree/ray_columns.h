// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>

#include "base/progress.h"
#include "base/ray.h"
#include "octree/query.h"

// Batches of rays as columns of numbers, such as arrays of Python, and their answers as columns. Each task
// makes its rays and writes its answers itself, so that neither takes memory a second time.

namespace alidade {

/// A ray for each row. Each row of a column begins `stride` numbers behind the row before; with a stride of
/// 0, all rows are the same. Directions may have any length. The numbers must not change while a query runs:
/// it may end with an Error, or answer for rays that never were.
struct RayColumns {
  struct Column {
    const double* values = nullptr;
    std::size_t stride = 0;
    const double* operator[](std::size_t row) const { return values + stride * row; }
  };

  std::size_t count = 0;
  Column origins, directions;  ///< three numbers a row
  Column t_min, t_max;         ///< one number a row

  glm::dvec3 origin(std::size_t row) const { return {origins[row][0], origins[row][1], origins[row][2]}; }
  /// Errors: those of make_ray, with the number of the row.
  Ray ray(std::size_t row) const;
};

/// Members of Hit, a row for each ray.
struct HitColumns {
  std::int64_t* point_ids = nullptr;  ///< -1 without a hit
  double* t = nullptr;                ///< this and those below: NaN without a hit
  double* distance = nullptr;
  double* entry = nullptr;

  void set(std::size_t row, const Hit& hit) const {
    point_ids[row] = static_cast<std::int64_t>(hit.point_id);
    t[row] = hit.t;
    distance[row] = hit.distance;
    entry[row] = hit.entry;
  }
  void set_none(std::size_t row) const {
    point_ids[row] = -1;
    t[row] = distance[row] = entry[row] = std::numeric_limits<double>::quiet_NaN();
  }
};

/// `closest` of the rays that make_ray makes of the rows, bit for bit. `progress` is in rays. Errors beside
/// those of batches: those of make_ray, of the first row that has any.
void closest(const Octree& octree, const RayColumns& rays, const RayQuery& query, const HitColumns& hits,
             const Progress& progress = {});
void occluded(const Octree& octree, const RayColumns& rays, const RayQuery& query,
              std::span<std::uint8_t> answers, const Progress& progress = {});

}  // namespace alidade
