// SPDX-License-Identifier: MIT
#include "database/morton_order.h"

#include "octree/building/sorted_points.h"

namespace alidade {
namespace {

template <class Entry>
std::vector<std::uint32_t> order_of(const SortedPoints<Entry>& sorted) {
  std::vector<std::uint32_t> order(sorted.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = sorted[i].id;
  return order;
}

}  // namespace

std::vector<std::uint32_t> morton_order(const std::vector<LatticePosition>& positions) {
  if (positions.empty()) return {};
  const KeySpace space = aligned_key_space(positions);
  return space.is_narrow() ? order_of(sort_points<NarrowEntry>(space, positions))
                           : order_of(sort_points<WideEntry>(space, positions));
}

}  // namespace alidade
