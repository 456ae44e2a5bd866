// SPDX-License-Identifier: MIT
#include "extensions/radiation/energy_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "base/exact_math.h"
#include "extensions/radiation/sky_patches.h"
#include "geo/earth.h"

namespace alidade::visibility {
namespace {

/// Radiances of the patches summed over time, Wh/m2/sr, by period.
using SkyEnergies = std::vector<std::array<double, k_sky_patches>>;

SkyEnergies sky_energies(std::span<const LitStep> steps, int periods) {
  SkyEnergies energies(static_cast<std::size_t>(periods));
  for (const LitStep& step : steps) {
    const std::array<double, k_sky_patches> radiances =
        sky_radiances({step.azimuth, step.elevation, step.irradiance, step.diffuse, step.extraterrestrial});
    auto& sums = energies[static_cast<std::size_t>(step.period)];
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += step.hours * radiances[i];
  }
  return energies;
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

void add_sky_fans(const SkyEnergies& energies, double degrees, FanLights<LightSums>& fans) {
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
      fans[azimuth][period].push_back({tangent_of(elevation), sums});
    });
  });
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

EnergyLight energy_light(std::span<const LitStep> steps, int periods, const EnergyLightOptions& options) {
  check_bin(options.bin);
  EnergyLight light{.periods = periods};
  light.open.resize(static_cast<std::size_t>(periods));
  std::vector<SunStep> path;
  std::vector<LightSums> sums;
  for (const LitStep& step : steps) {
    const glm::dvec3 direction = geo::compass_direction(step.azimuth, step.elevation);
    path.push_back({step.azimuth, step.elevation, step.hours, step.period});
    sums.push_back({.hours = step.hours, .beam = step.hours * step.irradiance * direction});
    LightSums with_sky = sums.back();
    if (options.has_sky) with_sky.diffuse.z = step.hours * step.diffuse;
    light.open[static_cast<std::size_t>(step.period)] += with_sky;
  }
  const auto sums_of = [&](std::size_t i) { return sums[i]; };
  const SkyEnergies energies = options.has_sky ? sky_energies(steps, periods) : SkyEnergies{};
  if (options.by_horizons) {
    FanLights<LightSums> fans;
    add_sun_fans(path, options.bin, sums_of, fans);
    if (options.has_sky) add_sky_fans(energies, options.bin, fans);
    light.fans = sorted_fans(std::move(fans));
  } else {
    light.bins = sun_bins<LightSums>(path, options.bin, sums_of);
    if (options.has_sky) add_sky_bins(energies, light.bins);
  }
  return light;
}

}  // namespace alidade::visibility
