// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/color.h"
#include "image/output_settings.h"

namespace alidade::image {

/// The finished image, pixel by pixel, row 0 on top. Colour and its variance are means over the pixel's
/// samples; the other values come from the ray through the pixel's centre and are never filtered. A pixel
/// whose centre sees no surface has infinite depth and distance, zero normal, position and albedo, and id 0.
/// The coverage comes from sixteen rays, evenly spread over the pixel.
///
/// Layers that were not requested are empty. Memory per pixel: colour with alpha 16 bytes, variance 12, depth
/// 4, distance 4, normal 12, position 24, albedo 12, id 4, sigma of the depth 4, coverage 4, support 4.
///
/// Variance: how far the pixel's colour would lie from that of endlessly many samples, squared, on average.
/// The samples of a pixel lie more evenly than independent ones, so sample variance over their number is too
/// large where light changes smoothly; renderer/noise.h describes the correction and how good it is. The
/// variance of one sample is unknown: infinite.
struct Film {
  int width = 0, height = 0;
  std::vector<Rgb> color;            ///< linear radiance
  std::vector<float> alpha;          ///< share of samples whose first ray met a surface
  std::vector<Rgb> variance;         ///< of the mean, per channel (squared standard error)
  std::vector<float> depth;          ///< planar: along the optical axis, metres
  std::vector<float> distance;       ///< along the ray, metres
  std::vector<glm::vec3> normal;     ///< world axes, unit
  std::vector<glm::dvec3> position;  ///< world
  std::vector<Rgb> albedo;           ///< linear
  std::vector<std::uint32_t> id;     ///< point id + 1; objects count down from 4294967295; 0 = nothing
  /// Standard deviation of the depth from that of the surface that was scanned, metres. 0 on objects,
  /// infinite where nothing is seen, and at rims before nothing.
  std::vector<float> depth_sigma;
  std::vector<float> coverage;         ///< share of the pixel that sees the cloud, in sixteenths
  std::vector<std::uint32_t> support;  ///< points that the surface is made of; 0 on objects and of nothing

  Film() = default;
  /// Every layer, with the values of a pixel that sees nothing.
  Film(int width, int height);
  /// Only these layers.
  Film(int width, int height, std::span<const Layer> layers);

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  /// Number of pixels.
  std::size_t count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  /// Whether the film has this layer.
  bool holds(Layer layer) const;
  bool holds_any() const;
  /// Whether a ray of any pixel met a surface; true if no layer shows that, as variance and albedo.
  bool sees_anything() const;
};

/// Every layer there is.
std::vector<Layer> all_layers();

/// The sRGB codes of a pixel as PNG and JPEG have them: with exposure, and with the background, or without
/// what is behind the surfaces if the output is transparent.
std::array<std::uint8_t, 3> displayed(const Film& film, std::size_t pixel, const OutputSettings& output);

}  // namespace alidade::image
