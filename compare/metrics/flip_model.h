// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "base/instruction_set.h"
#include "compare/metrics/flip_filters.h"

namespace alidade {

/// What becomes of linear light before FLIP looks at it: times `scale`, then through the curve
/// (k0 x^2 + k1 x + k2) / (k3 x^2 + k4 x + k5), or divided by 1 + the pixel's luminance, or as it is; then
/// clamped to 0 .. 1.
struct ToneCurve {
  enum class Kind { none, rational, luminance };
  Kind kind = Kind::none;
  float scale = 1.0f;
  float k[6] = {};
};

/// A piece of two pictures with the pixels around it that filters reach, and room to work in. Planes are rows
/// of `pitch` floats; those with a margin begin `margin` pixels to the left of and above the tile.
class FlipTile {
 public:
  /// For tiles of at most so many pixels.
  FlipTile(int most_width, int most_height, int margin);

  /// Turns to a tile of this size; forgets the map.
  void begin(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  int margin() const { return margin_; }
  std::size_t pitch() const { return pitch_; }
  int rows_with_margin() const { return height_ + 2 * margin_; }

  /// Linear light, with margin. picture: 0 reference, 1 test; channel 0 to 2.
  float* rgb(int picture, int channel) { return wide(3 * picture + channel); }
  /// y, x - y, y - z of one picture, with margin.
  float* opponent(int channel) { return wide(6 + channel); }
  /// Filtered in x only, with a margin above and below, but no columns left and right.
  float* pass(int channel) { return wide(9 + channel); }
  /// Without margin: the filtered channels of a picture, then what becomes of them, and its features.
  float* color(int picture, int channel) { return narrow(3 * picture + channel); }
  float* edges(int picture) { return narrow(6 + picture); }
  float* points(int picture) { return narrow(8 + picture); }
  /// The largest FLIP value of the exposures so far, without margin.
  float* map() { return narrow(10); }

 private:
  float* wide(int plane) { return values_.data() + static_cast<std::size_t>(plane) * wide_size_; }
  float* narrow(int plane) {
    return values_.data() + 12 * wide_size_ + static_cast<std::size_t>(plane) * narrow_size_;
  }

  int width_ = 0, height_ = 0, margin_;
  std::size_t pitch_, wide_size_, narrow_size_;
  std::vector<float> values_;
};

namespace simd {

/// FLIP of a tile, compiled for one instruction set. All sets do the same operations in the same order, and
/// no product is fused with a sum: the map is the same bits on every machine.
struct FlipKernel {
  /// Raises the tile's map to the FLIP values of its pictures at this exposure.
  void (*add_exposure)(FlipTile& tile, const FlipFilters& filters, const ToneCurve& curve);
};

/// For an available instruction set (not `best`).
const FlipKernel& flip_kernel(InstructionSet instruction_set);

}  // namespace simd
}  // namespace alidade
