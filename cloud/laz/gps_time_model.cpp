// SPDX-License-Identifier: MIT
#include "cloud/laz/shared_models.h"

#include <algorithm>
#include <cmath>

namespace alidade {

GpsTimeModel::GpsTimeModel(Unchanged unchanged)
    : unchanged_(unchanged),
      without_difference_(5 + static_cast<int>(unchanged)),
      with_difference_(515 + static_cast<int>(unchanged)) {}

void GpsTimeModel::start(std::int64_t first) {
  without_difference_.reset();
  with_difference_.reset();
  integers_.reset();
  sequences_.fill({});
  sequences_[0].time = first;
  current_ = newest_ = 0;
}

unsigned GpsTimeModel::symbol_of(std::int32_t change, std::int32_t difference) {
  // Single precision, as in all writers: another quotient would decode to the same times but give other
  // bytes.
  const float quotient = std::round(static_cast<float>(change) / static_cast<float>(difference));
  const int factor = static_cast<int>(std::clamp(quotient, -10.0f, 500.0f));
  return static_cast<unsigned>(factor >= 0 ? factor : 500 - factor);
}

}  // namespace alidade
