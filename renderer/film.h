// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "renderer/material.h"

namespace alidade {

/// The finished image, pixel by pixel, row 0 on top. Colour and its variance are means over the pixel's
/// samples; the other values come from the ray through the pixel's centre and are never filtered. A pixel
/// whose centre sees no surface has infinite depth and distance, zero normal, position and albedo, and id 0.
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

  Film() = default;
  Film(int width, int height);
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};

}  // namespace alidade
