// SPDX-License-Identifier: MIT
#include "renderer/smooth_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "octree/tree_walk.h"

namespace alidade {
namespace {

/// Sums over weighted points, relative to the middle of the neighbourhood.
struct Moments {
  double weight = 0.0;
  double count = 0.0;
  glm::dvec3 first{0.0};
  std::array<double, 6> second{};  ///< xx xy xz yy yz zz

  void add(const glm::dvec3& p, double w, double points) {
    weight += w;
    count += points;
    first += w * p;
    const double products[6] = {p.x * p.x, p.x * p.y, p.x * p.z, p.y * p.y, p.y * p.z, p.z * p.z};
    for (int i = 0; i < 6; ++i) second[i] += w * products[i];
  }

  glm::dmat3 covariance() const {
    const glm::dvec3 mean = first / weight;
    const double xx = second[0] / weight - mean.x * mean.x, xy = second[1] / weight - mean.x * mean.y;
    const double xz = second[2] / weight - mean.x * mean.z, yy = second[3] / weight - mean.y * mean.y;
    const double yz = second[4] / weight - mean.y * mean.z, zz = second[5] / weight - mean.z * mean.z;
    return {xx, xy, xz, xy, yy, yz, xz, yz, zz};
  }
};

double distance_sq(const glm::dvec3& point, const Bounds& box) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double outside = std::max({box.min[axis] - point[axis], 0.0, point[axis] - box.max[axis]});
    sum += outside * outside;
  }
  return sum;
}

void add_leaf(const TreeView& tree, const Leaf& leaf, const Bounds& box, const glm::dvec3& middle,
              double reach, Moments& moments) {
  // Where points stand much closer than the neighbourhood is wide, a few speak for all of their leaf.
  const bool is_dense = glm::length(box.size()) < 0.3 * reach;
  const std::uint32_t stride = is_dense ? std::max<std::uint32_t>(1, leaf.count / 4) : 1;
  for (std::uint32_t i = 0; i < leaf.count; i += stride) {
    const glm::dvec3 offset = to_world(tree.lattice, position_of(tree, leaf, i)) - middle;
    const double closeness = 1.0 - glm::dot(offset, offset) / (reach * reach);
    if (closeness > 0.0) moments.add(offset, closeness * closeness * stride, stride);
  }
}

Moments neighbourhood(const TreeView& tree, const glm::dvec3& middle, double reach) {
  Moments moments;
  std::array<Frame, k_max_tree_depth * k_node_width> stack;
  std::size_t depth = 0;
  stack[depth++] = root_frame(tree);
  while (depth > 0) {
    const Frame frame = stack[--depth];
    for (int slot = 0; slot < k_node_width; ++slot) {
      const std::uint8_t kind = tree.nodes[frame.node].kind[slot];
      if (kind == 0) continue;
      const Bounds box = child_bounds(tree, frame, slot);
      if (distance_sq(middle, box) >= reach * reach) continue;
      if (is_inner(kind)) {
        stack[depth++] = child_frame(tree, frame, slot);
      } else {
        add_leaf(tree, child_leaf(tree, frame, slot), box, middle, reach, moments);
      }
    }
  }
  return moments;
}

/// Eigenvalues of a symmetric matrix, with their vectors as columns. Source: Jacobi's method, Golub and Van
/// Loan, section 8.5.
struct Eigen {
  glm::dvec3 values;
  glm::dmat3 vectors{1.0};
};

Eigen eigen(glm::dmat3 a) {
  Eigen result;
  for (int sweep = 0; sweep < 8; ++sweep) {
    for (const auto& [p, q] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
      if (a[p][q] == 0.0) continue;
      const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
      if (!std::isfinite(theta)) continue;
      const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
      const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
      for (int k = 0; k < 3; ++k) {
        const double kp = a[k][p], kq = a[k][q];
        a[k][p] = c * kp - s * kq;
        a[k][q] = s * kp + c * kq;
      }
      for (int k = 0; k < 3; ++k) {
        const double pk = a[p][k], qk = a[q][k];
        a[p][k] = c * pk - s * qk;
        a[q][k] = s * pk + c * qk;
      }
      const glm::dvec3 column = result.vectors[p];
      result.vectors[p] = c * column - s * result.vectors[q];
      result.vectors[q] = s * column + c * result.vectors[q];
    }
  }
  result.values = {a[0][0], a[1][1], a[2][2]};
  return result;
}

