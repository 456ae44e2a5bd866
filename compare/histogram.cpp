// SPDX-License-Identifier: MIT
#include "compare/histogram.h"

#include <algorithm>
#include <cmath>

namespace alidade {

Histogram count_values(std::string name, std::span<const float> values, const ImageMask& mask, double low,
                       double high, std::size_t bins) {
  Histogram histogram{std::move(name), std::vector<std::uint64_t>(bins)};
  const double last = static_cast<double>(bins - 1), scale = static_cast<double>(bins) / (high - low);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!mask.at(i) || !std::isfinite(values[i])) continue;
    const double bin = std::clamp((values[i] - low) * scale, 0.0, last);
    ++histogram.bins[static_cast<std::size_t>(bin)];
  }
  return histogram;
}

}  // namespace alidade
