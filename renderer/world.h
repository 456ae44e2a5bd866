// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "octree/octree.h"
#include "octree/query.h"
#include "renderer/disc_tracer.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"
#include "surface/local_plane.h"

namespace alidade::renderer {

/// Normals for `"normals": "smooth"`: of a plane through all points within a reach, nearer ones weighing
/// more. Each is computed when it is first used and kept (4 bytes per point), so an image pays for
/// what it shows. The answer is a function of the cloud alone: safe and equal from any number of threads.
class SmoothNormals {
 public:
  /// The octree must outlive this.
  explicit SmoothNormals(const Octree& octree);

  /// For the point with this id, which lies at `position`. reach: always the same for the same point.
  LocalPlane at(std::uint64_t point_id, const glm::dvec3& position, double reach) const;

 private:
  const Octree* octree_;
  mutable std::vector<std::atomic<std::uint32_t>> kept_;  ///< packed; 0 = not computed yet
};

// What rays meet: the spheres around the cloud's points, and the scene's objects. Everything here is in
// double, since a micrometre at UTM coordinates is the tenth digit.

/// The cloud as rays see it: a sphere around each point.
struct CloudGeometry {
  const Octree* octree = nullptr;
  ColorColumn colors;
  bool shows_normals = false;  ///< the colour of a surface is the way it faces, not that of its point
  RayQuery query;              ///< its entry_min is above the rounding of coordinates
  const SurfaceCloud* surfaces = nullptr;
  std::optional<SurfaceQuery> own_radii{};  ///< in place of `query`, of points with radii of their own
  Material material;
};

/// The object or point that a ray has just left, so that the ray does not meet it again.
struct RayOrigin {
  enum class From { air, object, point } from = From::air;
  std::uint64_t index = 0;  ///< of the object, or point id
  glm::dvec3 center{0.0};   ///< of the point
  bool inward = false;      ///< the ray continues inside
  double radius = 0.0;      ///< of the point's sphere; needed by rays that continue inside
  SheetOrigin sheet{};      ///< of clouds of discs

  bool is_object(std::size_t number) const { return from == From::object && index == number; }
};

/// Where a ray meets something first.
struct Intersection {
  double t = std::numeric_limits<double>::infinity();
  bool on_cloud = false;
  std::uint64_t index = 0;  ///< of the object, or point id
  glm::dvec3 center{0.0};   ///< of the point
  double radius = 0.0;      ///< of its sphere
  bool on_disc = false;     ///< in clouds of discs: the next ones count in place of centre and radius
  SheetOrigin sheet{};
  Color16 color{0};  ///< on the cloud: display value

  /// For rays that leave from here. inward: they continue inside.
  RayOrigin leaving(bool inward) const {
    RayOrigin origin{.from = on_cloud ? RayOrigin::From::point : RayOrigin::From::object,
                     .index = index,
                     .center = center,
                     .inward = inward,
                     .radius = radius};
    origin.sheet = sheet;
    return origin;
  }
};

/// What shading needs of a hit.
struct Surface {
  glm::dvec3 position{0.0};
  glm::dvec3 ray_origin{0.0};  ///< where rays leave: `position`, but above the bumps of a smooth surface
  glm::dvec3 normal{0.0, 0.0, 1.0};  ///< outward, unit; may show away from the ray when it comes from inside
  Rgb color{1.0f};                   ///< linear colour of the point; white on objects
  const Material* material = nullptr;
};

/// All geometry of a scene. Keeps references to scene and cloud, which must outlive it. Safe to use from many
/// threads.
class World {
 public:
  /// `cloud` may be null. Errors: a model without surfaces.
  World(const Scene& scene, const LoadedCloud* cloud);

  /// The nearest surface in front of the ray's origin. Between a sphere of the cloud and an object the
  /// smaller t wins. A ray that leaves a surface never meets that surface from the side it left to: the
  /// ray_origin has it; inside glass the far wall of the same sphere counts, and inside a glass point no
  /// other point is seen. Ray: points before t_min are not met; t_max is ignored.
  std::optional<Intersection> nearest(const Ray& ray, const RayOrigin& ray_origin) const;

  /// Whether anything is between the ray's origin and infinity.
  bool blocked(const Ray& ray, const RayOrigin& ray_origin) const;

  /// nearest() and blocked() for many rays, which go through the cloud together: much faster. All of one
  /// length. `reach`: only what is within so many metres of the origin blocks, of points those whose middle
  /// is passed there.
  void nearest(std::span<const Ray> rays, std::span<const RayOrigin> ray_origins,
               std::span<std::optional<Intersection>> met) const;
  void blocked(std::span<const Ray> rays, std::span<const RayOrigin> ray_origins,
               std::span<std::uint8_t> answers, double reach = std::numeric_limits<double>::infinity()) const;

  /// How far the hits of nearest() by these rays, which begin in the air, are to be trusted: those of objects
  /// fully, those on spheres to a radius.
  void trust(std::span<const Ray> rays, std::span<const std::optional<Intersection>> met,
             std::span<HitTrust> answers) const;

  Surface surface_at(const Ray& ray, const Intersection& intersection) const;

  const std::vector<Object>& objects() const { return *objects_; }

 private:
  void smooth(const Ray& ray, const Intersection& intersection, Surface& surface) const;
  Intersection nearest_object(const Ray& ray, const RayOrigin& ray_origin) const;
  /// Whether there is one before t = reach.
  bool any_object(const Ray& ray, const RayOrigin& ray_origin, double reach) const;
  /// The ray as the cloud is queried with it, for what it meets before t.
  Ray interval(const Ray& ray, double t) const;
  /// Put what these rays meet of the cloud into `met`, at these numbers, where it is nearer than the hit
  /// there.
  void meet_spheres(std::span<const Ray> rays, std::span<const std::size_t> numbers,
                    std::span<std::optional<Intersection>> met) const;
  void meet_discs(std::span<const Ray> rays, std::span<const SheetOrigin> sheets,
                  std::span<const std::size_t> numbers, std::span<std::optional<Intersection>> met) const;
  Rgb linear(const Color16& color) const { return {linear_[color.r], linear_[color.g], linear_[color.b]}; }

  const std::vector<Object>* objects_;
  std::optional<CloudGeometry> cloud_;
  std::optional<SmoothNormals> smooth_normals_;
  std::optional<DiscCloud> discs_;
  std::vector<float> linear_;  ///< linear value of each 16-bit display value
};

/// Smallest entry at which a ray that starts on a sphere of this radius may meet another: below it lies only
/// rounding of coordinates as large as those of the bounds. About 20 nanometres at UTM northings.
double smallest_entry(const Bounds& bounds, double radius);

}  // namespace alidade::renderer
