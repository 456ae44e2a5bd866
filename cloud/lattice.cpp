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
constexpr int k_finest_exponent = -300;  ///< 1e-300: finer steps would reach the smallest doubles
constexpr int k_default_exponent = -3;   ///< of axes without extent

/// 10^exponent, correctly rounded for usual exponents, so that 1e-3 is the double of LAS files.
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

/// LatticeSteps along one axis.
struct AxisSteps {
  std::int64_t factor, shift;
};

std::optional<AxisSteps> axis_steps(double from_scale, double from_offset, double to_scale,
                                    double to_offset) {
  // Beyond 2^33 steps no position fits both lattices.
  constexpr double k_most_steps = 8589934592.0, k_tolerance = 1e-5;
  const double ratio = from_scale / to_scale, factor = std::nearbyint(ratio);
  if (!(factor >= 1.0 && factor <= k_largest_step &&
        std::abs(ratio / factor - 1.0) * k_largest_step <= k_tolerance))
    return std::nullopt;
  const double exact = (from_offset - to_offset) / to_scale, whole = std::nearbyint(exact);
  const double larger = std::max(std::abs(from_offset), std::abs(to_offset));
  const double next = std::nextafter(larger, std::numeric_limits<double>::infinity());
  const double tolerance = std::max(k_tolerance, 2.0 * (next - larger) / to_scale);
  if (!(std::abs(whole) <= k_most_steps && std::abs(exact - whole) <= tolerance)) return std::nullopt;
  return AxisSteps{static_cast<std::int64_t>(factor), static_cast<std::int64_t>(whole)};
}

}  // namespace

Lattice fit_lattice(std::span<const CoordinateSurvey> surveys) {
  Bounds bounds;
  for (const CoordinateSurvey& survey : surveys) bounds.grow(survey.bounds);
  if (bounds.empty()) return {};

  Lattice lattice;
  glm::dvec3 reach(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    lattice.offset[axis] = std::nearbyint(0.5 * bounds.min[axis] + 0.5 * bounds.max[axis]);
    const double offset = lattice.offset[axis];
    reach[axis] = std::max(bounds.max[axis] - offset, offset - bounds.min[axis]);
    if (!(reach[axis] <= 1e300 && std::abs(offset) <= 1e300)) {
      throw Error({.problem = "coordinates too large",
                   .expected = "at most 1e300",
                   .found = fmt::format("{}", std::max(reach[axis], std::abs(offset)))});
    }
  }
  // An axis without extent, except for rounding, needs no resolution: that of a float of 0 is 1e-45.
  const double nothing = 1e-12 * std::max({reach.x, reach.y, reach.z});
  std::array<int, 3> finest{}, wanted{};
  for (int axis = 0; axis < 3; ++axis) {
    double resolution = std::numeric_limits<double>::infinity();
    for (const CoordinateSurvey& survey : surveys) {
      const double largest = std::max(-survey.bounds.min[axis], survey.bounds.max[axis]);
      if (survey.finite_count > 0 && largest > nothing)
        resolution = std::min(resolution, survey.resolution[axis]);
    }
    finest[axis] = finest_exponent(reach[axis]);
    wanted[axis] = finest[axis];
    if (resolution > 0 && std::isfinite(resolution)) {
      // Rounding costs half a step. The tiny addition keeps log10 of an exact power from falling below it.
      wanted[axis] =
          std::max(wanted[axis], static_cast<int>(std::floor(std::log10(2.0 * resolution) + 1e-9)));
    }
    if (reach[axis] <= nothing) wanted[axis] = std::max(wanted[axis], k_default_exponent);
  }
  // With equal steps the octree's nodes are cubes: boxes a million times longer than wide prune nothing.
  const int common = *std::min_element(wanted.begin(), wanted.end());
  for (int axis = 0; axis < 3; ++axis) lattice.scale[axis] = power_of_ten(std::max(common, finest[axis]));
  return lattice;
}

std::optional<int> decimals_of(const Lattice& lattice, int axis) {
  constexpr int k_most = 15;
  // The errors of all steps together must not exceed a thousandth of a step.
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

std::optional<int> shown_decimals(const Lattice& lattice, int axis) {
  constexpr int k_most_exact = 12;
  if (const auto exact = decimals_of(lattice, axis); exact && *exact <= k_most_exact) return exact;
  const double decimals = std::max(0.0, 3.0 - std::floor(std::log10(lattice.scale[axis])));
  return decimals <= 15.0 ? std::optional(static_cast<int>(decimals)) : std::nullopt;
}

std::optional<LatticeSteps> steps_between(const Lattice& from, const Lattice& to) {
  LatticeSteps steps;
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<AxisSteps> along =
        axis_steps(from.scale[axis], from.offset[axis], to.scale[axis], to.offset[axis]);
    if (!along) return std::nullopt;
    steps.factor[axis] = along->factor;
    steps.shift[axis] = along->shift;
  }
  return steps;
}

Lattice joined_lattice(std::span<const Lattice> lattices, const Bounds& bounds) {
  Lattice joined = lattices.front();
  const auto is_exact = [&](int axis, double scale) {
    return std::ranges::all_of(lattices, [&](const Lattice& own) {
      return axis_steps(own.scale[axis], own.offset[axis], scale, joined.offset[axis]).has_value();
    });
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (is_exact(axis, joined.scale[axis])) continue;
    double finest = joined.scale[axis], reach = 0.0;
    for (const Lattice& own : lattices) finest = std::min(finest, own.scale[axis]);
    for (const double corner : {bounds.min[axis], bounds.max[axis]})
      if (!bounds.empty()) reach = std::max(reach, std::fabs(corner - joined.offset[axis]));
    const auto is_held = [&](double scale) { return reach <= (k_largest_step - 1) * scale; };
    constexpr double k_parts[] = {1, 2, 5, 10};
    const auto part = std::ranges::find_if(
        k_parts, [&](double parts) { return is_exact(axis, finest / parts) && is_held(finest / parts); });
    double& scale = joined.scale[axis];
    scale = part != std::end(k_parts) ? finest / *part : finest;
    while (!is_held(scale)) scale *= 10.0;
  }
  return joined;
}

LatticeShift::LatticeShift(const Lattice& from, const Lattice& to, std::string file)
    : file_(std::move(file)), from_(from), to_(to), steps_(steps_between(from, to)) {}

LatticePosition LatticeShift::nearest(const LatticePosition& position) const {
  const glm::dvec3 world = to_world(from_, position);
  if (const auto moved = to_lattice(to_, world)) return *moved;
  reject((world - to_.offset) / to_.scale);
}

void LatticeShift::reject(const glm::dvec3& steps) const {
  throw Error({.file = file_,
               .problem = "too far from the first file for its lattice of 32-bit steps",
               .found = fmt::format("step {:.0f}, {:.0f}, {:.0f}", steps.x, steps.y, steps.z)});
}

}  // namespace alidade
