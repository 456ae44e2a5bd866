// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/sampling.h"
#include "renderer/scene.h"

namespace alidade {

/// The sun prepared for tracing. Its radiance is even over the disc, so a surface that faces it gets pi
/// sin^2(half the angle) times that: exactly the irradiance the scene asks for.
class SunDisc {
 public:
  explicit SunDisc(const Sun& sun) : irradiance_(sun.irradiance) {
    const SineCosine azimuth = sine_cosine_of_degrees(sun.azimuth),
                     elevation = sine_cosine_of_degrees(sun.elevation);
    basis_ = basis_around(glm::normalize(
        glm::dvec3(azimuth.sine * elevation.cosine, azimuth.cosine * elevation.cosine, elevation.sine)));
    const double half_sine = sine_cosine_of_degrees(0.25 * sun.angular_diameter).sine;
    const double cap_height = 2.0 * half_sine * half_sine;
    cap_height_ = cap_height < k_smallest_cap ? 0.0 : cap_height;
  }

  /// Towards the middle of the disc.
  const glm::dvec3& center() const { return basis_.normal; }

  /// Parallel light comes from a point that no ray can hit. So does that of a disc below 0.00002 degrees,
  /// whose edge would drown in the rounding of directions.
  bool is_parallel() const { return cap_height_ == 0.0; }

  /// What a ray sees that ends in the disc; zero for any other and for parallel light.
  Rgb radiance(const glm::dvec3& direction) const {
    const bool inside = !is_parallel() && glm::dot(direction, basis_.normal) >= 1.0 - cap_height_;
    return inside ? irradiance_ / static_cast<float>(projected_solid_angle()) : Rgb(0.0f);
  }

  /// A direction towards the disc, evenly.
  glm::dvec3 sample(const glm::dvec2& u) const {
    return is_parallel() ? center() : basis_.to_world(sample_cone(u, cap_height_));
  }

  /// Of the disc; one over it is the density of `sample`. 0 for parallel light.
  double solid_angle() const { return 2.0 * k_pi * cap_height_; }

  /// Radiance over density of a sampled direction: what the scattering function times cosine is multiplied
  /// with.
  Rgb sample_weight() const {
    // Solid angle over projected solid angle, 2 pi h / (pi h (2 - h)): 1 for a small disc.
    return irradiance_ * static_cast<float>(2.0 / (2.0 - cap_height_));
  }

 private:
  static constexpr double k_smallest_cap = 1e-14;

  double projected_solid_angle() const { return k_pi * cap_height_ * (2.0 - cap_height_); }

  Basis basis_;
  Rgb irradiance_;
  double cap_height_ = 0.0;  ///< 1 - cosine of half the angular diameter
};

}  // namespace alidade
