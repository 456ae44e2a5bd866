// SPDX-License-Identifier: MIT
#include "visibility/map_targets.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "octree/point_surface.h"
#include "octree/query.h"

namespace alidade {
namespace {

constexpr int k_block_levels = 7, k_block_side = 1 << k_block_levels;

int blocks_along(int cells) {
  return (cells + k_block_side - 1) / k_block_side;
}

/// Every second bit of a number, from its lowest: one coordinate of a place on the Z curve.
int every_second_bit(std::uint32_t number) {
  int coordinate = 0;
  for (int bit = 0; bit < k_block_levels; ++bit)
    coordinate |= static_cast<int>((number >> (2 * bit)) & 1u) << bit;
  return coordinate;
}

}  // namespace

SightEnd end_on_ground(const Occluders& occluders, const glm::dvec3& place) {
  constexpr std::size_t k_candidates = 8;
  constexpr double k_flat = 0.5;  // of the normal's z: slopes up to 60 degrees
  if (!occluders.has_surfaces()) return {place};
  const PointQuery query{.radius = occluders.largest_radius(), .k = k_candidates};
  std::optional<SightEnd> end;
  for (const PointHit& hit : find(occluders.octree(), place, query)) {
    const PointSurface surface = surface_of(occluders.octree().view(), hit.point_id);
    if (!surface.exists || std::fabs(surface.normal.z) < k_flat) continue;
    const glm::dvec3 center = hit.position - surface.height * surface.normal;
    const glm::dvec2 way = glm::dvec2(place) - glm::dvec2(center);
    const double sheet = center.z - (way.x * surface.normal.x + way.y * surface.normal.y) / surface.normal.z;
    if (std::fabs(sheet - place.z) > occluders.largest_sphere()) continue;
    // What a point of this sheet has as its own surface, the place has too.
    const SightEnd on_point = end_on_point(occluders, hit.point_id, hit.position, hit.position);
    if (!end) {
      const double height = std::max(place.z, sheet - surface.thickness) + surface.thickness;
      end = {{place.x, place.y, height}, on_point.own_reach, 0.0};
    }
    const double above = std::fabs((end->position.z - sheet) * surface.normal.z);
    end->own_thickness = std::max(end->own_thickness, above + on_point.own_thickness);
  }
  return end.value_or(SightEnd{place});
}

MapTargets::MapTargets(const Occluders& occluders, const Ground& ground, const RasterGrid& grid,
                       int places_across)
    : occluders_(occluders), ground_(ground), grid_(grid), places_across_(places_across) {}

std::size_t MapTargets::block_count() const {
  return static_cast<std::size_t>(blocks_along(grid_.columns)) *
         static_cast<std::size_t>(blocks_along(grid_.rows));
}

void MapTargets::block(std::size_t number, std::vector<MapTarget>& targets) const {
  const auto blocks = static_cast<std::size_t>(blocks_along(grid_.columns));
  const int first_column = static_cast<int>(number % blocks) * k_block_side,
            first_row = static_cast<int>(number / blocks) * k_block_side;
  struct Place {
    std::size_t cell;
    glm::dvec2 place;
  };
  std::vector<Place> places;
  for (std::uint32_t i = 0; i < k_block_side * k_block_side; ++i) {
    const int column = first_column + every_second_bit(i), row = first_row + every_second_bit(i >> 1);
    if (column >= grid_.columns || row >= grid_.rows) continue;
    const glm::dvec2 middle = grid_.center(column, row);
    for (int y = 0; y < places_across_; ++y) {
      for (int x = 0; x < places_across_; ++x) {
        const glm::dvec2 share =
            (glm::dvec2(x, y) + 0.5) / static_cast<double>(places_across_) - glm::dvec2(0.5);
        places.push_back({grid_.index(column, row), middle + share * grid_.cell_size});
      }
    }
  }
  std::vector<std::optional<MapTarget>> found(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    const glm::dvec2& place = places[i].place;
    if (const std::optional<double> height = ground_.at(place))
      found[i] = MapTarget{places[i].cell, end_on_ground(occluders_, {place.x, place.y, *height})};
  });
  targets.clear();
  for (const std::optional<MapTarget>& target : found) {
    if (target) targets.push_back(*target);
  }
}

}  // namespace alidade
