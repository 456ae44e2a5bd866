// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>

#include "camera/camera_set.h"
#include "camera/projection.h"
#include "surface/point_surface.h"

// Which world points are in the frame of a photo, and at which resolution; what is wrong with cameras that
// show no point of a cloud.

namespace alidade::visibility {

/// Smaller sines of the angle between a view and a surface count as this one, 1.1 degrees: normals of points
/// that are seen edge-on are not more precise.
constexpr double k_least_view_sine = 0.02;

/// The camera of a photo, prepared for tests of many points. Safe to use from many threads.
class PhotoFrame {
 public:
  /// Requires a camera that passes camera::check_camera(). Cost: that of some hundred rays.
  explicit PhotoFrame(const camera::Camera& camera);

  const camera::Camera& camera() const { return projection_.camera(); }

  /// Where the photo shows a world point, in pixels: (0.5, 0.5) is the centre of the top left
  /// one. Empty if the lens does not see it, as behind the camera, or if it is outside the photo,
  /// whose edges are inclusive.
  std::optional<glm::dvec2> film_position(const glm::dvec3& world) const;

  /// Side of a square with the area that one pixel covers on the surface of a point, in the unit of the
  /// world: for a vertical photo of level ground its height above that, divided by the focal length in
  /// pixels. A point without a surface counts as facing the camera. The derivatives of the projection are
  /// central differences over a thousandth of the distance. Infinite if these leave the view of the lens.
  /// Requires a point with a film_position().
  double ground_sampling_distance(const glm::dvec3& world, const PointSurface& surface) const;

 private:
  camera::Projection projection_;
  /// Cosine of an angle to the axis that no direction in the frame exceeds; below -1: unknown.
  double least_cosine_ = -2.0;
};

/// Checks that cameras show a cloud. Errors: no photo; an orthographic camera, which has no position; no photo with
/// any point of the cloud in its frame and reach, with a guess at the reason: exchanged coordinates, degrees,
/// another reference system, or other axes of the cameras. Cost: photos are tested until one has a point.
void check_photos(const Octree& octree, std::span<const camera::NamedCamera> photos,
                  double max_distance = std::numeric_limits<double>::infinity());

}  // namespace alidade::visibility
