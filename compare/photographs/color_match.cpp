// SPDX-License-Identifier: MIT
#include "compare/photographs/color_match.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

constexpr int k_starts = 64, k_first_steps = 2, k_most_steps = 50;
constexpr std::size_t k_finalists = 8, k_least_pairs = 4;

struct Line {
  double scale = 0.0, offset = 0.0;
};

/// A line and the sum of the squares of the smaller half of its residuals.
struct Trial {
  Line line;
  double cost = 0.0;
};

/// Mixes a counter into 64 bits; S. Vigna, splitmix64 (2015).
std::uint64_t mixed(std::uint64_t counter) {
  std::uint64_t z = (counter + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

class LineFitter {
 public:
  LineFitter(std::span<const FitPair> pairs, LineKind kind)
      : pairs_(pairs), kind_(kind), weights_(pairs.size()), residuals_(pairs.size()) {
    std::vector<double> heights;
    heights.reserve(pairs.size());
    for (const FitPair& pair : pairs) heights.push_back(std::abs(pair.y));
    const double middle = median(heights);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double sum = heights[i] + middle;
      weights_[i] = sum > 0.0 ? 1.0 / sum : 1.0;
    }
  }

  std::optional<RobustLine> fit() {
    std::vector<Trial> trials;
    for (int start = 0; start < k_starts; ++start) {
      std::optional<Line> line = through(mixed(2 * static_cast<std::uint64_t>(start)),
                                         mixed(2 * static_cast<std::uint64_t>(start) + 1));
      for (int step = 0; step < k_first_steps && line; ++step) line = concentrated(*line);
      if (line) trials.push_back({*line, cost(*line)});
    }
    if (trials.empty()) return {};
    std::ranges::stable_sort(trials, {}, &Trial::cost);
    if (trials.size() > k_finalists) trials.resize(k_finalists);
    for (Trial& trial : trials) finish(trial);
    return reweighted(std::ranges::min_element(trials, {}, &Trial::cost)->line);
  }

 private:
  std::size_t half() const { return pairs_.size() / 2 + 1; }

  /// Least squares over the pairs that `takes`; empty if they do not determine one.
  template <typename Takes>
  std::optional<Line> least_squares(const Takes& takes) const {
    double w = 0.0, wx = 0.0, wy = 0.0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (!takes(i)) continue;
      const double weight = weights_[i] * weights_[i];
      w += weight;
      wx += weight * pairs_[i].x;
      wy += weight * pairs_[i].y;
    }
    if (!(w > 0.0)) return {};
    const bool is_free = kind_ == LineKind::free;
    const double middle_x = is_free ? wx / w : 0.0, middle_y = is_free ? wy / w : 0.0;
    double xx = 0.0, xy = 0.0, size = 0.0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (!takes(i)) continue;
      const double weight = weights_[i] * weights_[i];
      const double x = pairs_[i].x - middle_x;
      xx += weight * x * x;
      xy += weight * x * (pairs_[i].y - middle_y);
      size += weight * pairs_[i].x * pairs_[i].x;
    }
    // Of one value up to rounding: any slope would do.
    constexpr double k_least_spread = 1e-10;
    if (!(xx > k_least_spread * size) || !(xx > 0.0)) return {};
    const double scale = xy / xx;
    return Line{scale, middle_y - scale * middle_x};
  }

  /// The line through one or two pairs, as the random numbers choose them.
  std::optional<Line> through(std::uint64_t first, std::uint64_t second) const {
    const std::size_t a = first % pairs_.size(), b = second % pairs_.size();
    const FitPair &one = pairs_[a], &two = pairs_[b];
    if (kind_ == LineKind::through_zero) {
      if (one.x == 0.0) return {};
      return Line{one.y / one.x, 0.0};
    }
    if (one.x == two.x) return {};
    const double scale = (two.y - one.y) / (two.x - one.x);
    return Line{scale, one.y - scale * one.x};
  }

  /// Fills residuals_ with magnitudes and returns the largest one of the smaller half.
  double measure(const Line& line) {
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      residuals_[i] = weights_[i] * std::abs(pairs_[i].y - line.scale * pairs_[i].x - line.offset);
    sorted_ = residuals_;
    const auto last = sorted_.begin() + static_cast<std::ptrdiff_t>(half() - 1);
    std::ranges::nth_element(sorted_, last);
    return *last;
  }

  std::optional<Line> concentrated(const Line& line) {
    const double limit = measure(line);
    return least_squares([&](std::size_t i) { return residuals_[i] <= limit; });
  }

  double cost(const Line& line) {
    const double limit = measure(line);
    double sum = 0.0;
    std::size_t count = 0;
    for (const double residual : residuals_) {
      if (!(residual < limit)) continue;
      sum += residual * residual;
      ++count;
    }
    // Which of the equal residuals at the limit are in the half does not affect the sum.
    return sum + static_cast<double>(half() - count) * limit * limit;
  }

  void finish(Trial& trial) {
    for (int step = 0; step < k_most_steps; ++step) {
      const std::optional<Line> next = concentrated(trial.line);
      if (!next) return;
      const double next_cost = cost(*next);
      if (!(next_cost < trial.cost)) return;
      trial = {*next, next_cost};
    }
  }

  std::optional<RobustLine> reweighted(const Line& line) {
    // The median of normal residuals' magnitudes is 0.6745 standard deviations. Residuals are relative, so a
    // hundred thousandth is invisible.
    constexpr double k_deviations = 2.5, k_least_deviation = 1e-5;
    const double limit = k_deviations * std::max(measure(line) / 0.6745, k_least_deviation);
    const std::optional<Line> all = least_squares([&](std::size_t i) { return residuals_[i] <= limit; });
    if (!all) return {};
    measure(*all);
    const auto inliers =
        std::ranges::count_if(residuals_, [&](double residual) { return residual <= limit; });
    return RobustLine{all->scale, all->offset,
                      static_cast<double>(inliers) / static_cast<double>(pairs_.size())};
  }

  std::span<const FitPair> pairs_;
  LineKind kind_;
  std::vector<double> weights_, residuals_, sorted_;
};

