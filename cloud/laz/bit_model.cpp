// SPDX-License-Identifier: MIT
#include "cloud/laz/bit_model.h"

#include <algorithm>

namespace alidade {

void BitModel::adapt() {
  total += cycle;
  if (total > 1u << k_precision) {
    total = (total + 1) >> 1;
    zeros = (zeros + 1) >> 1;
    if (zeros == total) ++total;
  }
  probability = (zeros * ((1u << 31) / total)) >> (31 - k_precision);
  cycle = std::min((5 * cycle) >> 2, 64u);
  left = cycle;
}

}  // namespace alidade
