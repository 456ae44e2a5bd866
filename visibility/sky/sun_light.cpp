// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_light.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "base/error.h"
#include "geo/earth.h"
#include "visibility/sight_line.h"
#include "visibility/sky/sky_patches.h"

namespace alidade::visibility {
namespace {

/// Radiances of the patches summed over time, Wh/m2/sr, by period.
using SkyEnergies = std::vector<std::array<double, k_sky_patches>>;

SkyEnergies sky_energies(std::span<const SunStep> steps, int periods) {
  SkyEnergies energies(static_cast<std::size_t>(periods));
  for (const SunStep& step : steps) {
    const std::array<double, k_sky_patches> radiances =
        sky_radiances({step.azimuth, step.elevation, step.irradiance, step.diffuse, step.extraterrestrial});
    auto& sums = energies[static_cast<std::size_t>(step.period)];
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += step.hours * radiances[i];
  }
  return energies;
}

LightSums sums_of(const SunStep& step, const glm::dvec3& direction) {
  return {.hours = step.hours, .beam = step.hours * step.irradiance * direction};
}

LightSums& share_of(std::vector<LightBin::Share>& shares, int period) {
  const auto found = std::ranges::lower_bound(shares, period, {}, &LightBin::Share::period);
  if (found != shares.end() && found->period == period) return found->sums;
  return shares.insert(found, {period, {}})->sums;
}

/// Calls take(period, sums) with the diffuse light of a part of a patch, which has this integral of direction
/// over solid angle.
template <class Take>
void for_energies(const SkyEnergies& energies, const glm::dvec3& integral, int patch, const Take& take) {
  for (std::size_t period = 0; period < energies.size(); ++period) {
    const double energy = energies[period][static_cast<std::size_t>(patch)];
    if (energy > 0.0) take(static_cast<int>(period), LightSums{.diffuse = energy * integral});
  }
}

std::vector<LightBin> sun_bins(std::span<const SunStep> steps, double degrees) {
  std::vector<LightBin> bins;
  std::vector<glm::dvec3> weighted_sums;              // of directions
  std::map<std::pair<int, int>, std::size_t> bin_at;  // by row and column
  for (const SunStep& step : steps) {
    const glm::dvec3 direction = geo::compass_direction(step.azimuth, step.elevation);
    std::size_t bin = bins.size();
    if (degrees > 0.0) {
      const double row = std::floor(step.elevation / degrees);
      // As many columns as make the bins of the row as wide as high, at its middle.
      const double cosine = sine_cosine_of_degrees(std::fmin((row + 0.5) * degrees, 90.0)).cosine;
      const double columns = std::fmax(1.0, std::floor(360.0 * cosine / degrees + 0.5));
      const double column = std::floor(step.azimuth / 360.0 * columns);
      bin = bin_at.try_emplace({static_cast<int>(row), static_cast<int>(column)}, bin).first->second;
    }
    if (bin == bins.size()) {
      bins.emplace_back();
      weighted_sums.emplace_back(0.0);
    }
    weighted_sums[bin] += step.hours * direction;
    share_of(bins[bin].shares, step.period) += sums_of(step, direction);
  }
  for (std::size_t i = 0; i < bins.size(); ++i) bins[i].direction = glm::normalize(weighted_sums[i]);
  return bins;
}

void add_sky_bins(const SkyEnergies& energies, std::vector<LightBin>& bins) {
  for (int patch = 0; patch < k_sky_patches; ++patch) {
    LightBin bin;
    bin.direction = line_into_patch(patch);
    for_energies(energies, direction_integral(sky_patch(patch)), patch,
                 [&](int period, const LightSums& sums) {
                   bin.shares.push_back({period, sums});
                 });
    if (!bin.shares.empty()) bins.push_back(std::move(bin));
  }
}

/// Light at an elevation.
struct SlopedLight {
  double slope;  ///< tangent of the elevation
  LightSums sums;
};

/// By azimuth in degrees, then by period; not sorted by slope.
using FanLights = std::map<double, std::map<int, std::vector<SlopedLight>>>;

/// `elevation` in degrees.
double slope_of(double elevation) {
  const SineCosine rise = sine_cosine_of_degrees(elevation);
  return rise.sine / rise.cosine;
}

/// Number of sectors of about this many degrees that divide a turn.
int sectors_of(double degrees) {
  return static_cast<int>(std::fmax(1.0, std::floor(360.0 / degrees + 0.5)));
}

void add_sun_fans(std::span<const SunStep> steps, double degrees, FanLights& fans) {
  const int sectors = degrees > 0.0 ? sectors_of(degrees) : 0;
  for (const SunStep& step : steps) {
    const double azimuth =
        sectors > 0 ? (std::floor(step.azimuth / 360.0 * sectors) + 0.5) * 360.0 / sectors : step.azimuth;
    fans[azimuth][step.period].push_back(
        {slope_of(step.elevation), sums_of(step, geo::compass_direction(step.azimuth, step.elevation))});
  }
}

void add_sky_fans(const SkyEnergies& energies, double degrees, FanLights& fans) {
  constexpr double k_widest = 2.0;
  constexpr int k_rows = 90;  // of a degree
  const int sectors = sectors_of(degrees > 0.0 ? std::fmin(degrees, k_widest) : k_widest);
  const auto for_cells = [&](const auto& visit) {
    for (int sector = 0; sector < sectors; ++sector) {
      const double azimuth = (sector + 0.5) * 360.0 / sectors;
      for (int row = 0; row < k_rows; ++row) {
        visit(azimuth, row + 0.5,
              SkyCell{sector * 360.0 / sectors, (sector + 1) * 360.0 / sectors, static_cast<double>(row),
                      row + 1.0});
      }
    }
  };
  // A cell takes the radiance of the patch that contains its middle, although it may reach into others. So
  // the irradiance of the cells of a patch is scaled to that of the patch.
  std::array<double, k_sky_patches> shares{};
  for_cells([&](double azimuth, double elevation, const SkyCell& cell) {
    const int patch = sky_patch_at(azimuth, elevation);
    shares[static_cast<std::size_t>(patch)] +=
        direction_integral(cell).z / direction_integral(sky_patch(patch)).z;
  });
  for_cells([&](double azimuth, double elevation, const SkyCell& cell) {
    const int patch = sky_patch_at(azimuth, elevation);
    const glm::dvec3 integral = direction_integral(cell) / shares[static_cast<std::size_t>(patch)];
    for_energies(energies, integral, patch, [&](int period, const LightSums& sums) {
      fans[azimuth][period].push_back({slope_of(elevation), sums});
    });
  });
}

std::vector<LightFan> sorted_fans(FanLights& lights) {
  std::vector<LightFan> fans;
  for (auto& [azimuth, periods] : lights) {
    LightFan fan;
    fan.direction = glm::dvec2(geo::compass_direction(azimuth, 0.0));
    for (auto& [period, sloped] : periods) {
      std::ranges::stable_sort(sloped, std::greater<>{}, &SlopedLight::slope);
      LightFan::Share share{.period = period, .slopes = {}, .sums = {{}}};
      for (const SlopedLight& light : sloped) {
        share.slopes.push_back(light.slope);
        LightSums sums = share.sums.back();
        share.sums.push_back(sums += light.sums);
      }
      fan.shares.push_back(std::move(share));
    }
    fans.push_back(std::move(fan));
  }
  return fans;
}

}  // namespace

glm::dvec3 line_into_patch(int patch) {
  const SkyCell cell = sky_patch(patch);
  // The line divides the horizontal irradiance of the patch, which grows with the square of the sine.
  const double low = sine_cosine_of_degrees(cell.elevation_min).sine,
               high = sine_cosine_of_degrees(cell.elevation_max).sine, share = golden_turns(patch);
  const double sine = std::sqrt(low * low + share * (high * high - low * low));
  const SineCosine turn = sine_cosine_of_degrees(0.5 * (cell.azimuth_min + cell.azimuth_max));
  const double cosine = patch == k_sky_patches - 1 ? 0.0 : std::sqrt(1.0 - sine * sine);
  return glm::normalize(glm::dvec3(turn.sine * cosine, turn.cosine * cosine, sine));
}

SunLight sun_light(std::span<const SunStep> steps, int periods, const LightOptions& options) {
  constexpr double k_widest = 30.0;
  check_that(options.bin >= 0.0 && options.bin <= k_widest, "bin size of sun positions out of range",
             fmt::format("0 to {} degrees", k_widest), fmt::format("{}", options.bin));
  SunLight light;
  light.periods = periods;
  light.open.resize(static_cast<std::size_t>(periods));
  for (const SunStep& step : steps) {
    LightSums sums = sums_of(step, geo::compass_direction(step.azimuth, step.elevation));
    if (options.has_sky) sums.diffuse.z = step.hours * step.diffuse;
    light.open[static_cast<std::size_t>(step.period)] += sums;
  }
  const SkyEnergies energies = options.has_sky ? sky_energies(steps, periods) : SkyEnergies{};
  if (options.by_horizons) {
    FanLights fans;
    add_sun_fans(steps, options.bin, fans);
    if (options.has_sky) add_sky_fans(energies, options.bin, fans);
    light.fans = sorted_fans(fans);
  } else {
    light.bins = sun_bins(steps, options.bin);
    if (options.has_sky) add_sky_bins(energies, light.bins);
  }
  return light;
}

}  // namespace alidade::visibility