SmoothNormal fit_plane(const Moments& moments) {
  constexpr double k_fewest_points = 4.0, k_enough_points = 9.0;
  // A surface is much thinner than it is wide, both ways; beyond these ratios of variances there is none.
  constexpr double k_flat = 0.06, k_thick = 0.35;
  if (moments.count < k_fewest_points) return {};
  const Eigen found = eigen(moments.covariance());
  int thin = 0, wide = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (found.values[axis] < found.values[thin]) thin = axis;
    if (found.values[axis] >= found.values[wide]) wide = axis;
  }
  if (thin == wide) return {};
  const double width = found.values[3 - thin - wide];
  if (!(width > 0.0)) return {};
  const double ratio = std::max(0.0, found.values[thin]) / width;
  const double flatness = std::clamp((k_thick - ratio) / (k_thick - k_flat), 0.0, 1.0);
  const double support =
      std::min(1.0, (moments.count - k_fewest_points + 1.0) / (k_enough_points - k_fewest_points + 1.0));
  // A row of points is flat in any direction across it.
  const double breadth = std::min(1.0, width / (0.1 * found.values[wide]));
  return {glm::normalize(found.vectors[thin]), flatness * support * breadth};
}

// 32 bits: one that says "known", 7 for trust, 12 + 12 for the normal on the octahedron
// (Cigolle et al., A Survey of Efficient Representations for Independent Unit Vectors, JCGT 2014).
constexpr double k_trust_steps = 127.0, k_side_steps = 4094.0;  // even, so that upright stays upright

std::uint32_t pack(const SmoothNormal& value) {
  const glm::dvec3 n =
      value.normal / (std::fabs(value.normal.x) + std::fabs(value.normal.y) + std::fabs(value.normal.z));
  // The side is free, so the upper half is enough: its square turned by 45 degrees fills the whole range.
  const double sign = n.z < 0.0 ? -1.0 : 1.0;
  const double u = sign * (n.x + n.y), v = sign * (n.x - n.y);
  const auto steps = [](double place) {
    return static_cast<std::uint32_t>((0.5 + 0.5 * place) * k_side_steps + 0.5);
  };
  return 0x80000000u | static_cast<std::uint32_t>(value.trust * k_trust_steps + 0.5) << 24 | steps(u) << 12 |
         steps(v);
}

SmoothNormal unpack(std::uint32_t packed) {
  const double u = (packed >> 12 & 0xfffu) / k_side_steps * 2.0 - 1.0,
               v = (packed & 0xfffu) / k_side_steps * 2.0 - 1.0;
  const double x = 0.5 * (u + v), y = 0.5 * (u - v);
  return {glm::normalize(glm::dvec3(x, y, 1.0 - std::fabs(x) - std::fabs(y))),
          (packed >> 24 & 0x7fu) / k_trust_steps};
}

}  // namespace

SmoothNormals::SmoothNormals(const Octree& octree) : octree_(&octree), kept_(octree.size()) {}

SmoothNormal SmoothNormals::at(std::uint64_t point_id, const glm::dvec3& position, double reach) const {
  std::atomic<std::uint32_t>& kept = kept_[point_id];
  std::uint32_t packed = kept.load(std::memory_order_relaxed);
  if (packed == 0) {
    // Two threads may both do this; they get the same.
    packed = pack(fit_plane(neighbourhood(octree_->view(), position, reach)));
    kept.store(packed, std::memory_order_relaxed);
  }
  return unpack(packed);
}

}  // namespace alidade
