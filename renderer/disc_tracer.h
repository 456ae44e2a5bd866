// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "octree/enclosing_spheres.h"
#include "octree/point_disc.h"
#include "octree/query.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"

// What rays meet where points are discs of their sheets: Measure::crossing (octree/query.h) says where, and the first
// crossing is the least t; of equal ones the lowest point id.
//
// Blended: the discs that count beside the first one are those of points within whose radius the first crossing lies, if
// they belong to its sheet: their normal deviates by at most 32 degrees, and their plane passes within a quarter of the
// radius plus 4 mm of the crossing. Of them t (where the ray crosses their plane), normal and colour are averaged, weighted
// by exp(-8 d^2 / r^2) with the distance d of the point from the first crossing and its radius r. Planes that the ray crosses
// more than r from the first crossing do not count, nor does a mean t outside the limits or a normal that faces away. Rays
// that leave a sheet meet discs that are not blended: what they find is spread over many of them.

namespace alidade::renderer {

/// What a ray that leaves a sheet does not meet: the discs of that sheet, which are near (is_part_of_surface()) and whose
/// normal deviates by at most 32 degrees. A reach of 0: the ray begins in the air.
struct SheetOrigin {
  glm::dvec3 normal{0.0, 0.0, 1.0};
  float reach = 0.0f, thickness = 0.0f;  ///< metres
};

/// Cosine of the 32 degrees by which normals of one sheet deviate at most.
constexpr double k_same_sheet_cosine = 0.848;

/// Where a ray meets the cloud. Small, since there are thousands at a time.
struct DiscHit {
  double t = 0.0;              ///< metres
  std::uint64_t point_id = 0;  ///< of the first crossing
  SheetOrigin sheet{};  ///< for rays that go on from there; its normal shows to the side the ray came from
  Color16 color{0};     ///< display value
};

/// The cloud of a scene as discs. Keeps references to the cloud, which must outlive it and have surfaces. Safe to use from
/// many threads.
class DiscCloud {
 public:
  DiscCloud(const LoadedCloud& cloud, bool blends);

  /// The first hit of each ray in its interval. All of one length.
  void closest(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
               std::span<std::optional<DiscHit>> hits) const;
  /// Whether there is one.
  void blocked(std::span<const Ray> rays, std::span<const SheetOrigin> origins,
               std::span<std::uint8_t> answers) const;

 private:
  /// For these rays, which must outlive it.
  RayQuery query_of(std::span<const Ray> rays, std::span<const SheetOrigin> origins) const;
  DiscHit disc_hit(const Ray& ray, const Hit& first, bool blends, std::vector<PointSphere>& around) const;
  /// hit: that of the disc alone. around: the spheres that hold its position.
  void blend(const Ray& ray, const std::vector<PointSphere>& around, DiscHit& hit) const;
  Color16 color_of(std::uint64_t point_id) const { return colors_.empty() ? Color16(0) : colors_[point_id]; }

  const Octree octree_;
  const RayQuery query_;
  const std::span<const Color16> colors_;
  const bool blends_;
};

}  // namespace alidade::renderer
