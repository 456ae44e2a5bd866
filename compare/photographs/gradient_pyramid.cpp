// SPDX-License-Identifier: MIT
#include "compare/photographs/gradient_pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

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

}  // namespace

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

}  // namespace alidade::compare
