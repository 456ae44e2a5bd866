// SPDX-License-Identifier: MIT
#include "compare/layer_metrics.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>

#include "compare/float_ranks.h"
#include "renderer/deterministic_math.h"

namespace alidade {
namespace {

/// Runs row(y, its sums) for all rows and adds the sums up from the top.
template <class Sums, class Row>
Sums over_rows(int height, const Row& row) {
  std::vector<Sums> rows(static_cast<std::size_t>(height));
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    for (int y = range.begin(); y != range.end(); ++y) row(y, rows[static_cast<std::size_t>(y)]);
  });
  Sums all;
  for (const Sums& one : rows) all.add(one);
  return all;
}

/// Whether a pixel has a value in the reference and in the test.
struct Seen {
  bool reference, test;
};

/// Sums of sizes of differences.
struct DifferenceSums {
  std::uint64_t pixels = 0, only_reference = 0, only_test = 0;
  double sum = 0.0, sum_abs = 0.0, sum_squares = 0.0, sum_relative = 0.0, most = 0.0;
  std::size_t most_at = 0;
  std::uint64_t within[3] = {};

  void add(const DifferenceSums& other) {
    pixels += other.pixels;
    only_reference += other.only_reference;
    only_test += other.only_test;
    sum += other.sum;
    sum_abs += other.sum_abs;
    sum_squares += other.sum_squares;
    sum_relative += other.sum_relative;
    if (other.most > most) {
      most = other.most;
      most_at = other.most_at;
    }
    for (int i = 0; i < 3; ++i) within[i] += other.within[i];
  }

  void add(double difference, std::size_t pixel) {
    ++pixels;
    sum += difference;
    sum_abs += std::fabs(difference);
    sum_squares += difference * difference;
    if (std::fabs(difference) > most) {
      most = std::fabs(difference);
      most_at = pixel;
    }
  }

  /// Whether both have a value; counts what one has alone.
  bool both(const Seen& seen) {
    if (seen.reference && !seen.test) ++only_reference;
    if (seen.test && !seen.reference) ++only_test;
    return seen.reference && seen.test;
  }

  double percent(std::uint64_t count) const {
    return pixels == 0 ? 0.0 : 100.0 * static_cast<double>(count) / static_cast<double>(pixels);
  }
  double mean(double of_all) const { return pixels == 0 ? 0.0 : of_all / static_cast<double>(pixels); }
};

template <class Work>
void for_counted(const ComparedImage& image, const ImageMask& mask, int y, const Work& work) {
  const auto width = static_cast<std::size_t>(image.width);
  const std::size_t first = static_cast<std::size_t>(y) * width;
  for (std::size_t pixel = first; pixel < first + width; ++pixel)
    if (mask.at(pixel)) work(pixel);
}

/// Of the values that are not negative.
template <class ValueAt>
double percentile_95(std::size_t size, const ValueAt& value_at, std::uint64_t values) {
  if (values == 0) return 0.0;
  return value_of_rank(size, value_at, count_upper_halves(size, value_at), values - values / 20 - 1);
}

DepthMetrics compare_depth(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  const auto seen = [&](std::size_t pixel) {
    return Seen{is_depth(reference.depth[pixel]), is_depth(test.depth[pixel])};
  };
  const auto difference = [&](std::size_t pixel) {
    return static_cast<double>(test.depth[pixel]) - static_cast<double>(reference.depth[pixel]);
  };
  const auto sums = over_rows<DifferenceSums>(reference.height, [&](int y, DifferenceSums& row) {
    for_counted(reference, mask, y, [&](std::size_t pixel) {
      if (!row.both(seen(pixel))) return;
      const double apart = difference(pixel), size = std::fabs(apart), depth = reference.depth[pixel];
      row.add(apart, pixel);
      row.sum_relative += size / depth;
      row.within[0] += size <= 0.01 ? 1 : 0;
      row.within[1] += size <= 0.05 ? 1 : 0;
      row.within[2] += size <= 0.01 * depth ? 1 : 0;
    });
  });
  DepthMetrics metrics{
      .pixels = sums.pixels, .only_reference = sums.only_reference, .only_test = sums.only_test};
  metrics.mean = sums.mean(sums.sum);
  metrics.mean_abs = sums.mean(sums.sum_abs);
  metrics.rmse = std::sqrt(sums.mean(sums.sum_squares));
  metrics.max_abs = sums.most;
  metrics.mean_relative = sums.mean(sums.sum_relative);
  metrics.percent_within_1_cm = sums.percent(sums.within[0]);
  metrics.percent_within_5_cm = sums.percent(sums.within[1]);
  metrics.percent_within_1_percent = sums.percent(sums.within[2]);
  if (sums.most > 0.0) {
    metrics.max_x = static_cast<int>(sums.most_at % static_cast<std::size_t>(reference.width));
    metrics.max_y = static_cast<int>(sums.most_at / static_cast<std::size_t>(reference.width));
  }
  const auto value_at = [&](std::size_t pixel) {
    const Seen both = seen(pixel);
    if (!mask.at(pixel) || !both.reference || !both.test) return -1.0f;
    return std::fabs(static_cast<float>(difference(pixel)));
  };
  metrics.percentile_95 = percentile_95(reference.pixels(), value_at, sums.pixels);
  return metrics;
}

