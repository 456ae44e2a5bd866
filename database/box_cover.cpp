// SPDX-License-Identifier: MIT
#include "database/box_cover.h"

#include <limits>
#include <utility>

namespace alidade::database {
namespace {

/// Slices of the bounds before neighbours are joined.
constexpr int k_slices = 64;
/// Steps of the bisection that finds where along a box the condition begins to hold, to 1/1000 of the box.
constexpr int k_halvings = 10;
/// Two boxes are joined, however few there are, if their share of the bounds grows by no more than this part.
constexpr double k_free_growth = 0.05;

using MayHold = std::function<bool(const Bounds&)>;

/// Moves a face inwards over the part where the condition cannot hold. `side`: min or max of an axis.
void move_face(const MayHold& may_hold, Bounds& box, int axis, bool is_max) {
  double outside = is_max ? box.min[axis] : box.max[axis];
  for (int i = 0; i < k_halvings; ++i) {
    double& face = is_max ? box.max[axis] : box.min[axis];
    const double middle = face + 0.5 * (outside - face);
    if (middle == face || middle == outside) return;
    Bounds cut = box;
    (is_max ? cut.min : cut.max)[axis] = middle;
    if (may_hold(cut))
      outside = middle;
    else
      face = middle;
  }
}

void shrink(const MayHold& may_hold, Bounds& box) {
  for (int axis = 0; axis < 3; ++axis) {
    move_face(may_hold, box, axis, false);
    move_face(may_hold, box, axis, true);
  }
}

/// Joins neighbours, those first whose join grows least, until there are `count` boxes, and then while joins
/// hardly grow.
void join_neighbours(std::vector<Bounds>& boxes, const Bounds& bounds, std::size_t count) {
  while (boxes.size() > 1) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity(), apart = 0.0;
    for (std::size_t i = 0; i + 1 < boxes.size(); ++i) {
      const double sum = volume_share(boxes[i], bounds) + volume_share(boxes[i + 1], bounds);
      const double growth = volume_share(joined(boxes[i], boxes[i + 1]), bounds) - sum;
      if (growth < least) {
        least = growth;
        apart = sum;
        best = i;
      }
    }
    if (boxes.size() <= count && least > k_free_growth * apart) return;
    boxes[best].grow(boxes[best + 1]);
    boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(best) + 1);
  }
}

std::vector<Bounds> slices(const MayHold& may_hold, const Bounds& bounds, int axis) {
  std::vector<Bounds> boxes;
  const double least = bounds.min[axis], size = bounds.max[axis] - least;
  for (int i = 0; i < k_slices; ++i) {
    Bounds box = bounds;
    box.min[axis] = least + size * (static_cast<double>(i) / k_slices);
    if (i + 1 < k_slices) box.max[axis] = least + size * (static_cast<double>(i + 1) / k_slices);
    if (!may_hold(box)) continue;
    shrink(may_hold, box);
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace

double volume_share(const Bounds& box, const Bounds& bounds) {
  double product = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = bounds.max[axis] - bounds.min[axis];
    if (size > 0.0) product *= (box.max[axis] - box.min[axis]) / size;
  }
  return product;
}

BoxCover cover(const MayHold& may_hold, const Bounds& bounds, std::size_t count) {
  BoxCover best;
  double least = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Bounds> boxes = slices(may_hold, bounds, axis);
    join_neighbours(boxes, bounds, count);
    double sum = 0.0;
    for (const Bounds& box : boxes) sum += volume_share(box, bounds);
    // Of covers of about the same size, the one with fewer boxes.
    if (sum * (1.0 + k_free_growth) < least ||
        (sum < least * (1.0 + k_free_growth) && boxes.size() < best.boxes.size())) {
      least = sum;
      best = {axis, std::move(boxes)};
    }
  }
  return best;
}

}  // namespace alidade::database
