// SPDX-License-Identifier: MIT
#include "cloud/lattice.h"

#include <fmt/format.h>
#include <array>
#include <limits>
#include <utility>

#include "base/error.h"

namespace alidade {
namespace {

constexpr double k_largest_step = 2147483647.0;
constexpr int k_finest_exponent = -300;  ///< 1e-300: finer steps would meet the smallest doubles
constexpr int k_default_exponent = -3;   ///< where the data ask for nothing

/// 10^exponent, correctly rounded for the exponents that matter, so that 1e-3 is the double every file says.
double power_of_ten(int exponent) {
  double power = 1.0;
  if (std::abs(exponent) > 22) return std::pow(10.0, exponent);
  for (int i = 0; i < std::abs(exponent); ++i) power *= 10.0;
  return exponent < 0 ? 1.0 / power : power;
}

/// Exponent of the finest scale at which `reach` is within 32 bits.
int finest_exponent(double reach) {
  if (reach == 0.0) return k_finest_exponent;
  // A subnormal reach would make the step zero, which has no logarithm.
  const double step = std::max(reach / k_largest_step, std::numeric_limits<double>::min());
  int exponent = std::max(static_cast<int>(std::floor(std::log10(step))), k_finest_exponent);
  while (reach / power_of_ten(exponent) > k_largest_step - 1) ++exponent;
  return exponent;
}

}  // namespace

Lattice fit_lattice(std::span<const CoordinateSurvey> surveys) {
  Bounds bounds;
  for (const CoordinateSurvey& survey : surveys) bounds.grow(survey.bounds);
  if (bounds.empty()) return {};

  Lattice lattice;
  std::array<int, 3> finest{}, wanted{};
  for (int axis = 0; axis < 3; ++axis) {
    lattice.offset[axis] = std::nearbyint(0.5 * bounds.min[axis] + 0.5 * bounds.max[axis]);
    const double offset = lattice.offset[axis];
    const double reach = std::max(bounds.max[axis] - offset, offset - bounds.min[axis]);
    if (!(reach <= 1e300 && std::abs(offset) <= 1e300)) {
      throw Error({.problem = "coordinates too large",
                   .expected = "at most 1e300",
                   .found = fmt::format("{}", std::max(reach, std::abs(offset)))});
    }
    double resolution = std::numeric_limits<double>::infinity();
    for (const CoordinateSurvey& survey : surveys) {
      if (survey.finite_count > 0) resolution = std::min(resolution, survey.resolution[axis]);
    }
    finest[axis] = finest_exponent(reach);
    wanted[axis] = finest[axis];
    if (resolution > 0 && std::isfinite(resolution)) {
      // Rounding costs half a step. The tiny addition keeps log10 of an exact power from falling below it.
      wanted[axis] =
          std::max(wanted[axis], static_cast<int>(std::floor(std::log10(2.0 * resolution) + 1e-9)));
    }
    if (wanted[axis] == k_finest_exponent) wanted[axis] = k_default_exponent;
  }
  // Steps of one length make cubes of the octree's nodes: boxes a million times longer than wide prune nothing.
  const int common = *std::min_element(wanted.begin(), wanted.end());
  for (int axis = 0; axis < 3; ++axis) lattice.scale[axis] = power_of_ten(std::max(common, finest[axis]));
  return lattice;
}

std::optional<int> decimals_of(const Lattice& lattice, int axis) {
  constexpr int k_most = 15;
  // All steps together must not add up to more than a thousandth.
  constexpr double k_share = 1e-3 / 4294967296.0;
  double unit = 1.0;
  for (int decimals = 0; decimals <= k_most; ++decimals, unit /= 10.0) {
    const double steps = lattice.scale[axis] / unit, offset = lattice.offset[axis] / unit;
    const double rest = std::fabs(offset - std::round(offset)) * unit;
    if (steps >= 1.0 - k_share && std::fabs(steps - std::round(steps)) <= k_share * steps &&
        rest <= 1e-3 * lattice.scale[axis])
      return decimals;
  }
  return std::nullopt;
}

std::optional<glm::i64vec3> steps_between(const Lattice& from, const Lattice& to) {
  if (from.scale != to.scale) return std::nullopt;
  glm::i64vec3 steps;
  for (int axis = 0; axis < 3; ++axis) {
    const double exact = (from.offset[axis] - to.offset[axis]) / to.scale[axis];
    const double whole = std::nearbyint(exact);
    const double larger = std::max(std::abs(from.offset[axis]), std::abs(to.offset[axis]));
    const double next = std::nextafter(larger, std::numeric_limits<double>::infinity());
    const double tolerance = std::max(1e-5, 2.0 * (next - larger) / to.scale[axis]);
    // Beyond 2^33 steps no position fits both lattices.
    if (!(std::abs(whole) <= 8589934592.0 && std::abs(exact - whole) <= tolerance)) return std::nullopt;
    steps[axis] = static_cast<std::int64_t>(whole);
  }
  return steps;
}

LatticeShift::LatticeShift(const Lattice& from, const Lattice& to, std::string file)
    : file_(std::move(file)) {
  const std::optional<glm::i64vec3> steps = steps_between(from, to);
  if (!steps) throw Error({.file = file_, .problem = "the lattice differs from that of the previous files"});
  steps_ = *steps;
}

void LatticeShift::reject(const glm::i64vec3& steps) const {
  throw Error({.file = file_,
               .problem = "too far from the first file for its lattice of 32-bit steps",
               .found = fmt::format("step {}, {}, {}", steps.x, steps.y, steps.z)});
}

}  // namespace alidade