bool is_normal(const float* normal) {
  return std::isfinite(normal[0]) && std::isfinite(normal[1]) && std::isfinite(normal[2]) &&
         (normal[0] != 0.0f || normal[1] != 0.0f || normal[2] != 0.0f);
}

/// Degrees between two vectors: from sine and cosine, which keeps small angles exact.
double angle_between(const float* one, const float* other) {
  const double ax = one[0], ay = one[1], az = one[2], bx = other[0], by = other[1], bz = other[2];
  const double x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
  return angle_of(std::sqrt(x * x + y * y + z * z), ax * bx + ay * by + az * bz) * (180.0 / std::numbers::pi);
}

NormalMetrics compare_normals(const ComparedImage& reference, const ComparedImage& test,
                              const ImageMask& mask) {
  const auto normals = [&](std::size_t pixel) {
    return std::pair{reference.normals.data() + 3 * pixel, test.normals.data() + 3 * pixel};
  };
  const auto sums = over_rows<DifferenceSums>(reference.height, [&](int y, DifferenceSums& row) {
    for_counted(reference, mask, y, [&](std::size_t pixel) {
      const auto [from, to] = normals(pixel);
      if (!row.both({is_normal(from), is_normal(to)})) return;
      const double angle = angle_between(from, to);
      row.add(angle, pixel);
      row.within[0] += angle <= 5.0 ? 1 : 0;
    });
  });
  NormalMetrics metrics{
      .pixels = sums.pixels, .only_reference = sums.only_reference, .only_test = sums.only_test};
  metrics.mean = sums.mean(sums.sum);
  metrics.rms = std::sqrt(sums.mean(sums.sum_squares));
  metrics.max = sums.most;
  metrics.percent_within_5_degrees = sums.percent(sums.within[0]);
  if (sums.most > 0.0) {
    metrics.max_x = static_cast<int>(sums.most_at % static_cast<std::size_t>(reference.width));
    metrics.max_y = static_cast<int>(sums.most_at / static_cast<std::size_t>(reference.width));
  }
  const auto value_at = [&](std::size_t pixel) {
    const auto [from, to] = normals(pixel);
    if (!mask.at(pixel) || !is_normal(from) || !is_normal(to)) return -1.0f;
    return static_cast<float>(angle_between(from, to));
  };
  metrics.percentile_95 = percentile_95(reference.pixels(), value_at, sums.pixels);
  return metrics;
}

struct IdSums {
  std::uint64_t pixels = 0, equal = 0;
  void add(const IdSums& other) {
    pixels += other.pixels;
    equal += other.equal;
  }
};

IdMetrics compare_ids(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  const auto sums = over_rows<IdSums>(reference.height, [&](int y, IdSums& row) {
    for_counted(reference, mask, y, [&](std::size_t pixel) {
      if (reference.ids[pixel] == 0 && test.ids[pixel] == 0) return;
      ++row.pixels;
      row.equal += reference.ids[pixel] == test.ids[pixel] ? 1 : 0;
    });
  });
  IdMetrics metrics{.pixels = sums.pixels, .equal = sums.equal};
  if (sums.pixels > 0)
    metrics.percent_equal = 100.0 * static_cast<double>(sums.equal) / static_cast<double>(sums.pixels);
  return metrics;
}

}  // namespace

bool is_depth(float depth) {
  return std::isfinite(depth) && depth > 0.0f;
}

LayerMetrics layer_metrics(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  require_same_size(reference, test);
  LayerMetrics metrics;
  if (!reference.depth.empty() && !test.depth.empty()) metrics.depth = compare_depth(reference, test, mask);
  if (!reference.normals.empty() && !test.normals.empty())
    metrics.normals = compare_normals(reference, test, mask);
  if (!reference.ids.empty() && !test.ids.empty()) metrics.ids = compare_ids(reference, test, mask);
  return metrics;
}

}  // namespace alidade
