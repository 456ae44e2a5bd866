// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "visibility/sky/sun_path.h"

// The light of a time range, summed by direction once for all receivers. What is summed is a type with
// operator+=: hours here.

namespace alidade::visibility {

/// Light from a narrow range of directions. One line of sight decides whether a receiver gets it.
template <class Sums>
struct BinOf {
  /// Of the line; for the sun the unit mean of its directions, weighted by hours.
  glm::dvec3 direction{0.0, 0.0, 1.0};
  struct Share {
    int period = 0;  ///< SunStep::period
    Sums sums{};
  };
  std::vector<Share> shares{};  ///< in the order of periods
};

/// Light from a narrow range of azimuths, at all elevations; a horizon hides the part below it.
template <class Sums>
struct FanOf {
  glm::dvec2 direction{0.0, 1.0};  ///< horizontal unit vector
  struct Share {
    int period = 0;                ///< SunStep::period
    std::vector<double> slopes{};  ///< tangents of the elevations of the light, descending
    std::vector<Sums> sums{};      ///< sums[i]: of the first i slopes; one element more than slopes
  };
  std::vector<Share> shares{};  ///< in the order of periods
};

/// The light of a time range, in bins or in fans.
template <class Sums>
struct LightOf {
  int periods = 1;                  ///< number of them
  std::vector<BinOf<Sums>> bins{};  ///< empty with LightOptions::by_horizons
  std::vector<FanOf<Sums>> fans{};  ///< empty without
  std::vector<Sums> open{};         ///< without obstructions, by period
};

struct LightOptions {
  double bin = 0.0;          ///< width of bins and fans, degrees, [0, 30]; 0: one for each step of the sun
  bool by_horizons = false;  ///< fans, for receivers with horizons, instead of bins
};

/// Hours of direct sun.
struct SunHours {
  double hours = 0.0;

  SunHours& operator+=(const SunHours& other) {
    hours += other.hours;
    return *this;
  }
};

/// Groups the hours of the sun's steps by direction.
///
/// Bins span `options.bin` degrees of elevation and, at the horizon, of azimuth; further up they span more
/// azimuth, so that all have about the same size. The middle of a bin decides whether its light is hidden:
/// shadows begin and end up to half a bin too early or too late, equally often. The steps of a year, 10
/// minutes apart, fill some 1000 bins of 3 degrees. Fans span `options.bin` degrees of azimuth; their
/// elevations are exact. Requires SunStep::period in [0, periods). Errors: options.bin not in [0, 30].
LightOf<SunHours> sun_light(std::span<const SunStep> steps, int periods, const LightOptions& options);

// For other sums.

/// Errors: a bin size not in [0, 30].
void check_bin(double degrees);

/// The bins of steps.
struct StepBins {
  std::vector<std::size_t> of_step;    ///< index of the bin of every step
  std::vector<glm::dvec3> directions;  ///< of bins
};
StepBins bins_of_steps(std::span<const SunStep> steps, double degrees);

/// Azimuth of the fan that has a step, degrees.
double fan_azimuth(const SunStep& step, double degrees);
/// Number of sectors of about this many degrees that divide a turn.
int sectors_of(double degrees);
/// Tangent of an elevation in degrees.
double tangent_of(double elevation);

/// A bin for each of those of the steps; sums_of(i) are the sums of the i-th step.
template <class Sums, class SumsOf>
std::vector<BinOf<Sums>> sun_bins(std::span<const SunStep> steps, double degrees, const SumsOf& sums_of) {
  const StepBins grouped = bins_of_steps(steps, degrees);
  std::vector<BinOf<Sums>> bins;
  for (const glm::dvec3& direction : grouped.directions) bins.push_back({direction});
  for (std::size_t i = 0; i < steps.size(); ++i) {
    auto& shares = bins[grouped.of_step[i]].shares;
    auto share = shares.begin();
    while (share != shares.end() && share->period < steps[i].period) ++share;
    if (share == shares.end() || share->period != steps[i].period)
      share = shares.insert(share, {steps[i].period});
    share->sums += sums_of(i);
  }
  return bins;
}

/// Lights by azimuth in degrees, then by period: slopes, not sorted, and sums.
template <class Sums>
using FanLights = std::map<double, std::map<int, std::vector<std::pair<double, Sums>>>>;

template <class Sums, class SumsOf>
void add_sun_fans(std::span<const SunStep> steps, double degrees, const SumsOf& sums_of,
                  FanLights<Sums>& fans) {
  for (std::size_t i = 0; i < steps.size(); ++i)
    fans[fan_azimuth(steps[i], degrees)][steps[i].period].push_back(
        {tangent_of(steps[i].elevation), sums_of(i)});
}

glm::dvec2 fan_direction(double azimuth);

template <class Sums>
std::vector<FanOf<Sums>> sorted_fans(FanLights<Sums> lights) {
  std::vector<FanOf<Sums>> fans;
  for (auto& [azimuth, periods] : lights) {
    FanOf<Sums> fan{fan_direction(azimuth)};
    for (auto& [period, sloped] : periods) {
      std::ranges::stable_sort(sloped, std::greater<>{}, &std::pair<double, Sums>::first);
      typename FanOf<Sums>::Share share{.period = period, .slopes = {}, .sums = {{}}};
      for (const auto& [slope, light] : sloped) {
        share.slopes.push_back(slope);
        Sums sums = share.sums.back();
        share.sums.push_back(sums += light);
      }
      fan.shares.push_back(std::move(share));
    }
    fans.push_back(std::move(fan));
  }
  return fans;
}

}  // namespace alidade::visibility
