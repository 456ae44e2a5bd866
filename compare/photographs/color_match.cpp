// SPDX-License-Identifier: MIT
#include "compare/photographs/color_match.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include "compare/photographs/robust_line.h"
#include "image/srgb.h"

namespace alidade {
namespace {

/// Blocks along the longer side of the picture, about.
constexpr int k_blocks_per_side = 64;
constexpr std::size_t k_least_blocks = 16;

/// Mean light of a block in both pictures.
struct Block {
  std::array<double, 3> reference{}, test{};
  int pixels = 0;
};

/// A display-encoded pixel with a channel at the end of the codes: the camera may have clipped it.
bool is_clipped(const ComparedImage& image, const float* color) {
  constexpr float k_lowest = 1.0f / 255.0f, k_highest = 254.0f / 255.0f;
  if (image.encoding == ColorEncoding::linear) return false;
  return std::any_of(color, color + 3, [](float value) { return value <= k_lowest || value >= k_highest; });
}

bool is_usable(const ComparedImage& image, std::size_t pixel) {
  const float* const color = image.color.data() + 3 * pixel;
  return std::isfinite(color[0]) && std::isfinite(color[1]) && std::isfinite(color[2]) &&
         !is_clipped(image, color) && shows_surface(image, pixel);
}

double light(const ComparedImage& image, std::size_t value) {
  const float code = image.color[value];
  return static_cast<double>(image.encoding == ColorEncoding::linear ? code
                                                                     : linear_from_srgb_table().at(code));
}

/// The blocks of which at least a quarter counts.
std::vector<Block> mean_blocks(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask) {
  const int side = std::max(1, std::max(reference.width, reference.height) / k_blocks_per_side);
  const int columns = (reference.width + side - 1) / side, rows = (reference.height + side - 1) / side;
  std::vector<Block> blocks(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  tbb::parallel_for(0, rows, [&](int row) {
    for (int y = row * side; y < std::min((row + 1) * side, reference.height); ++y) {
      for (int x = 0; x < reference.width; ++x) {
        const std::size_t pixel = static_cast<std::size_t>(y) * reference.width + static_cast<std::size_t>(x);
        if (!mask.at(pixel) || !is_usable(reference, pixel) || !is_usable(test, pixel)) continue;
        Block& block = blocks[static_cast<std::size_t>(row) * columns + static_cast<std::size_t>(x / side)];
        ++block.pixels;
        for (std::size_t channel = 0; channel < 3; ++channel) {
          block.reference[channel] += light(reference, 3 * pixel + channel);
          block.test[channel] += light(test, 3 * pixel + channel);
        }
      }
    }
  });
  std::erase_if(blocks, [&](const Block& block) { return 4 * block.pixels < side * side; });
  for (Block& block : blocks) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      block.reference[channel] /= block.pixels;
      block.test[channel] /= block.pixels;
    }
  }
  return blocks;
}

}  // namespace

std::optional<ColorMatch> match_color(const ComparedImage& reference, const ComparedImage& test,
                                      const ImageMask& mask, ColorModel model) {
  require_same_size(reference, test);
  assert(reference.color.size() == 3 * reference.pixels() && test.color.size() == 3 * test.pixels());
  const std::vector<Block> blocks = mean_blocks(reference, test, mask);
  if (blocks.size() < k_least_blocks) return {};
  std::array<std::optional<RobustLine>, 3> lines;
  tbb::parallel_for(std::size_t{0}, std::size_t{3}, [&](std::size_t channel) {
    std::vector<LinePair> pairs;
    pairs.reserve(blocks.size());
    for (const Block& block : blocks) pairs.push_back({block.test[channel], block.reference[channel]});
    lines[channel] =
        fit_robust_line(pairs, model == ColorModel::affine ? LineKind::free : LineKind::through_zero);
  });
  ColorMatch match{.inliers = 1.0};
  for (int channel = 0; channel < 3; ++channel) {
    const std::optional<RobustLine>& line = lines[static_cast<std::size_t>(channel)];
    if (!line) return {};
    match.scale[channel] = line->scale;
    match.offset[channel] = line->offset;
    match.inliers = std::min(match.inliers, line->inliers);
  }
  return match;
}

void apply_color_match(ComparedImage& image, const ColorMatch& match) {
  const bool is_linear = image.encoding == ColorEncoding::linear;
  const CurveTable &to_linear = linear_from_srgb_table(), &to_display = srgb_from_linear_table();
  tbb::parallel_for(0, image.height, [&](int y) {
    const auto row = static_cast<std::size_t>(image.width) * 3;
    float* const values = image.color.data() + static_cast<std::size_t>(y) * row;
    for (std::size_t i = 0; i < row; ++i) {
      const auto channel = static_cast<int>(i % 3);
      const double before = static_cast<double>(is_linear ? values[i] : to_linear.at(values[i]));
      const auto matched = static_cast<float>(match.scale[channel] * before + match.offset[channel]);
      values[i] = is_linear ? matched : to_display.at(matched);
    }
  });
  // They are no codes any more.
  image.largest_code = 0;
}

}  // namespace alidade
