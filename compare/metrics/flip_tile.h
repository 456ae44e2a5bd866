// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "base/instruction_set.h"
#include "compare/metrics/flip_model.h"

namespace alidade::compare {

/// A piece of two images with the pixels around it that filters reach, and room to work in. Planes are rows
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

  /// Linear light, with margin. image: 0 reference, 1 test; channel 0 to 2.
  float* rgb(int image, int channel) { return wide(3 * image + channel); }
  /// y, x - y, y - z of one image, with margin.
  float* opponent(int channel) { return wide(6 + channel); }
  /// Filtered in x only, with a margin above and below, but no columns left and right.
  float* pass(int channel) { return wide(9 + channel); }
  /// Without margin: the filtered channels of an image, then what becomes of them, and its features.
  float* color(int image, int channel) { return narrow(3 * image + channel); }
  float* edges(int image) { return narrow(6 + image); }
  float* points(int image) { return narrow(8 + image); }
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
/// no product is fused with a sum: the map has equal bits on every machine.
struct FlipKernel {
  /// Raises the tile's map to the FLIP values of its images at this exposure.
  void (*add_exposure)(FlipTile& tile, const FlipFilters& filters, const ToneCurve& curve);
};

/// For an available instruction set (not `best`).
const FlipKernel& flip_kernel(InstructionSet instruction_set);

}  // namespace simd

}  // namespace alidade::compare
