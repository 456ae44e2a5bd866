// SPDX-License-Identifier: MIT
#pragma once

#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "image/read_image.h"
#include "renderer/scene.h"

// A sky from an image of everything around (lat-long, equirectangular): column x of it is azimuth
// rotation + 360 (x / width - 1/2) degrees, clockwise from north (+y), row y is elevation 180 (1/2 - y /
// height). Without rotation that is the panorama camera's layout, so a panorama rendered here is a sky.

namespace alidade::renderer {

/// A direction towards the sky.
struct SkySample {
  glm::dvec3 direction{0.0};
  Rgb radiance{0.0f};
  double pdf = 0.0;  ///< per solid angle
};

/// The sky prepared for tracing. Between the middles of four pixels radiance is interpolated, linearly in
/// azimuth and in the sine of the elevation; around the poles it is that of the outermost rows. Directions
/// are sampled exactly in proportion to the luminance of this radiance, so that a grey sky brings no noise of
/// its own. Source of the sampling: Pharr, Jakob, Humphreys, Physically Based Rendering, appendix A (bilinear
/// functions). Immutable, safe to use from many threads.
class SkyImage {
 public:
  /// Values times `scale`; `rotation` in degrees clockwise. Pixels must be finite, not negative, and as many
  /// as width times height, at least one. Memory: takes the pixels over and adds 8 bytes for each.
  SkyImage(image::SkyPixels pixels, double scale, double rotation);

  /// Its pixels, scaled: what distinguishes it from other skies.
  const image::SkyPixels& pixels() const { return pixels_; }

  /// Radiance that comes along a unit direction towards the sky.
  Rgb radiance(const glm::dvec3& direction) const { return interpolated(position_of(direction)); }

  /// Whether all of it is black, so that there is nothing to sample.
  bool is_black() const { return !(total_ > 0.0); }

  /// A direction towards the sky, by two uniform random numbers in [0, 1). Requires that it is not black.
  SkySample sample(const glm::dvec2& u) const;

  /// Density per solid angle with which `sample` chooses this unit direction; 0 for a black sky.
  double pdf(const glm::dvec3& direction) const { return pdf_of(radiance(direction)); }

 private:
  /// A cell, which four middles of pixels bound, and a point in it, [0, 1] from left to right and from top
  /// to bottom. Its left column is that of its number, its rows are the one above and that of its number; the
  /// first and last row of cells reach from the outermost middles to the poles.
  struct Position {
    int column = 0, row = 0;
    double x = 0.0, y = 0.0;
  };

  Position position_of(const glm::dvec3& direction) const;
  Rgb interpolated(const Position& position) const;
  double pdf_of(const Rgb& radiance) const;
  const Rgb& value(int column, int row) const;

  image::SkyPixels pixels_;
  double turns_ = 0.0;  ///< rotation, in turns
  /// Of the elevation, from the top of the first row of cells to the last one's end.
  std::vector<double> sines_;
  std::vector<double> columns_;  ///< sums of mean luminance along each row of cells
  std::vector<double> rows_;     ///< sums of luminance times solid angle over rows of cells
  double total_ = 0.0;           ///< the last of them
};

/// Radiance that comes from the sky along a unit direction towards it, the sun left out. A sky from an image
/// must have been read.
inline Rgb sky_radiance(const Sky& sky, const glm::dvec3& direction) {
  if (const auto* constant = std::get_if<ConstantSky>(&sky)) return constant->radiance;
  if (const auto* image_sky = std::get_if<ImageSky>(&sky)) return image_sky->image->radiance(direction);
  const auto& gradient = std::get<GradientSky>(sky);
  const double sine_of_elevation = glm::clamp(direction.z, 0.0, 1.0);
  return glm::mix(gradient.horizon, gradient.zenith, static_cast<float>(sine_of_elevation));
}

}  // namespace alidade::renderer
