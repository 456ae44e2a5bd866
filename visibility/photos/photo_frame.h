// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "camera/projection.h"
#include "octree/point_surface.h"

// What of the world is in the frame of a photo, and how finely it is shown.

namespace alidade::visibility {

/// A surface counts as seen at least at this sine of the angle to it, 1.1 degrees: the normals of points that are
/// seen edge-on are not better known.
constexpr double k_least_view_sine = 0.02;

/// The camera of a photo, ready to be asked. Safe to use from many threads.
class PhotoFrame {
 public:
  /// Nothing is checked; see camera::check_camera(). Cost: that of some hundred rays.
  explicit PhotoFrame(const camera::Camera& camera);

  const camera::Camera& camera() const { return projection_.camera(); }

  /// Where the photo shows a world point, in pixels: (0.5, 0.5) is the centre of the top left one. Empty if the lens
  /// does not see it, as behind the camera, or if it is outside the picture, whose edges are inclusive.
  std::optional<glm::dvec2> film_position(const glm::dvec3& world) const;

  /// Side of a square with the area that one pixel covers on the surface of a point, in the unit of the world: for a
  /// vertical photo of level ground its height above that, divided by the focal length in pixels. Without a surface,
  /// that of one which faces the camera. The derivatives of the projection are central differences over a thousandth of
  /// the distance. Infinite where these reach out of what the lens sees. Requires a film_position().
  double ground_sampling_distance(const glm::dvec3& world, const PointSurface& surface) const;

 private:
  camera::Projection projection_;
  /// No direction in the frame is farther off the axis than by this cosine; below -1: any may be in it.
  double least_cosine_ = -2.0;
};

}  // namespace alidade::visibility
