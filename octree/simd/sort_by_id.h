// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "octree/hit.h"

namespace alidade::simd {

/// Brings the answers from number `first` on into the order of their ids and keeps the k lowest.
inline void sort_by_id(std::vector<PointHit>& answers, std::size_t first, std::size_t k) {
  const auto before = [](const PointHit& a, const PointHit& b) { return a.point_id < b.point_id; };
  const auto begin = answers.begin() + static_cast<std::ptrdiff_t>(first);
  if (answers.size() - first > k) {
    std::nth_element(begin, begin + static_cast<std::ptrdiff_t>(k), answers.end(), before);
    answers.resize(first + k);
  }
  if (!std::is_sorted(begin, answers.end(), before)) std::sort(begin, answers.end(), before);
}

}  // namespace alidade::simd
