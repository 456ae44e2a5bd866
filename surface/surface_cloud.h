// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "base/progress.h"
#include "octree/octree.h"
#include "octree/query.h"
#include "surface/point_surface.h"

// What rays meet of a cloud whose points have radii of their own: spheres, which close a surface where points
// are sparse and stay small where they are dense, or discs on the sheets that the points were measured on.
//
//   const SurfaceCloud cloud = SurfaceCloud::of_discs(with_spacings(build(points), k_surface_neighbours));
//   const SurfaceQuery query{.radius = 0.5, .spacing_factor = k_disc_spacings, .discs = DiscQuery{}};
//   if (std::optional<SurfaceHit> hit = closest(cloud, ray, query)) use(ray.position(hit->t));

namespace alidade {

class LeafFitter;

/// The arrays of a SurfaceCloud, as traversals read them.
struct SurfaceView {
  TreeView tree;
  PointLayers layers;
  /// Surfaces and edges (surface/point_surface.h) by storage index, readable for k_coordinate_padding values
  /// past the end. Null for spheres.
  const std::uint32_t* stored_surfaces = nullptr;
  const std::uint8_t* stored_edges = nullptr;
  /// How far discs and lone spheres reach from their points along each axis, at most below each slot of each
  /// node (surface/disc_reach.h): slot s of node n at 16 (3 n + axis) + s. The upper halves of floats. Null
  /// where surfaces are fitted by queries: up to the points' radii.
  const std::uint16_t* slot_reaches = nullptr;
  const LeafFitter* fitter = nullptr;  ///< fits surfaces and edges leaf by leaf; null: all are there
};

/// An octree with what makes surfaces of its points. Immutable, cheap to copy (copies share the arrays), safe
/// to query from many threads.
class SurfaceCloud {
 public:
  SurfaceCloud() = default;

  /// Points as spheres. Errors: an octree without spacings that has points; so below.
  static SurfaceCloud of_spheres(const Octree& octree);

  /// Points as discs. Surfaces that the octree lacks are fitted by the queries, those of each leaf once, when
  /// they examine its points; answers are the same, and so are the surfaces of points that were an answer.
  /// Cost: as fast as memory, or the disk of a mapped file, delivers; 5 B per point, of a mapped file 13 B:
  /// coordinates and spacings go to huge pages if there is room; 96 B per node. Without surfaces 5 B per point,
  /// and the time of with_surfaces() per point of the leaves that queries examine.
  static SurfaceCloud of_discs(const Octree& octree);

  std::size_t size() const { return octree_.size(); }
  /// The octree that was given, with the coordinates and spacings that were copied from its map.
  const Octree& octree() const { return octree_; }
  const SurfaceView& view() const { return view_; }
  bool has_discs() const { return view_.stored_surfaces != nullptr; }
  /// The surface of the point at a storage index. Requires discs, and that a query has answered with the
  /// point or examined its leaf, or fit_all().
  PointSurface surface_at(std::uint32_t index) const {
    return unpack_surface(view_.stored_surfaces[index], view_.layers.surface_unit);
  }
  /// Fits the surfaces that are left. `progress` is in points.
  void fit_all(const Progress& progress = {}) const;

 private:
  SurfaceCloud(const Octree& octree, const SurfaceView& view) : octree_(octree), view_(view) {}

  Octree octree_;  ///< keeps alive what the view points to
  SurfaceView view_;
};

/// The sheet of points that a ray begins on, whose discs it does not meet: those that are near
/// (is_part_of_surface()) and whose normal deviates by at most 32 degrees. A reach of 0: the ray begins in the
/// air.
struct SheetOrigin {
  glm::dvec3 normal{0.0, 0.0, 1.0};      ///< of length 1; not checked
  float reach = 0.0f, thickness = 0.0f;  ///< metres
};

/// Radius of a disc in spacings to the 8th neighbour: leaves 0.1 % of a surface of random points uncovered,
/// exp(-8 * 0.92^2), and reaches little beyond its edges.
constexpr double k_disc_spacings = 0.92;

/// How points are discs: a point of a sheet is where the ray crosses the disc around it
/// (surface/point_disc.h), a point without one where the ray enters a small sphere, whose radius is
/// lone_factor times the spacing, at most lone_radius and that of a disc. Hit::t is that of the crossing; the
/// ray's interval applies to it, and it orders the points, whatever the measure.
struct DiscQuery {
  double lone_factor = 0.25;
  double lone_radius = std::numeric_limits<double>::infinity();  ///< metres
  double edge_shift = 0.0;  ///< discs reach so many spacings farther than the edges of their sheets
  /// One for each ray of the batch, or none at all. It must outlive the query.
  std::span<const SheetOrigin> begins{};
};

/// Conditions of a ray query on a SurfaceCloud: those of RayQuery, but for what is said here.
struct SurfaceQuery {
  /// The radius of a point is spacing_factor times its spacing, but not more than this. Metres.
  double radius = k_unlimited_radius;
  double spacing_factor = 1.0;
  Measure measure = Measure::entry;  ///< t or entry
  double entry_min = -std::numeric_limits<double>::infinity();
  CandidateFilter filter{};
  std::optional<DiscQuery> discs{};  ///< empty: points are spheres
};

/// A point that answers a ray.
struct SurfaceHit : Hit {
  std::uint32_t index = 0;  ///< storage index of the point

  bool operator==(const SurfaceHit&) const = default;
};

/// The radius that a query gives a point with this spacing, metres.
inline double own_radius(const SurfaceQuery& query, double spacing) {
  return std::min(query.radius, query.spacing_factor * spacing);
}

/// Errors: of radius, measure and entry_min those of RayQuery; Measure::distance; spacing_factor not above 0
/// or not finite; with discs: an infinite radius, lone_factor or lone_radius negative or NaN, edge_shift not
/// finite, or `begins` that are neither as many as the rays nor none.
void check(const SurfaceQuery& query, std::size_t rays);

// As the functions of these names in octree/query.h. Answers equal those of surface/brute_force_surface.h bit
// for bit. Errors beside those of check() and those of rays: discs in a cloud that has none.

std::optional<SurfaceHit> closest(const SurfaceCloud& cloud, const Ray& ray, const SurfaceQuery& query);
void closest(const SurfaceCloud& cloud, std::span<const Ray> rays, const SurfaceQuery& query,
             std::span<std::optional<SurfaceHit>> hits);
bool occluded(const SurfaceCloud& cloud, const Ray& ray, const SurfaceQuery& query);
void occluded(const SurfaceCloud& cloud, std::span<const Ray> rays, const SurfaceQuery& query,
              std::span<std::uint8_t> answers);

/// A point with a radius of its own.
struct PointSphere {
  glm::dvec3 center{0.0};   ///< the point, world coordinates
  double radius = 0.0;      ///< metres
  std::uint32_t index = 0;  ///< storage index of the point
};

/// Appends the spheres that come within `reach` metres of a position, their surfaces included: distance <=
/// radius + reach, for the radii that the query gives the points, of discs, too. With a reach of 0 these are
/// the spheres that hold the position. In the order of the storage indices. Requires a checked query with a
/// finite radius, a finite position and a finite reach of at least 0. Cost: some hundred nanoseconds, and as
/// much for every ten spheres.
void find_spheres(const SurfaceCloud& cloud, const glm::dvec3& position, double reach,
                  const SurfaceQuery& query, std::vector<PointSphere>& spheres);

}  // namespace alidade
