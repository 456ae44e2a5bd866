// SPDX-License-Identifier: MIT
#include "compare/photographs/alignment.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

/// Gradients of an image at one resolution, in steps of 1/127: g / sqrt(|g|^2 + s^2), s the root mean square
/// of |g| over the pixels that count. Whole numbers, so that sums over them are exact in any order.
struct GradientLevel {
  int width = 0, height = 0;
  std::vector<std::int8_t> x{}, y{};   ///< 0 where the pixel does not count
  std::vector<std::uint8_t> counts{};  ///< 1 or 0
  std::uint64_t counted_pixels = 0;
};

constexpr float k_none = std::numeric_limits<float>::quiet_NaN();

/// One number per pixel; NaN where it does not count.
struct Plane {
  Plane(int width_, int height_)
      : width(width_),
        height(height_),
        values(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

  float* row(int y) { return values.data() + static_cast<std::size_t>(y) * width; }
  const float* row(int y) const { return values.data() + static_cast<std::size_t>(y) * width; }

  int width, height;
  std::vector<float> values;
};

constexpr int k_rows_at_once = 16;

Plane luminance(const ComparedImage& image, const ImageMask& mask) {
  Plane plane(image.width, image.height);
  const bool is_linear = image.encoding == ColorEncoding::linear;
  const image::CurveTable& curve = image::srgb_from_linear_table();
  in_parallel(plane.height, k_rows_at_once, [&](int y) {
    const std::size_t first = static_cast<std::size_t>(y) * image.width;
    for (std::size_t i = first; i < first + static_cast<std::size_t>(image.width); ++i) {
      // The weights of Rec. 709.
      const float light =
          0.2126f * image.color[3 * i] + 0.7152f * image.color[3 * i + 1] + 0.0722f * image.color[3 * i + 2];
      const bool counts = mask.at(i) && std::isfinite(light) && shows_surface(image, i);
      plane.values[i] = !counts ? k_none : is_linear ? curve.at(light) : light;
    }
  });
  return plane;
}

constexpr std::array<float, 5> k_binomial{1.0f / 16, 4.0f / 16, 6.0f / 16, 4.0f / 16, 1.0f / 16};

/// The binomial filter over what counts; more than half of its weight must.
Plane smoothed(const Plane& plane) {
  Plane result(plane.width, plane.height);
  in_blocks(static_cast<std::size_t>(plane.height), k_rows_at_once, [&](std::size_t top, std::size_t bottom) {
    // Sums down the columns, with two columns of nothing at both ends.
    std::vector<float> sums(static_cast<std::size_t>(plane.width) + 4), weights(sums.size());
    for (int y = static_cast<int>(top); y != static_cast<int>(bottom); ++y) {
      std::ranges::fill(sums, 0.0f);
      std::ranges::fill(weights, 0.0f);
      for (int step = -2; step <= 2; ++step) {
        if (y + step < 0 || y + step >= plane.height) continue;
        const float* const values = plane.row(y + step);
        const float weight = k_binomial[static_cast<std::size_t>(step + 2)];
        for (int x = 0; x < plane.width; ++x) {
          const bool counts = !std::isnan(values[x]);
          sums[static_cast<std::size_t>(x) + 2] += counts ? weight * values[x] : 0.0f;
          weights[static_cast<std::size_t>(x) + 2] += counts ? weight : 0.0f;
        }
      }
      float* const out = result.row(y);
      for (int x = 0; x < plane.width; ++x) {
        float sum = 0.0f, weight = 0.0f;
        for (std::size_t step = 0; step < 5; ++step) {
          sum += k_binomial[step] * sums[static_cast<std::size_t>(x) + step];
          weight += k_binomial[step] * weights[static_cast<std::size_t>(x) + step];
        }
        out[x] = weight > 0.5f ? sum / weight : k_none;
      }
    }
  });
  return result;
}

Plane halved(const Plane& plane) {
  Plane result((plane.width + 1) / 2, (plane.height + 1) / 2);
  in_parallel(result.height, k_rows_at_once, [&](int y) {
    for (int x = 0; x < result.width; ++x) result.row(y)[x] = plane.row(2 * y)[2 * x];
  });
  return result;
}

struct Gradient {
  float x, y;  ///< NaN where a neighbour does not count

