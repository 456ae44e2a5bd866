// SPDX-License-Identifier: MIT
#include "surface/local_plane.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "surface/simd/moments.h"

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

/// Eigenvalues of a symmetric matrix, the least first, and the vector of that one.
struct Eigen {
  glm::dvec3 values{0.0};
  glm::dvec3 thin{0.0, 0.0, 1.0};  ///< of any length but 0
};

/// Turns a symmetric matrix in the plane of axes p and q so that a[p][q] vanishes, and the vectors with it.
/// False if it is too small to show in the normal. Both halves of the matrix are kept, since their last bits
/// differ.
template <int p, int q>
bool rotate(glm::dmat3& a, glm::dmat3& vectors) {
  constexpr int r = 3 - p - q;
  // So small that no further rotation shows in the normal.
  if (a[p][q] * a[p][q] <= 1e-24 * std::fabs(a[p][p] * a[q][q])) return false;
  const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
  if (!std::isfinite(theta)) return false;
  const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
  const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
  const double pp = c * a[p][p] - s * a[p][q], pq = s * a[p][p] + c * a[p][q];
  const double qp = c * a[q][p] - s * a[q][q], qq = s * a[q][p] + c * a[q][q];
  a[p][p] = c * pp - s * qp;
  a[q][p] = s * pp + c * qp;
  a[p][q] = c * pq - s * qq;
  a[q][q] = s * pq + c * qq;
  const double rp = a[r][p], rq = a[r][q], pr = a[p][r], qr = a[q][r];
  a[r][p] = c * rp - s * rq;
  a[r][q] = s * rp + c * rq;
  a[p][r] = c * pr - s * qr;
  a[q][r] = s * pr + c * qr;
  const glm::dvec3 column = vectors[p];
  vectors[p] = c * column - s * vectors[q];
  vectors[q] = s * column + c * vectors[q];
  return true;
}

/// Source: Jacobi's method, Golub and Van Loan, section 8.5.
Eigen eigen_by_rotations(glm::dmat3 a) {
  constexpr int k_most_sweeps = 8;
  glm::dmat3 vectors(1.0);
  for (int sweep = 0; sweep < k_most_sweeps; ++sweep) {
    const bool first = rotate<0, 1>(a, vectors);
    const bool second = rotate<0, 2>(a, vectors);
    const bool third = rotate<1, 2>(a, vectors);
    if (!first && !second && !third) break;
  }
  int thin = 0, wide = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (a[axis][axis] < a[thin][thin]) thin = axis;
    if (a[axis][axis] >= a[wide][wide]) wide = axis;
  }
  const int middle = thin == wide ? wide : 3 - thin - wide;
  return {{a[thin][thin], a[middle][middle], a[wide][wide]}, vectors[thin]};
}

/// Of a covariance: the least root of its characteristic polynomial by Newton's method from 0, the others by
/// their sum and product, and the vector across two columns. Less than half of the time of rotations, which
/// take over where the two lesser values are nearly equal.
Eigen eigen(const glm::dmat3& a) {
  constexpr int k_most_steps = 12;
  // Of the trace, after which another step would be 1e-13 of it or less; of the greatest value.
  constexpr double k_end = 1e-9, k_least_gap = 1e-4;
  const double xy = a[0][0] * a[1][1] - a[0][1] * a[0][1], xz = a[0][0] * a[2][2] - a[0][2] * a[0][2],
               yz = a[1][1] * a[2][2] - a[1][2] * a[1][2];
  const double trace = a[0][0] + a[1][1] + a[2][2], minors = xy + xz + yz;
  const double determinant = a[0][0] * yz - a[0][1] * (a[0][1] * a[2][2] - a[0][2] * a[1][2]) +
                             a[0][2] * (a[0][1] * a[1][2] - a[0][2] * a[1][1]);
  double least = 0.0;
  bool has_ended = false;
  for (int i = 0; i < k_most_steps && !has_ended; ++i) {
    const double slope = (3.0 * least - 2.0 * trace) * least + minors;
    const double step = (((least - trace) * least + minors) * least - determinant) / slope;
    least -= step;
    has_ended = std::fabs(step) <= k_end * trace;
  }
  const double sum = trace - least, product = minors - least * sum;
  const double greatest = 0.5 * sum + std::sqrt(std::max(0.25 * sum * sum - product, 0.0));
  const double middle = product / greatest;
  // Of a row of points the steps may lead to the greatest root.
  if (!has_ended || !(middle <= greatest && middle - least > k_least_gap * greatest))
    return eigen_by_rotations(a);
  const glm::dvec3 first = a[0] - glm::dvec3(least, 0.0, 0.0), second = a[1] - glm::dvec3(0.0, least, 0.0),
                   third = a[2] - glm::dvec3(0.0, 0.0, least);
  Eigen found{{least, middle, greatest}, glm::cross(first, second)};
  for (const glm::dvec3& across : {glm::cross(second, third), glm::cross(third, first)})
    if (glm::dot(across, across) > glm::dot(found.thin, found.thin)) found.thin = across;
  return found;
}

/// Lengths in units of the reach.
LocalPlane fit_plane(const simd::Moments& moments) {
  constexpr double k_fewest_points = 4.0, k_enough_points = 9.0;
  // A surface is much thinner than it is wide, both ways; beyond these ratios of variances there is none.
  constexpr double k_flat = 0.06, k_thick = 0.35;
  if (moments.count < k_fewest_points || !(moments.weight > 0.0f)) return {};
  const glm::dvec3 mean = mean_of(moments);
  const Eigen found = eigen(covariance(moments, mean));
  const double variance = std::max(0.0, found.values[0]), width = found.values[1];
  if (!(width > 0.0)) return {};
  const double ratio = variance / width;
  const double flatness = std::clamp((k_thick - ratio) / (k_thick - k_flat), 0.0, 1.0);
  const double support =
      std::min(1.0, (moments.count - k_fewest_points + 1.0) / (k_enough_points - k_fewest_points + 1.0));
  // A row of points is flat in any direction across it, and so is a cluster that is small beside the reach
  // with a few points far away. Those all over a disc have a variance of 1/8 each way.
  constexpr double k_least_share = 0.1, k_least_width = 0.02;
  const double breadth = std::min(1.0, width / std::max(k_least_share * found.values[2], k_least_width));
  const glm::dvec3 normal = glm::normalize(found.thin);
  const double height = -glm::dot(mean, normal);
  return {normal,
          flatness * support * breadth,
          height,
          std::sqrt(variance),
          glm::length(mean + height * normal),
          moments.count};
}

}  // namespace

LocalPlane plane_of(const simd::Moments& moments, double reach) {
  LocalPlane plane = fit_plane(moments);
  plane.height *= reach;
  plane.thickness *= reach;
  plane.off_center *= reach;
  return plane;
}

LocalPlane local_plane(const Octree& octree, const glm::dvec3& position, double reach) {
  const simd::LocalSums& sums = simd::local_sums(octree.instruction_set());
  simd::BallPoints points;
  sums.gather(octree.view(), {position, reach}, points);
  return plane_of(sums.moments(points), reach);
}

}  // namespace alidade
