// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "base/ray.h"
#include "camera/camera.h"
#include "camera/lens_map.h"

namespace alidade::camera {

/// A camera prepared for use: maps film positions, in pixels, to rays and back. Inside the image project()
/// and ray() are inverse to each other within 1e-9 pixel.
class Projection {
 public:
  /// Cost: a microsecond. Nothing is checked; see check_camera().
  explicit Projection(const Camera& camera) : camera_(camera), lens_(camera.lens) {}

  /// Ray through a film position; (0.5, 0.5) = centre of the top left pixel. Starts at the camera
  /// (orthographic: in its plane), t_min = 0, unit direction. Empty where the lens has no view: outside a
  /// fisheye's circle, beyond the fold of a distortion.
  std::optional<Ray> ray(const glm::dvec2& film_position) const;

  /// Film position of a world point; it may lie outside the image. Empty if the lens does not see the point.
  std::optional<glm::dvec2> project(const glm::dvec3& world) const;

  const Camera& camera() const { return camera_; }

 private:
  Camera camera_;
  LensMap lens_;
};

/// Errors: an invalid size; focal lengths not above 0; numbers that are not finite; parameters outside the
/// lens's range; a distortion that folds over inside the image, with the radius in pixels up to which it can
/// be inverted. Pixels outside the view of a lens (a fisheye's circle) are no error.
void check_camera(const Camera& camera);

/// As check_camera(), but does not search the image for folds.
void check_camera_numbers(const Camera& camera);

}  // namespace alidade::camera