  float length_sq() const { return x * x + y * y; }
};

/// Gradients by central differences; the outermost pixels have none.
Gradient gradient_at(const Plane& plane, int x, int y) {
  if (x == 0 || y == 0 || x == plane.width - 1 || y == plane.height - 1) return {k_none, k_none};
  const float* const here = plane.row(y);
  return {0.5f * (here[x + 1] - here[x - 1]), 0.5f * (plane.row(y + 1)[x] - plane.row(y - 1)[x])};
}

GradientLevel gradients(const Plane& plane) {
  std::vector<double> row_sums(static_cast<std::size_t>(plane.height), 0.0);
  std::vector<std::uint64_t> row_counts(row_sums.size(), 0);
  in_parallel(plane.height, k_rows_at_once, [&](int y) {
    for (int x = 0; x < plane.width; ++x) {
      const float length_sq = gradient_at(plane, x, y).length_sq();
      if (std::isnan(length_sq)) continue;
      row_sums[static_cast<std::size_t>(y)] += static_cast<double>(length_sq);
      ++row_counts[static_cast<std::size_t>(y)];
    }
  });
  GradientLevel level{.width = plane.width, .height = plane.height};
  double sum = 0.0;
  for (std::size_t y = 0; y < row_sums.size(); ++y) {
    sum += row_sums[y];
    level.counted_pixels += row_counts[y];
  }
  const auto mean_sq =
      static_cast<float>(level.counted_pixels > 0 ? sum / static_cast<double>(level.counted_pixels) : 0.0);
  level.x.resize(plane.values.size());
  level.y.resize(plane.values.size());
  level.counts.resize(plane.values.size());
  in_parallel(plane.height, k_rows_at_once, [&](int y) {
    for (int x = 0; x < plane.width; ++x) {
      const Gradient gradient = gradient_at(plane, x, y);
      const float length_sq = gradient.length_sq();
      if (std::isnan(length_sq)) continue;
      const std::size_t i = static_cast<std::size_t>(y) * plane.width + static_cast<std::size_t>(x);
      level.counts[i] = 1;
      if (!(length_sq > 0.0f)) continue;
      const float scale = 127.0f / std::sqrt(length_sq + mean_sq);
      level.x[i] = static_cast<std::int8_t>(std::lround(scale * gradient.x));
      level.y[i] = static_cast<std::int8_t>(std::lround(scale * gradient.y));
    }
  });
  return level;
}

/// Gradients of the luminance of the display-referred colours; level 0 has the image's size, each further
/// one half of it, rounded up. A pixel (x, y) of a level is at (2 x, 2 y) of the one before. What counts:
/// align(). Pixels whose neighbours count for more than half in the binomial filter
/// count as well, so that single holes close. Requires levels >= 1. Memory: 8 bytes per pixel beside the
/// result, which takes 4.
std::vector<GradientLevel> gradient_pyramid(const ComparedImage& image, const ImageMask& mask, int levels) {
  std::vector<GradientLevel> pyramid;
  Plane plane = smoothed(luminance(image, mask));
  pyramid.push_back(gradients(plane));
  while (static_cast<int>(pyramid.size()) < levels) {
    plane = smoothed(halved(plane));
    pyramid.push_back(gradients(plane));
  }
  return pyramid;
}

// When a shift is certain. Images of different things reach scores of 0.02, a render of a scan and its
// photograph 0.5; where edges run in one direction only, the peak is a ridge.
constexpr double k_least_score = 0.1, k_most_of_rival = 0.8, k_least_sharpness = 0.005;

/// Whole pixels of a level.
struct Shift {
  int x = 0, y = 0;
  auto operator<=>(const Shift&) const = default;
};

/// A shift and how well it does.
struct Candidate {
  Shift shift;
  double score = 0.0;
};

struct OverlapSums {
  std::int64_t product = 0, reference = 0, test = 0, pixels = 0;

  OverlapSums& operator+=(const OverlapSums& other) {
    product += other.product;
    reference += other.reference;
    test += other.test;
    pixels += other.pixels;
    return *this;
  }
};

/// Scores of shifts between two levels of one size; each is computed once.
class ShiftScores {
 public:
  ShiftScores(const GradientLevel& reference, const GradientLevel& test)
      : reference_(reference), test_(test) {}

  double at(const Shift& shift) {
    const auto [known, is_new] = known_.try_emplace(shift, 0.0);
    if (is_new) known->second = score(shift);
    return known->second;
  }

 private:
  /// Sums along a part of a row, short enough for 32 bits.
  OverlapSums part_sums(std::size_t r, std::size_t t, std::size_t count) const {
    std::int32_t product = 0, reference = 0, test = 0, pixels = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t rx = reference_.x[r + i], ry = reference_.y[r + i];
      const std::int32_t tx = test_.x[t + i], ty = test_.y[t + i];
      const std::int32_t rc = reference_.counts[r + i], tc = test_.counts[t + i];
      product += rx * tx + ry * ty;
      reference += (rx * rx + ry * ry) * tc;
      test += (tx * tx + ty * ty) * rc;
      pixels += rc * tc;
    }
    return {product, reference, test, pixels};
  }

