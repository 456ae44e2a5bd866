// SPDX-License-Identifier: MIT
#include "visibility/horizon/horizon_file.h"

#include <fmt/format.h>

#include <cassert>
#include <nlohmann/json.hpp>
#include <utility>

namespace alidade {
namespace {

// Objects keep the order in which they are written here.
using Json = nlohmann::ordered_json;

Json point_geometry(const glm::dvec3& place) {
  return {{"type", "Point"}, {"coordinates", {place.x, place.y}}};
}

Json feature(Json geometry, Json properties) {
  return {{"type", "Feature"}, {"geometry", std::move(geometry)}, {"properties", std::move(properties)}};
}

}  // namespace

std::string horizon_csv(std::span<const HorizonDirection> horizon) {
  std::string text = "azimuth,elevation,distance,point_id,x,y,z\n";
  for (const HorizonDirection& direction : horizon) {
    if (!direction.blocker) {
      text += fmt::format("{:.6g},,,,,,\n", direction.azimuth);
      continue;
    }
    const Blocker& blocker = *direction.blocker;
    text += fmt::format("{:.6g},{:.6g},{:.4f},{},{:.12g},{:.12g},{:.12g}\n", direction.azimuth,
                        *direction.elevation, blocker.distance, blocker.point_id, blocker.position.x,
                        blocker.position.y, blocker.position.z);
  }
  return text;
}

std::vector<glm::dvec3> horizon_places(std::span<const HorizonDirection> horizon, const HorizonFacts& facts) {
  std::vector<glm::dvec3> places;
  for (const HorizonDirection& direction : horizon)
    if (direction.blocker) places.push_back(direction.blocker->position);
  places.push_back(facts.eye);
  return places;
}

std::string horizon_geojson(std::span<const HorizonDirection> horizon, const HorizonFacts& facts,
                            const std::optional<std::vector<glm::dvec3>>& on_globe) {
  const std::vector<glm::dvec3> places = on_globe ? *on_globe : horizon_places(horizon, facts);
  assert(places.size() == horizon_places(horizon, facts).size());
  // One feature per line: for people, and for programs that look at differences.
  std::string text = "{\"type\": \"FeatureCollection\",\n";
  if (!on_globe) text += "\"coordinate_system\": \"x and y of the cloud, not longitude and latitude\",\n";
  text += "\"features\": [\n";
  Json eye{{"kind", "observer"},
           {"z", facts.eye.z},
           {"sky_view_factor", facts.sky.cosine_weighted},
           {"sky_solid_angle", facts.sky.solid_angle}};
  if (facts.above_line) {
    eye["sky_view_factor_above_line"] = facts.above_line->cosine_weighted;
    eye["sky_solid_angle_above_line"] = facts.above_line->solid_angle;
  }
  text += feature(point_geometry(places.back()), std::move(eye)).dump();
  std::size_t next = 0;
  for (const HorizonDirection& direction : horizon) {
    Json geometry = nullptr;
    Json properties{{"kind", "horizon"}, {"azimuth", direction.azimuth}};
    if (direction.blocker) {
      geometry = point_geometry(places[next++]);
      properties["elevation"] = *direction.elevation;
      properties["distance"] = direction.blocker->distance;
      properties["point_id"] = direction.blocker->point_id;
      properties["z"] = direction.blocker->position.z;
    }
    text += ",\n" + feature(std::move(geometry), std::move(properties)).dump();
  }
  return text + "\n]}\n";
}

}  // namespace alidade
