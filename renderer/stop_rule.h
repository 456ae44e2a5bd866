// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "renderer/noise.h"
#include "renderer/render.h"

namespace alidade {

/// Decides between passes which tiles have low enough noise. All are judged by the same state, so that the
/// answer depends neither on order nor on threads.
///
/// A tile stops when it has k_fewest_samples and its error, and that of it and its neighbours together, are
/// at most the target. Looking at the neighbours keeps neighbouring tiles alike, and makes the chance small
/// that a tile stops because its few samples happen to agree.
///
/// That chance is the bias of every such rule: samples that are kept back are most often those that would
/// have found rare light, so a picture made with a target is a little too dark where light is rare (lamps
/// seen by few paths), by a part of the target error. Pictures that are to be averaged or measured are made
/// with a fixed number of samples.
class StopRule {
 public:
  /// `floor` is what luminance is raised by before errors are relative to it.
  StopRule(double target, double floor) : target_(target), floor_(floor) {}

  /// Marks the tiles that may stop.
  void apply(PictureState& state);

  /// Samples per pixel that a tile that goes on is expected to need: noise falls with the root of their
  /// number. At most `most`.
  double expected_samples(const PictureState& state, std::size_t tile, double most) const;

  static constexpr std::uint32_t k_fewest_samples = 32;

 private:
  const double target_, floor_;
  std::vector<Noise> noise_;  ///< by tile
};

/// Luminance that errors are relative to is raised by this: a hundredth of what a picture of this exposure
/// shows as white.
double noise_floor(double exposure);

/// Median and worst error over the tiles; the state must be kept with noise.
ReachedNoise reached_noise(const PictureState& state, double floor);

}  // namespace alidade
