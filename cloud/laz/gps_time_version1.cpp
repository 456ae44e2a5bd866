// SPDX-License-Identifier: MIT
#include "cloud/laz/gps_time_version1.h"

#include <algorithm>

namespace alidade {

void GpsTimeVersion1::start(const std::byte* first) {
  time_ = load<std::int64_t>(first);
  difference_ = 0;
  extremes_ = 0;
  first_.reset();
  multiple_.reset();
  integers_.reset();
}

unsigned GpsTimeVersion1::multiple_of(std::int32_t change) const {
  const std::int64_t quotient = std::int64_t{change} / difference_;
  return static_cast<unsigned>(std::clamp<std::int64_t>(quotient, 0, k_largest_multiple));
}

}  // namespace alidade
