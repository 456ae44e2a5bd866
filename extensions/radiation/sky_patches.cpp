// SPDX-License-Identifier: MIT
#include "extensions/radiation/sky_patches.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "geo/earth.h"
#include "geo/sun.h"

namespace alidade::visibility {
namespace {

constexpr double k_degree = std::numbers::pi / 180.0;

constexpr double k_row_height = 12.0;  // degrees
constexpr std::array k_patches_of_row = {30, 30, 24, 24, 18, 12, 6};
constexpr int k_rows = static_cast<int>(k_patches_of_row.size());

/// The row for clearnesses below `end`: for each of the parameters a to e the factors of 1, zenith angle,
/// brightness, and brightness times zenith angle; c and d of the first row have equations of their own.
struct PerezRow {
  double end;
  std::array<std::array<double, 4>, 5> factors;
};

/// Perez, Seals, Michalsky 1993, table 1.
constexpr std::array<PerezRow, 8> k_perez{{
    {1.065,
     {{{1.3525, -0.2576, -0.2690, -1.4366},
       {-0.7670, 0.0007, 1.2734, -0.1233},
       {2.8000, 0.6004, 1.2375, 1.0000},
       {1.8734, 0.6297, 0.9738, 0.2809},
       {0.0356, -0.1246, -0.5718, 0.9938}}}},
    {1.230,
     {{{-1.2219, -0.7730, 1.4148, 1.1016},
       {-0.2054, 0.0367, -3.9128, 0.9156},
       {6.9750, 0.1774, 6.4477, -0.1239},
       {-1.5798, -0.5081, -1.7812, 0.1080},
       {0.2624, 0.0672, -0.2190, -0.4285}}}},
    {1.500,
     {{{-1.1000, -0.2515, 0.8952, 0.0156},
       {0.2782, -0.1812, -4.5000, 1.1766},
       {24.7219, -13.0812, -37.7000, 34.8438},
       {-5.0000, 1.5218, 3.9229, -2.6204},
       {-0.0156, 0.1597, 0.4199, -0.5562}}}},
    {1.950,
     {{{-0.5484, -0.6654, -0.2672, 0.7117},
       {0.7234, -0.6219, -5.6812, 2.6297},
       {33.3389, -18.3000, -62.2500, 52.0781},
       {-3.5000, 0.0016, 1.1477, 0.1062},
       {0.4659, -0.3296, -0.0876, -0.0329}}}},
    {2.800,
     {{{-0.6000, -0.3566, -2.5000, 2.3250},
       {0.2937, 0.0496, -5.6812, 1.8415},
       {21.0000, -4.7656, -21.5906, 7.2492},
       {-3.5000, -0.1554, 1.4062, 0.3988},
       {0.0032, 0.0766, -0.0656, -0.1294}}}},
    {4.500,
     {{{-1.0156, -0.3670, 1.0078, 1.4051},
       {0.2875, -0.5328, -3.8500, 3.3750},
       {14.0000, -0.9999, -7.1406, 7.5469},
       {-3.4000, -0.1078, -1.0750, 1.5702},
       {-0.0672, 0.4016, 0.3017, -0.4844}}}},
    {6.200,
     {{{-1.0000, 0.0211, 0.5025, -0.5119},
       {-0.3000, 0.1922, 0.7023, -1.6317},
       {19.0000, -5.0000, 1.2438, -1.9094},
       {-4.0000, 0.0250, 0.3844, 0.2656},
       {1.0468, -0.3788, -2.4517, 1.4656}}}},
    {INFINITY,
     {{{-1.0500, 0.0289, 0.4260, 0.3590},
       {-0.3250, 0.1156, 0.7781, 0.0025},
       {31.0625, -14.5000, -46.1148, 55.3750},
       {-7.2312, 0.4050, 13.3500, 0.6234},
       {1.5000, -0.6426, 1.8564, 0.5636}}}},
}};

/// The parameters a to e of a sky. `zenith`: angle of the sun from it, radians.
std::array<double, 5> perez_parameters(double clearness, double brightness, double zenith) {
  constexpr double k_least_brightness = 0.2, k_no_longer_middle = 2.8;
  const auto row = std::ranges::find_if(k_perez, [&](const PerezRow& one) { return clearness < one.end; });
  const bool is_overcast = row == k_perez.begin();
  if (!is_overcast && clearness < k_no_longer_middle) brightness = std::max(brightness, k_least_brightness);
  std::array<double, 5> parameters{};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::array<double, 4>& x = row->factors[i];
    parameters[i] = x[0] + x[1] * zenith + brightness * (x[2] + x[3] * zenith);
  }
  if (is_overcast) {
    const std::array<double, 4>&c = row->factors[2], &d = row->factors[3];
    parameters[2] = std::exp(std::pow(brightness * (c[0] + c[1] * zenith), c[2])) - c[3];
    parameters[3] = -std::exp(brightness * (d[0] + d[1] * zenith)) + d[2] + brightness * d[3];
  }
  return parameters;
}

/// A patch with the values that do not depend on the sun.
struct Patch {
  glm::dvec3 middle{0.0};
  double horizontal = 0.0;  ///< irradiance of the horizontal per radiance, sr
};

std::array<Patch, k_sky_patches> make_patches() {
  std::array<Patch, k_sky_patches> patches;
  for (int i = 0; i < k_sky_patches; ++i) {
    const SkyCell cell = sky_patch(i);
    const bool is_cap = i == k_sky_patches - 1;
    const double azimuth = 0.5 * (cell.azimuth_min + cell.azimuth_max),
                 elevation = is_cap ? 90.0 : 0.5 * (cell.elevation_min + cell.elevation_max);
    patches[static_cast<std::size_t>(i)] = {geo::compass_direction(azimuth, elevation),
                                            direction_integral(cell).z};
  }
  return patches;
}

}  // namespace

