// SPDX-License-Identifier: MIT
#include "simulation/finish.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "simulation/noise.h"

// The patterns of the colours of a site. Only +, -, *, / and floor, see finish.h.

namespace alidade::simulation {
namespace {

using glm::dvec2;
using glm::dvec3;

/// Eases from 0 at `low` to 1 at `high`.
double step_between(double low, double high, double x) {
  const double share = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return share * share * (3.0 - 2.0 * share);
}

dvec3 blend(const dvec3& from, const dvec3& to, double share) {
  return from + share * (to - from);
}

/// Noise around 0, from -1 to 1, with features of `size` metres.
double blotches(const dvec3& position, double size, std::uint32_t seed) {
  return 2.0 * smooth_noise(position / size, seed) - 1.0;
}

double fraction(double x) {
  return x - std::floor(x);
}

/// A position on rows of stones, each row shifted by half a stone.
struct Stone {
  double shade = 0.0;  ///< brightness of the stone, -1 .. 1
  double joint = 0.0;  ///< 0 on the stone, 1 in the joint
};

Stone stone_at(const dvec2& position, const dvec2& size, double joint_width, std::uint32_t seed) {
  const double row = std::floor(position.y / size.y);
  const double along = position.x / size.x + fraction(0.5 * row);
  const double to_joint_x = (0.5 - std::fabs(fraction(along) - 0.5)) * size.x;
  const double to_joint_y = (0.5 - std::fabs(fraction(position.y / size.y) - 0.5)) * size.y;
  return {2.0 * cell_noise(along, row, seed) - 1.0,
          1.0 - step_between(0.25 * joint_width, joint_width, std::min(to_joint_x, to_joint_y))};
}

dvec3 grass(const dvec3& position) {
  const double wide = blotches(position, 6.0, 11), patch = blotches(position, 0.9, 12),
               blade = blotches(position, 0.11, 13);
  const dvec3 fresh(0.33, 0.46, 0.17), dry(0.50, 0.51, 0.26);
  return blend(fresh, dry, std::clamp(0.32 + 0.38 * wide + 0.22 * patch, 0.0, 1.0)) * (1.0 + 0.16 * blade);
}

dvec3 cobble(const dvec3& position) {
  const Stone stone = stone_at({position.x, position.y}, {0.24, 0.19}, 0.030, 21);
  const double stain = blotches(position, 3.5, 22);
  const dvec3 grey =
      blend(dvec3(0.565, 0.54, 0.505), dvec3(0.60, 0.545, 0.47), 0.5 + 0.5 * blotches(position, 9.0, 23));
  return blend(grey * (1.0 + 0.10 * stone.shade + 0.06 * stain), dvec3(0.40, 0.375, 0.33),
               0.75 * stone.joint);
}

dvec3 slab(const dvec3& position) {
  const Stone stone = stone_at({position.x, position.y}, {0.9, 0.6}, 0.028, 31);
  const dvec3 sandstone(0.705, 0.665, 0.595);
  const double shade = 1.0 + 0.06 * stone.shade + 0.05 * blotches(position, 1.3, 32);
  return blend(sandstone * shade, dvec3(0.47, 0.44, 0.39), 0.7 * stone.joint);
}

dvec3 asphalt(const dvec3& position) {
  return dvec3(0.35, 0.355, 0.365) *
         (1.0 + 0.07 * blotches(position, 2.5, 51) + 0.06 * blotches(position, 0.08, 52));
}

dvec3 pavement_color(Pavement pavement, const dvec3& position) {
  switch (pavement) {
    case Pavement::cobble:
      return cobble(position);
    case Pavement::slab:
      return slab(position);
    case Pavement::gravel:
      return dvec3(0.72, 0.67, 0.575) *
             (1.0 + 0.05 * blotches(position, 2.0, 41) + 0.10 * blotches(position, 0.06, 42));
    case Pavement::asphalt:
      return asphalt(position);
    case Pavement::road_marking:
      return fraction(position.x / 6.0) < 0.5 ? dvec3(0.80, 0.80, 0.78) : asphalt(position);
    case Pavement::soil:
      return dvec3(0.38, 0.30, 0.22) * (1.0 + 0.12 * blotches(position, 0.25, 61));
    case Pavement::grass:
      break;
  }
  return grass(position);
}

dvec3 plaster(const Finish& finish, const dvec2& uv, const dvec3& position) {
  const double weather =
      blotches(position, 2.6, finish.seed) * 0.6 + blotches(position, 0.5, finish.seed + 1) * 0.4;
  const double height = uv.y - finish.size.y;  // above the plinth
  if (finish.size.y > 0.0 && height < 0.0) {
    const Stone stone = stone_at({uv.x, height}, {1.1, 0.45}, 0.03, finish.seed);
    return blend(dvec3(0.56, 0.53, 0.49) * (1.0 + 0.06 * stone.shade + 0.05 * weather),
                 dvec3(0.42, 0.40, 0.37), 0.6 * stone.joint);
  }
  // The lowest metre above the plinth is a little darker, from splashing rain.
  const double damp = finish.size.y > 0.0 ? 1.0 - step_between(0.0, 1.2, height + 0.4 * weather) : 0.0;
  return finish.tint * (1.0 + 0.045 * weather) * (1.0 - 0.10 * damp);
}

dvec3 masonry(const Finish& finish, const dvec2& uv, const dvec3& position) {
  const Stone stone = stone_at(uv, {0.62, 0.34}, 0.025, finish.seed);
  return blend(finish.tint * (1.0 + 0.05 * stone.shade + 0.06 * blotches(position, 0.4, finish.seed)),
               0.72 * finish.tint, 0.5 * stone.joint);
}

dvec3 brick(const Finish& finish, const dvec2& uv, const dvec3& position) {
  const Stone stone = stone_at(uv, {0.25, 0.08}, 0.012, finish.seed);
  return blend(finish.tint * (1.0 + 0.12 * stone.shade + 0.05 * blotches(position, 0.6, finish.seed)),
               dvec3(0.60, 0.56, 0.50), 0.6 * stone.joint);
}

dvec3 roof_tiles(const Finish& finish, const shapes::SurfacePoint& surface, const dvec3& position) {
  constexpr int k_top = 5;
  if (surface.face != k_top) return finish.tint * 0.8;
  constexpr double k_tile_width = 0.26, k_tile_length = 0.34;
  const double row = std::floor(surface.uv.y / k_tile_length);
  const double along = surface.uv.x / k_tile_width + fraction(0.5 * row);
  const double shade = 2.0 * cell_noise(along, row, finish.seed) - 1.0;
  // A few replaced tiles are clearly lighter or darker.
  const double odd = cell_noise(along, row, finish.seed + 7);
  const double replaced = odd > 0.96 ? 0.16 : odd < 0.03 ? -0.2 : 0.0;
  const double bulge = 1.0 - 2.0 * std::fabs(fraction(along) - 0.5);
  const double above_edge = fraction(surface.uv.y / k_tile_length) * k_tile_length;
  const double shadow = 1.0 - step_between(0.0, 0.07, above_edge);
  const double moss = step_between(
      0.25, 0.8, blotches(position, 4.0, finish.seed + 3) + 0.5 * blotches(position, 0.7, finish.seed + 4));
  const dvec3 tile = finish.tint * (1.0 + 0.11 * shade + replaced + 0.10 * (bulge - 0.5));
  return blend(tile, dvec3(0.40, 0.38, 0.29), 0.35 * moss) * (1.0 - 0.38 * shadow);
}

dvec3 window(const Finish& finish, const shapes::SurfacePoint& surface, const dvec3& position) {
  constexpr int k_back = 4;
  if (surface.face != k_back) return finish.tint * 0.93;
  constexpr double k_frame = 0.075, k_bar = 0.03;
  const dvec2 at = surface.uv;
  const double to_edge = std::min(std::min(at.x, finish.size.x - at.x), std::min(at.y, finish.size.y - at.y));
  const double to_mullion = std::fabs(at.x - 0.5 * finish.size.x);
  const double to_transom = std::fabs(at.y - 0.68 * finish.size.y);
  if (to_edge < k_frame || to_mullion < k_bar + 0.02 || to_transom < k_bar) return {0.86, 0.85, 0.82};
  // Panes mirror a bit of sky, more towards the top; behind some a curtain shows.
  const double up = at.y / finish.size.y;
  const dvec3 glass = blend(dvec3(0.13, 0.17, 0.22), dvec3(0.30, 0.38, 0.46), up * up) *
                      (1.0 + 0.2 * blotches(position, 0.8, finish.seed));
  const double drawn = 0.45 * unit_of(mix_bits(finish.seed));
  const bool curtain = to_mullion > (0.5 - drawn * 0.6) * finish.size.x && mix_bits(finish.seed + 5) % 3 == 0;
  return curtain ? blend(glass, dvec3(0.62, 0.60, 0.56), 0.55) : glass;
}

dvec3 door(const Finish& finish, const shapes::SurfacePoint& surface, const dvec3& position) {
  constexpr int k_back = 4;
  if (surface.face != k_back) return {0.66, 0.62, 0.56};
  const dvec2 at = surface.uv;
  if (at.x < 0.09 || at.x > finish.size.x - 0.09 || at.y > finish.size.y - 0.09) return finish.tint * 0.72;
  if (std::fabs(at.x - 0.5 * finish.size.x) < 0.02) return finish.tint * 0.45;
  const double groove = std::fabs(fraction(at.x / 0.16) - 0.5);
  return finish.tint * (groove > 0.46 ? 0.7 : 1.0) *
         (1.0 + 0.08 * blotches({position.x, position.y, 0.2 * position.z}, 0.05, finish.seed));
}

/// Fibres along the longest side would depend on the shape; fine noise stretched upwards is good enough
/// for posts, slats and trunks.
dvec3 fibrous(const Finish& finish, const dvec3& position, double strength) {
  const double fibre = blotches({position.x, position.y, 0.15 * position.z}, 0.045, finish.seed);
  return finish.tint * (1.0 + strength * (0.7 * fibre + 0.3 * blotches(position, 0.5, finish.seed + 1)));
}

dvec3 leaf(const Finish& finish) {
  const double light = 2.0 * unit_of(mix_bits(finish.seed)) - 1.0,
               warm = 2.0 * unit_of(mix_bits(finish.seed ^ 0x5bd1e995u)) - 1.0;
  return finish.tint * (1.0 + 0.22 * light) * dvec3(1.0 + 0.16 * warm, 1.0, 1.0 - 0.10 * warm);
}

dvec3 car_body(const Finish& finish, const dvec3& normal, const dvec3& position) {
  // Lacquer: brighter where it faces up, as it mirrors the sky; a dark sill below.
  const double sill = 1.0 - step_between(0.30, 0.36, position.z);
  return blend(finish.tint * (0.94 + 0.10 * normal.z), dvec3(0.10), 0.85 * sill);
}

dvec3 unclamped_color(const Finish& finish, const shapes::SurfacePoint& surface, const dvec3& position) {
  switch (finish.material) {
    case SiteMaterial::terrain:
      return pavement_color(static_cast<Pavement>(surface.face), position);
    case SiteMaterial::plaster:
      return plaster(finish, surface.uv, position);
    case SiteMaterial::stone:
      return masonry(finish, surface.uv, position);
    case SiteMaterial::trim:
      return finish.tint * (1.0 + 0.05 * blotches(position, 0.35, finish.seed));
    case SiteMaterial::brick:
      return brick(finish, surface.uv, position);
    case SiteMaterial::roof_tile:
      return roof_tiles(finish, surface, position);
    case SiteMaterial::window:
      return window(finish, surface, position);
    case SiteMaterial::door:
      return door(finish, surface, position);
    case SiteMaterial::wood:
      return fibrous(finish, position, 0.14);
    case SiteMaterial::bark:
      return fibrous(finish, position, 0.30);
    case SiteMaterial::leaf:
      return leaf(finish);
    case SiteMaterial::hedge:
      return finish.tint * (1.0 + 0.22 * blotches(position, 0.09, finish.seed) +
                            0.12 * blotches(position, 0.6, finish.seed + 1));
    case SiteMaterial::water:
      return dvec3(0.16, 0.27, 0.30) * (1.0 + 0.12 * blotches(position, 0.5, finish.seed));
    case SiteMaterial::car_body:
      return car_body(finish, surface.normal, position);
    case SiteMaterial::car_cabin:
      return surface.normal.z > 0.9 ? finish.tint * 1.03 : dvec3(0.10, 0.12, 0.14);
    case SiteMaterial::tyre:
      return surface.uv.x < 0.19 && surface.uv.x > 0.0 ? dvec3(0.62, 0.63, 0.65) : dvec3(0.09);
    case SiteMaterial::metal:
    case SiteMaterial::lamp_glass:
    case SiteMaterial::target:
      break;
  }
  return finish.tint;
}

}  // namespace

glm::dvec3 color_of(const Finish& finish, const shapes::SurfacePoint& surface, const glm::dvec3& position) {
  return glm::clamp(unclamped_color(finish, surface, position), 0.0, 1.0);
}

std::uint8_t classification_of(const Finish& finish, const shapes::SurfacePoint& surface,
                               const glm::dvec3& position) {
  constexpr std::uint8_t k_unclassified = 1, k_ground = 2, k_low_vegetation = 3, k_high_vegetation = 5,
                         k_building = 6, k_water = 9, k_road = 11, k_car = 64, k_street = 65, k_target = 66;
  // In the order of SiteMaterial.
  constexpr std::uint8_t k_classes[] = {
      k_ground,   k_building, k_building, k_building,        k_street,          k_building,       k_building,
      k_building, k_street,   k_street,   k_high_vegetation, k_high_vegetation, k_low_vegetation, k_water,
      k_car,      k_car,      k_car,      k_street,          k_target};
  const auto material = static_cast<std::size_t>(finish.material);
  if (material >= std::size(k_classes)) return k_unclassified;
  const std::uint8_t usual = k_classes[material];
  const auto pavement = static_cast<Pavement>(surface.face);
  if (usual == k_ground && (pavement == Pavement::asphalt || pavement == Pavement::road_marking))
    return k_road;
  return usual == k_high_vegetation && !(position.z > 2.0) ? k_low_vegetation : usual;
}

double reflectance_of(SiteMaterial material, const glm::dvec3& color) {
  if (material == SiteMaterial::leaf || material == SiteMaterial::hedge) return 0.55;
  if (material == SiteMaterial::water) return 0.03;
  const double brightness = 0.3 * color.x + 0.6 * color.y + 0.1 * color.z;
  return 0.05 + 0.85 * brightness * brightness;  // squared: roughly from display to linear light
}

}  // namespace alidade::simulation
