// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <variant>

#include "camera/lens.h"

namespace alidade::camera {

/// A distortion prepared for both directions. It is valid from the middle of the film up to the radius where
/// its radial part stops growing: there it folds over, and positions beyond would occur twice.
/// undistort(distort(ideal)) is `ideal` to a few units in the last place.
class DistortionMap {
 public:
  /// Requires: no position beyond `largest_radius` on the ideal film.
  DistortionMap(const Distortion& distortion, double largest_radius);

  /// Position on the real film; empty beyond the fold.
  std::optional<glm::dvec2> distort(const glm::dvec2& ideal) const;
  /// Position on the ideal film; empty if none before the fold maps to this one. Method: the radial part by
  /// Newton's method inside a bracket, then Newton's method in the plane.
  std::optional<glm::dvec2> undistort(const glm::dvec2& film) const;

 private:
  struct Radial {
    double factor, slope;  ///< factor of (x, y) at q = r^2, and its derivative by q
  };
  struct Moved {
    glm::dvec2 position, by_x, by_y;  ///< the position and its derivatives
  };
  Radial radial_at(double q) const;
  Moved moved(const glm::dvec2& ideal) const;
  std::optional<double> radius_before(double film_radius) const;

  Distortion distortion_;
  std::size_t radial_count_, denominator_count_;  ///< coefficients up to the last one that is not 0
  bool radial_only_;
  double ideal_limit_, film_limit_;  ///< radius where the radial part stops growing, or the largest one
};

/// The ray to a position on the film, in the camera's axes (right, down, forward). The direction has any
/// length.
struct LensRay {
  glm::dvec3 origin{0.0};
  glm::dvec3 direction{0.0, 0.0, 1.0};
};

/// A lens prepared for both directions: from points in the camera's axes to film positions (lens.h) and back.
/// Results have equal bits on every machine. Cost of unproject(): tens of operations, hundreds with
/// distortion.
class LensMap {
 public:
  explicit LensMap(const Lens& lens);

  /// Film position of a point in the camera's axes. Empty if the lens does not see it: behind the camera or,
  /// with distortion, beyond the radius where the lens folds over.
  std::optional<glm::dvec2> project(const glm::dvec3& point) const;
  /// The ray that project() maps to this film position; empty where no ray does.
  std::optional<LensRay> unproject(const glm::dvec2& film) const;

 private:
  // Lenses without distortion are kept as they are, the others with their prepared distortion.
  struct Brown {
    DistortionMap distortion;
  };
  struct Fisheye {
    DistortionMap distortion;
  };
  struct Dual {
    double transition;
    DistortionMap distortion;
  };
  struct Prepare;
  struct Project;
  struct Unproject;

  std::variant<PinholeLens, Brown, Fisheye, FieldOfViewLens, DivisionLens, UnifiedLens, Dual,
               OrthographicLens, EquirectangularLens>
      lens_;
};

}  // namespace alidade::camera