SkyCell sky_patch(int patch) {
  int row = 0;
  for (; row < k_rows && patch >= k_patches_of_row[static_cast<std::size_t>(row)]; ++row)
    patch -= k_patches_of_row[static_cast<std::size_t>(row)];
  if (row == k_rows) return {.elevation_min = k_rows * k_row_height};
  const double width = 360.0 / k_patches_of_row[static_cast<std::size_t>(row)];
  return {(patch - 0.5) * width, (patch + 0.5) * width, row * k_row_height, (row + 1) * k_row_height};
}

int sky_patch_at(double azimuth, double elevation) {
  const int row = static_cast<int>(elevation / k_row_height);
  if (row >= k_rows) return k_sky_patches - 1;
  int first = 0;
  for (int below = 0; below < row; ++below) first += k_patches_of_row[static_cast<std::size_t>(below)];
  const int count = k_patches_of_row[static_cast<std::size_t>(row)];
  const int column = static_cast<int>(std::floor(azimuth / 360.0 * count + 0.5)) % count;
  return first + (column < 0 ? column + count : column);
}

std::array<double, k_sky_patches> sky_radiances(const SkyState& state) {
  static const std::array<Patch, k_sky_patches> patches = make_patches();
  std::array<double, k_sky_patches> radiances{};
  if (!(state.diffuse_horizontal > 0.0)) return radiances;
  constexpr double k_highest_sun = 87.0, k_kappa = 1.041;
  const double elevation = std::min(state.elevation, k_highest_sun), zenith = (90.0 - elevation) * k_degree;
  const double cubic = k_kappa * zenith * zenith * zenith;
  const double clearness =
      ((state.diffuse_horizontal + state.direct_normal) / state.diffuse_horizontal + cubic) / (1.0 + cubic);
  const double brightness = state.diffuse_horizontal * geo::air_mass(elevation) / state.extraterrestrial;
  const auto [a, b, c, d, e] = perez_parameters(clearness, brightness, zenith);
  const glm::dvec3 sun = geo::compass_direction(state.azimuth, elevation);
  double horizontal = 0.0;
  for (std::size_t i = 0; i < radiances.size(); ++i) {
    const double cosine = std::clamp(glm::dot(sun, patches[i].middle), -1.0, 1.0);
    const double by_height = 1.0 + a * std::exp(b / patches[i].middle.z),
                 by_sun = 1.0 + c * std::exp(d * std::acos(cosine)) + e * cosine * cosine;
    radiances[i] = std::max(by_height * by_sun, 0.0);
    horizontal += radiances[i] * patches[i].horizontal;
  }
  // A sky that is dark everywhere has no distribution: it becomes even.
  if (!(horizontal > 0.0)) radiances.fill(1.0);
  const double scale = state.diffuse_horizontal / (horizontal > 0.0 ? horizontal : std::numbers::pi);
  for (double& radiance : radiances) radiance = std::round(radiance * scale * 1e6) / 1e6;
  return radiances;
}

}  // namespace alidade::visibility
