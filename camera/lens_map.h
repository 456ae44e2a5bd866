// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <variant>

#include "camera/distortion_map.h"
#include "camera/lens.h"

namespace alidade {

/// What a place on the film sees, in the camera's axes (right, down, forward). The direction has any length.
struct LensRay {
  glm::dvec3 origin{0.0};
  glm::dvec3 direction{0.0, 0.0, 1.0};
};

/// A lens ready for use both ways: places in the camera's axes to film places (lens.h) and back. What it
/// computes has the same bits on every machine. Cost: of unproject() some tens of operations, with distortion
/// some hundreds.
class LensMap {
 public:
  explicit LensMap(const Lens& lens);

  /// Film place of a place in the camera's axes. Empty if the lens does not see it: behind the camera or,
  /// with distortion, beyond the place where the lens folds over.
  std::optional<glm::dvec2> project(const glm::dvec3& place) const;
  /// The ray that project() brings to this film place; empty if there is none.
  std::optional<LensRay> unproject(const glm::dvec2& film) const;

 private:
  // A lens without distortion needs no preparation; those with carry it ready for use.
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

}  // namespace alidade
