// SPDX-License-Identifier: MIT
#include "image/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/color.h"

namespace alidade::image {
namespace {

// Entry k: the linear value half-way (in the encoded sense) between the codes k and k + 1.
std::array<double, 255> code_thresholds() {
  std::array<double, 255> thresholds{};
  for (int k = 0; k < 255; ++k) thresholds[static_cast<std::size_t>(k)] = linear_from_srgb((k + 0.5) / 255.0);
  return thresholds;
}

}  // namespace

double exposure_scale(double stops) {
  const double whole = std::floor(stops);
  double fraction = stops - whole;
  double scale = 1.0;
  // The binary digits of the fraction choose among sqrt(2), sqrt(sqrt(2)), ...; sqrt is exactly rounded
  // everywhere.
  for (double factor = std::sqrt(2.0); fraction > 0.0 && factor > 1.0; factor = std::sqrt(factor)) {
    fraction *= 2.0;
    if (fraction >= 1.0) {
      fraction -= 1.0;
      scale *= factor;
    }
  }
  return std::ldexp(scale, static_cast<int>(whole));
}

std::uint8_t srgb_code(double linear) {
  static const std::array<double, 255> thresholds = code_thresholds();
  if (!(linear > 0.0)) return 0;
  return static_cast<std::uint8_t>(std::ranges::upper_bound(thresholds, linear) - thresholds.begin());
}

CurveTable::CurveTable(double (*curve)(double)) : values_(65537) {
  // The last entry is only there so that the value 1 has a neighbour.
  for (std::size_t step = 0; step < values_.size(); ++step)
    values_[step] = static_cast<float>(curve(std::min(static_cast<double>(step) / 65535.0, 1.0)));
}

const CurveTable& linear_from_srgb_table() {
  static const CurveTable table(linear_from_srgb);
  return table;
}

const CurveTable& srgb_from_linear_table() {
  static const CurveTable table(srgb_from_linear);
  return table;
}

}  // namespace alidade::image
