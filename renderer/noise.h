// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/image_state.h"
#include "renderer/render.h"

// How noisy an image under way still is.
//
// The samples of a pixel are a scrambled (0,2)-sequence (renderer/sampler.h): their mean is less noisy than
// that of as many independent samples, the less so the more smoothly light depends on the numbers drawn. Let
// V(j) be the variance of the mean of the first 2^j samples. The second 2^j samples are as good as the first,
// and the mean of both has V(j + 1); so the squared difference between the mean of the first 2^(j+1) samples
// and that of the first 2^j is V(j) - V(j + 1) on average: this is what LevelSums add up. They give every
// V(j) but for one unknown, V at the last level. There V is taken as a part that falls as 1/2^j (what
// independent samples do) plus a part that falls as 1/8^j (the fastest that scrambling gives, Owen 1997); the
// last two levels distinguish the parts. The answer is right for any mixture of these, and too high, never
// too low, for what falls at a rate between them. With n between powers of two the same rules give the
// variance of n samples.
//
// The sums are those of a tile: every pixel keeps its own sample variance, and the tile gives how much less
// than sample variance / n the variance of the mean is.
//
// How good that is: mean reported variance over that measured between 200 seeds, 8 to 128 samples
// (tests/renderer/noise_test.cpp, which holds it between 1 / 1.3 and 4). In brackets sample variance / n:
//   paths over a cloud in sun and sky            1.2 to 1.3   (1.5 to 1.7)
//   lamps, rough metal, glass                    1.6 to 2.1   (1.4 to 2.1)
//   edges without other noise                    1.1 to 2.2   (4.5 to 7.7)
//   a plane under a smooth sky, no other noise   1.2 to 3.4   (3 to 88)

namespace alidade::renderer {

/// What a pixel's sum of squared differences (SumBand::squares) is to be multiplied with to become the
/// variance of its mean. At least two samples: one gives no estimate.
double mean_variance_scale(const LevelSums& levels, std::uint32_t samples);

/// Noise of some pixels.
struct Noise {
  double variance = 0.0;   ///< of the luminance of the means, summed over the pixels; infinite if unknown
  double luminance = 0.0;  ///< summed over the pixels
  std::size_t pixels = 0;

  Noise& operator+=(const Noise& other);

  /// Relative error: the root of the mean variance over the mean luminance, to which `floor` is added so that
  /// black need not be exact.
  double error(double floor) const;
};

/// The noise of a tile, on the safe side, unknown below two samples; its state must be kept with noise. Where
/// a few pixels have most of the noise (the edge of a lamp), the sums of the tile mean little, and a test
/// that is repeated until they are low is misled. So they count as many times as there are pixels that
/// matter, (sum of variances)^2 / sum of squared variances, against four times for what independent samples
/// would leave. The luminance's standard deviation is taken as the weighted sum of those of the channels,
/// which is right for grey noise and else too high. Cost: its pixels.
Noise tile_noise(const ImageState& state, std::size_t tile);

/// Decides between passes which tiles have low enough noise. All are judged by the same state, so that the
/// answer depends neither on order nor on threads.
///
/// A tile stops when it has k_fewest_samples and its error, and that of it and its neighbours together, are
/// at most the target. Counting the neighbours keeps neighbouring tiles alike, and makes the chance small
/// that a tile stops because its few samples happen to agree.
///
/// That chance is the bias of every such rule: samples that are kept back are most often those that would
/// have found rare light, so an image made with a target is a little too dark where light is rare (lamps
/// seen by few paths), by a part of the target error. Images that are to be averaged or measured are made
/// with a fixed number of samples.
class StopRule {
 public:
  /// `floor` is what luminance is raised by before errors are relative to it.
  StopRule(double target, double floor) : target_(target), floor_(floor) {}

  /// Marks the tiles that may stop.
  void apply(ImageState& state);

  /// Samples per pixel that a tile that does not stop is expected to need: noise falls with the root of their
  /// number. At most `most`.
  double expected_samples(const ImageState& state, std::size_t tile, double most) const;

  static constexpr std::uint32_t k_fewest_samples = 32;

 private:
  const double target_, floor_;
  std::vector<Noise> noise_;  ///< by tile
};

/// Luminance that errors are relative to is raised by this: a hundredth of what an image of this exposure
/// shows as white.
double noise_floor(double exposure);

/// Median and worst error over the tiles; the state must be kept with noise.
ReachedNoise reached_noise(const ImageState& state, double floor);

}  // namespace alidade::renderer