/// Blocks along the longer side of the image, about.
constexpr int k_blocks_per_side = 64;
constexpr std::size_t k_least_blocks = 16;

/// Mean light of a block in both images.
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
  return is_finite(color) && !is_clipped(image, color) && shows_surface(image, pixel);
}

double light(const ComparedImage& image, std::size_t value) {
  const float code = image.color[value];
  return static_cast<double>(
      image.encoding == ColorEncoding::linear ? code : image::linear_from_srgb_table().at(code));
}

/// The blocks in which at least a quarter of the pixels counts.
std::vector<Block> mean_blocks(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask) {
  const int side = std::max(1, std::max(reference.width, reference.height) / k_blocks_per_side);
  const int columns = (reference.width + side - 1) / side, rows = (reference.height + side - 1) / side;
  std::vector<Block> blocks(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  in_parallel(rows, 1, [&](int row) {
    for (int y = row * side; y < std::min((row + 1) * side, reference.height); ++y) {
      for (int x = 0; x < reference.width; ++x) {
        const std::size_t pixel = pixel_index(x, y, reference.width);
        if (!mask.at(pixel) || !is_usable(reference, pixel) || !is_usable(test, pixel)) continue;
        Block& block = blocks[pixel_index(x / side, row, columns)];
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

std::optional<RobustLine> fit_robust_line(std::span<const FitPair> pairs, LineKind kind) {
  if (pairs.size() < k_least_pairs) return {};
  return LineFitter(pairs, kind).fit();
}

std::optional<ColorMatch> match_color(const ComparedImage& reference, const ComparedImage& test,
                                      const ImageMask& mask, ColorModel model) {
  require_same_size(reference, test);
  assert(reference.color.size() == 3 * reference.pixels() && test.color.size() == 3 * test.pixels());
  const std::vector<Block> blocks = mean_blocks(reference, test, mask);
  if (blocks.size() < k_least_blocks) return {};
  std::array<std::optional<RobustLine>, 3> lines;
  in_parallel(lines.size(), 1, [&](std::size_t channel) {
    std::vector<FitPair> pairs;
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
  const image::CurveTable &to_linear = image::linear_from_srgb_table(),
                          &to_display = image::srgb_from_linear_table();
  in_parallel(image.height, 4, [&](int y) {
    const auto row = static_cast<std::size_t>(image.width) * 3;
    float* const values = image.color.data() + static_cast<std::size_t>(y) * row;
    for (std::size_t i = 0; i < row; ++i) {
      const auto channel = static_cast<int>(i % 3);
      const double before = static_cast<double>(is_linear ? values[i] : to_linear.at(values[i]));
      const auto matched = static_cast<float>(match.scale[channel] * before + match.offset[channel]);
      values[i] = is_linear ? matched : to_display.at(matched);
    }
  });
  // The values are not codes any more.
  image.largest_code = 0;
}

}  // namespace alidade::compare
