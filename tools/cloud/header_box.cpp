// SPDX-License-Identifier: MIT
#include "tools/cloud/describe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace alidade {

std::optional<std::string> header_box_text(const Bounds& stated, const Bounds& points,
                                           const Lattice& lattice) {
  if (points.empty()) return std::nullopt;
  double wider = 0.0, left_out = 0.0, finest = lattice.scale.x;
  for (int axis = 0; axis < 3; ++axis) {
    finest = std::min(finest, lattice.scale[axis]);
    for (const double beyond : {points.min[axis] - stated.min[axis], stated.max[axis] - points.max[axis]}) {
      if (std::fabs(beyond) <= 0.01 * lattice.scale[axis]) continue;
      wider = std::max(wider, beyond);
      left_out = std::max(left_out, -beyond);
    }
  }
  if (wider == 0.0 && left_out == 0.0) return std::nullopt;
  const int decimals = static_cast<int>(std::clamp(std::ceil(-std::log10(finest) - 1e-9) + 1.0, 0.0, 17.0));
  std::string text;
  if (wider > 0.0) text = fmt::format("up to {:.{}f} wider than the points", wider, decimals);
  if (left_out > 0.0)
    text += fmt::format("{}leaves out points by up to {:.{}f}", text.empty() ? "" : "; ", left_out, decimals);
  return text;
}

Bounds bounds_of_rows(const PointCloud& cloud, std::size_t begin, std::size_t end) {
  Bounds bounds;
  for (std::size_t row = begin; row < std::min(end, cloud.size()); ++row) bounds.grow(cloud.world(row));
  return bounds;
}

}  // namespace alidade
