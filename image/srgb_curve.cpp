// SPDX-License-Identifier: MIT
#include "image/srgb.h"

#include <algorithm>

#include "base/exact_math.h"

namespace alidade {

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

}  // namespace alidade