  double score(const Shift& shift) const {
    constexpr std::size_t k_longest_part = 32768;
    const int left = std::max(0, -shift.x), right = std::min(reference_.width, test_.width - shift.x);
    const int top = std::max(0, -shift.y), bottom = std::min(reference_.height, test_.height - shift.y);
    if (left >= right || top >= bottom) return 0.0;
    const OverlapSums sums = tbb::parallel_reduce(
        tbb::blocked_range<int>(top, bottom, 64), OverlapSums{},
        [&](const auto& rows, OverlapSums sum) {
          for (int y = rows.begin(); y != rows.end(); ++y) {
            const auto count = static_cast<std::size_t>(right - left);
            const std::size_t r = pixel_index(left, y, reference_.width),
                              t = pixel_index(left + shift.x, y + shift.y, reference_.width);
            for (std::size_t done = 0; done < count; done += k_longest_part)
              sum += part_sums(r + done, t + done, std::min(k_longest_part, count - done));
          }
          return sum;
        },
        [](OverlapSums a, const OverlapSums& b) { return a += b; });
    // Where hardly anything overlaps, anything can look alike.
    const auto fewer = static_cast<std::int64_t>(std::min(reference_.counted_pixels, test_.counted_pixels));
    if (4 * sums.pixels < fewer || sums.reference == 0 || sums.test == 0) return 0.0;
    return static_cast<double>(sums.product) /
           std::sqrt(static_cast<double>(sums.reference) * static_cast<double>(sums.test));
  }

  const GradientLevel &reference_, &test_;
  std::map<Shift, double> known_;
};

/// How far a search goes, pixels of a level.
struct Reach {
  int x = 0, y = 0;
};

bool is_within(const Shift& shift, const Reach& reach) {
  return std::abs(shift.x) <= reach.x && std::abs(shift.y) <= reach.y;
}

bool is_better(const Candidate& a, const Candidate& b) {
  return a.score != b.score ? a.score > b.score : a.shift < b.shift;
}

/// Shifts of all neighbours, none of which does better.
std::vector<Candidate> local_maxima(ShiftScores& scores, const Reach& reach) {
  std::vector<Candidate> maxima;
  for (int y = -reach.y; y <= reach.y; ++y) {
    for (int x = -reach.x; x <= reach.x; ++x) {
      const Candidate here{{x, y}, scores.at({x, y})};
      bool is_highest = true;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Shift beside{x + dx, y + dy};
          if (beside != here.shift && is_within(beside, reach))
            is_highest &= is_better(here, {beside, scores.at(beside)});
        }
      }
      if (is_highest) maxima.push_back(here);
    }
  }
  std::ranges::sort(maxima, is_better);
  return maxima;
}

/// Uphill from a shift.
Candidate climb(ShiftScores& scores, Shift from, const Reach& reach) {
  from.x = std::clamp(from.x, -reach.x, reach.x);
  from.y = std::clamp(from.y, -reach.y, reach.y);
  Candidate best{from, scores.at(from)};
  while (true) {
    Candidate next = best;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Shift beside{best.shift.x + dx, best.shift.y + dy};
        if (!is_within(beside, reach)) continue;
        const Candidate other{beside, scores.at(beside)};
        if (is_better(other, next)) next = other;
      }
    }
    if (next.shift == best.shift) return best;
    best = next;
  }
}

/// The paraboloid a + b x + c y + d x^2 + e y^2 + f x y through the nine scores around a shift, by least
/// squares.
struct Peak {
  double x = 0.0, y = 0.0;  ///< of the top, from the shift
  double rise = 0.0;        ///< of the top above the middle
  double sharpness = 0.0;   ///< how fast it falls in the flattest direction; at most 0: no top
};

Peak fit_peak(ShiftScores& scores, const Shift& shift) {
  double b = 0.0, c = 0.0, d = 0.0, e = 0.0, f = 0.0;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      const double score = scores.at({shift.x + x, shift.y + y});
      b += score * x / 6.0;
      c += score * y / 6.0;
      d += score * (0.5 * x * x - 1.0 / 3.0);
      e += score * (0.5 * y * y - 1.0 / 3.0);
      f += score * x * y / 4.0;
    }
  }
  Peak peak;
  // Half the smaller eigenvalue of minus the matrix of second derivatives.
  peak.sharpness = -0.5 * (d + e) - 0.5 * std::sqrt((d - e) * (d - e) + f * f);
  if (!(peak.sharpness > 0.0)) return peak;
  const double determinant = 4.0 * d * e - f * f;
  peak.x = std::clamp((c * f - 2.0 * b * e) / determinant, -1.0, 1.0);
  peak.y = std::clamp((b * f - 2.0 * c * d) / determinant, -1.0, 1.0);
  peak.rise = 0.5 * (b * peak.x + c * peak.y);
  return peak;
}

