// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "compare/image_mask.h"

namespace alidade {

/// How often values are met: equal steps from `low` to `high`, values outside of them in the first and last.
struct Histogram {
  std::string name;
  std::vector<std::uint64_t> bins;
};

/// Histograms that are drawn into one picture.
struct HistogramPicture {
  std::string title, unit;
  double low = 0.0, high = 1.0;
  Histogram first;
  std::optional<Histogram> second{};
};

/// Counts values of pixels that count, in one pass, without NaN and infinity. Requires low < high, bins >= 1.
Histogram count_values(std::string name, std::span<const float> values, const ImageMask& mask, double low,
                       double high, std::size_t bins = 64);

}  // namespace alidade
