// SPDX-License-Identifier: MIT
#include "image/round_ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alidade {
namespace {

/// mantissa * 10^exponent, both whole.
struct Step {
  int mantissa = 1;
  int exponent = 0;

  /// `count` of them. Dividing by a power of ten gives the double nearest to the decimal, multiplying by a
  /// negative one would not.
  double times(double count) const {
    const double power = std::pow(10.0, std::abs(exponent));
    return exponent < 0 ? count * mantissa / power : count * mantissa * power;
  }
  Step next() const {
    if (mantissa == 1) return {2, exponent};
    return mantissa == 2 ? Step{5, exponent} : Step{1, exponent + 1};
  }
};

std::string label_of(double value, const Step& step) {
  constexpr int k_most_decimals = 6, k_most_digits = 17;
  constexpr double k_longest = 1e12;
  const double plain_value = value + 0.0;  // no negative zero
  if (-step.exponent <= k_most_decimals && std::fabs(value) < k_longest)
    return fmt::format("{:.{}f}", plain_value, std::max(0, -step.exponent));
  const int first_digit = value == 0.0 ? 0 : static_cast<int>(std::floor(std::log10(std::fabs(value))));
  return fmt::format("{:.{}g}", plain_value, std::clamp(first_digit - step.exponent + 1, 1, k_most_digits));
}

}  // namespace

std::vector<RoundTick> round_ticks(const ValueRange& range, int most) {
  assert(range.low <= range.high && most >= 2);
  const double extent = range.high - range.low;
  const double largest = std::max(std::fabs(range.low), std::fabs(range.high));
  constexpr double k_narrowest = 1e-12, k_smallest = 1e-290;
  std::vector<RoundTick> ticks;
  if (extent <= std::max(k_narrowest * largest, k_smallest)) {
    ticks.push_back({range.low, fmt::format("{:g}", range.low)});
    if (extent > 0.0) ticks.push_back({range.high, fmt::format("{:g}", range.high)});
    return ticks;
  }
  // A little room for the rounding of ends that are multiples themselves.
  const double slack = 1e-9 * extent;
  Step step{1, static_cast<int>(std::floor(std::log10(extent / most))) - 1};
  for (;; step = step.next()) {
    const double first = std::ceil((range.low - slack) / step.times(1.0)),
                 last = std::floor((range.high + slack) / step.times(1.0));
    if (last - first + 1.0 > most) continue;
    for (double count = first; count <= last; ++count) {
      const double value = std::clamp(step.times(count), range.low, range.high);
      ticks.push_back({value, label_of(step.times(count), step)});
    }
    return ticks;
  }
}

}  // namespace alidade