/// Score of the best shift that is another than the best one, not just a shift on its slope; 0 if there is
/// none.
double best_rival(const std::vector<Candidate>& candidates) {
  constexpr Reach k_slope{3, 3};
  for (const Candidate& each : candidates) {
    const Shift way{each.shift.x - candidates.front().shift.x, each.shift.y - candidates.front().shift.y};
    if (!is_within(way, k_slope)) return each.score;
  }
  return 0.0;
}

/// Halvings after which the search reaches few pixels and the image is still large enough.
int level_count(const ComparedImage& image, int largest_shift) {
  constexpr int k_least_side = 48, k_coarse_reach = 4;
  int levels = 1;
  int side = std::min(image.width, image.height), reach = largest_shift;
  while (reach > k_coarse_reach && side >= 2 * k_least_side) {
    side = (side + 1) / 2;
    reach = (reach + 1) / 2;
    ++levels;
  }
  return levels;
}

/// Of a level: the largest shift, as long as anything of both images still lies on each other.
Reach reach_of(const ComparedImage& image, int largest_shift, int level) {
  const auto halved = [&](int length) { return (length + (1 << level) - 1) >> level; };
  return {std::min(halved(largest_shift), halved(image.width) - 1),
          std::min(halved(largest_shift), halved(image.height) - 1)};
}

/// Errors: the coarsest level, on which all shifts are tried, is too large for that.
void check_work(const ComparedImage& image, int largest_shift, int level) {
  // Half a minute on two cores. Only images a thousand times as long as they are wide come near it.
  constexpr double k_most_work = 68719476736.0;
  const Reach reach = reach_of(image, largest_shift, level);
  const double pixels = std::ldexp(static_cast<double>(image.pixels()), -2 * level);
  const double shifts = (2.0 * reach.x + 1.0) * (2.0 * reach.y + 1.0);
  if (shifts * pixels <= k_most_work) return;
  throw Error(image.file.string(), {}, "the image is too narrow for a search of this width",
              "a smaller maximum shift", std::to_string(largest_shift) + " pixels");
}

}  // namespace

Alignment align(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask,
                const AlignmentOptions& options) {
  require_same_size(reference, test);
  assert(reference.color.size() == 3 * reference.pixels() && test.color.size() == 3 * test.pixels());
  constexpr int k_largest = 4096;
  check_that(options.largest_shift >= 1 && options.largest_shift <= k_largest, "maximum shift out of range",
             "1 to " + std::to_string(k_largest) + " pixels", std::to_string(options.largest_shift));
  const int levels = level_count(reference, options.largest_shift);
  check_work(reference, options.largest_shift, levels - 1);
  const std::vector<GradientLevel> of_reference = gradient_pyramid(reference, mask, levels);
  const std::vector<GradientLevel> of_test = gradient_pyramid(test, mask, levels);

  constexpr std::size_t k_most_candidates = 4;
  std::vector<Candidate> candidates;
  Alignment alignment;
  for (int level = levels - 1; level >= 0; --level) {
    const auto i = static_cast<std::size_t>(level);
    ShiftScores scores(of_reference[i], of_test[i]);
    const Reach reach = reach_of(reference, options.largest_shift, level);
    if (level == levels - 1) {
      candidates = local_maxima(scores, reach);
    } else {
      for (Candidate& each : candidates) each = climb(scores, {2 * each.shift.x, 2 * each.shift.y}, reach);
      std::ranges::sort(candidates, is_better);
      const auto is_same = [](const Candidate& a, const Candidate& b) { return a.shift == b.shift; };
      candidates.erase(std::unique(candidates.begin(), candidates.end(), is_same), candidates.end());
    }
    if (candidates.size() > k_most_candidates) candidates.resize(k_most_candidates);
    if (level > 0) continue;

    const Candidate& best = candidates.front();
    alignment.score_unshifted = scores.at({0, 0});
    if (!(best.score > 0.0)) continue;
    const Peak peak = fit_peak(scores, best.shift);
    alignment.shift_x = best.shift.x + peak.x;
    alignment.shift_y = best.shift.y + peak.y;
    alignment.score = best.score + peak.rise;
    alignment.is_certain =
        best.score >= k_least_score && best_rival(candidates) <= k_most_of_rival * best.score &&
        peak.sharpness >= k_least_sharpness * best.score && is_within(best.shift, {reach.x - 1, reach.y - 1});
  }
  return alignment;
}

}  // namespace alidade::compare
