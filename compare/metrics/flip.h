// SPDX-License-Identifier: MIT
#pragma once

#include <numbers>
#include <optional>
#include <vector>

#include "base/instruction_set.h"
#include "base/progress.h"
#include "compare/compared_image.h"

namespace alidade::compare {

/// Pixels per degree of the eye's field of view, from the viewing distance and the monitor's width in metres.
constexpr double pixels_per_degree(double distance, double monitor_width, double monitor_pixels) {
  return distance * monitor_pixels / monitor_width * std::numbers::pi / 180.0;
}

/// How HDR-FLIP maps light to the range of a display.
enum class ToneMapper { aces, hable, reinhard };

/// The range of light that FLIP assumes for the reference.
enum class FlipRange {
  automatic,  ///< `high` if the reference is linear light, else `display`
  display,    ///< LDR-FLIP: linear light is clamped to 0 .. 1
  high        ///< HDR-FLIP: the worst of many exposures
};

struct FlipOptions {
  double pixels_per_degree =
      compare::pixels_per_degree(0.7, 0.7, 3840.0);  ///< 67.02, as in the authors' tool
  FlipRange range = FlipRange::automatic;
  ToneMapper tone_mapper = ToneMapper::aces;
  std::optional<double> start_exposure, stop_exposure;  ///< stops, -1000 .. 1000; found from the reference
  std::optional<int> exposures;                         ///< 2 to 256; one per stop if not given
  InstructionSet instruction_set = InstructionSet::best;
};

struct FlipResult {
  double mean = 0.0;
  double weighted_median = 0.0, weighted_first_quartile = 0.0, weighted_third_quartile = 0.0;
  double min = 0.0, max = 0.0;
  std::vector<float> map;  ///< one per pixel, 0 .. 1; 0 where the mask excludes it
  double start_exposure = 0.0, stop_exposure = 0.0;
  int exposures = 0;  ///< 0: LDR-FLIP
};

/// FLIP, how different two images look to a person who sees them in turn: 0 not at all, 1 as much as can
/// be. The figures are over the pixels that count; all are 0 if none does. Pixels with NaN or infinite values
/// do not. Weighted quantile q: the smallest map value at which the sum of all values up to it exceeds q of
/// the whole sum.
///
/// The map is symmetric in the images for FlipRange::display; otherwise exposures come from the reference.
/// Borders: filters see the outermost pixels repeated. Equal bits on any thread count and instruction set.
/// Source: HPG 2020 paper of FlipFilters; for HDR P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Möller,
/// "Visualizing Errors in Rendered High Dynamic Range Images", Eurographics 2021; both as their tool 1.6 has
/// them (within 1e-4). Errors: sizes differ, an image without colour, options out of their ranges. Cost on 2
/// cores: about 0.04 s per million pixels, and in HDR 0.03 s more for each exposure. Memory: the map and some
/// MB per thread. Progress counts tiles.
FlipResult flip(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask = {},
                const FlipOptions& options = {}, const Progress& progress = {});

}  // namespace alidade::compare
