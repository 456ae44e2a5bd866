// SPDX-License-Identifier: MIT
#include "octree/local_plane.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "octree/simd/moments.h"

namespace alidade {
namespace {

glm::dvec3 mean_of(const simd::Moments& moments) {
  return glm::dvec3(moments.first[0], moments.first[1], moments.first[2]) /
         static_cast<double>(moments.weight);
}

glm::dmat3 covariance(const simd::Moments& moments, const glm::dvec3& mean) {
  const double weight = moments.weight;
  const auto& second = moments.second;
  const double xx = second[0] / weight - mean.x * mean.x, xy = second[1] / weight - mean.x * mean.y;
  const double xz = second[2] / weight - mean.x * mean.z, yy = second[3] / weight - mean.y * mean.y;
  const double yz = second[4] / weight - mean.y * mean.z, zz = second[5] / weight - mean.z * mean.z;
  return {xx, xy, xz, xy, yy, yz, xz, yz, zz};
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
      // So small that no further rotation shows in the normal.
      if (a[p][q] * a[p][q] <= 1e-24 * std::fabs(a[p][p] * a[q][q])) continue;
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

/// Lengths in units of the reach.
LocalPlane fit_plane(const simd::Moments& moments) {
  constexpr double k_fewest_points = 4.0, k_enough_points = 9.0;
  // A surface is much thinner than it is wide, both ways; beyond these ratios of variances there is none.
  constexpr double k_flat = 0.06, k_thick = 0.35;
  if (moments.count < k_fewest_points || !(moments.weight > 0.0f)) return {};
  const glm::dvec3 mean = mean_of(moments);
  const Eigen found = eigen(covariance(moments, mean));
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
  const glm::dvec3 normal = glm::normalize(found.vectors[thin]);
  const double height = -glm::dot(mean, normal);
  return {normal, flatness * support * breadth, height, std::sqrt(std::max(0.0, found.values[thin])),
          glm::length(mean + height * normal)};
}

LocalPlane fit_plane(const simd::Moments& moments, double reach) {
  LocalPlane plane = fit_plane(moments);
  plane.height *= reach;
  plane.thickness *= reach;
  plane.off_center *= reach;
  return plane;
}

}  // namespace

LocalPlane local_plane(const Octree& octree, const glm::dvec3& position, double reach) {
  return fit_plane(simd::moment_sums(octree.instruction_set()).around(octree.view(), position, reach), reach);
}

LocalPlane local_plane(std::span<const glm::dvec3> offsets, double reach) {
  simd::Moments moments;
  for (const glm::dvec3& offset : offsets) {
    const glm::vec3 p(offset / reach);
    const float closeness = 1.0f - (p.x * p.x + p.y * p.y + p.z * p.z);
    if (!(closeness > 0.0f)) continue;
    const float weight = closeness * closeness;
    moments.weight += weight;
    moments.count += 1.0f;
    const float squares[6] = {p.x * p.x, p.x * p.y, p.x * p.z, p.y * p.y, p.y * p.z, p.z * p.z};
    for (int axis = 0; axis < 3; ++axis) moments.first[axis] += weight * p[axis];
    for (int i = 0; i < 6; ++i) moments.second[i] += weight * squares[i];
  }
  return fit_plane(moments, reach);
}

}  // namespace alidade
