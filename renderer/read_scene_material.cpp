// SPDX-License-Identifier: MIT
#include <array>

#include "renderer/read_scene_parts.h"

namespace alidade {
namespace {

constexpr NumberRange k_share{0.0, 1.0};

// Objects have no colour of their own, so their materials must say it.
std::optional<Rgb> read_albedo(const JsonFields& fields, bool of_cloud) {
  if (!of_cloud) return read_rgb(fields.require("albedo"), k_share);
  if (const auto albedo = fields.find("albedo")) return read_rgb(*albedo, k_share);
  return {};
}

}  // namespace

Material read_material(const JsonNode& node, bool of_cloud) {
  constexpr std::array<std::string_view, 4> types{"lambertian", "metal", "dielectric", "emissive"};
  switch (type_of(node, {"type", "albedo", "roughness", "refractive_index", "radiance"}).choice(types)) {
    case 0: {
      const JsonFields fields(node, {"type", "albedo"});
      return Lambertian{read_albedo(fields, of_cloud)};
    }
    case 1: {
      const JsonFields fields(node, {"type", "albedo", "roughness"});
      Metal metal{.albedo = read_albedo(fields, of_cloud)};
      if (const auto roughness = fields.find("roughness")) metal.roughness = roughness->number(k_share);
      return metal;
    }
    case 2: {
      const JsonFields fields(node, {"type", "refractive_index"});
      Dielectric dielectric;
      if (const auto index = fields.find("refractive_index"))
        dielectric.refractive_index = index->number({0.1, 10});
      return dielectric;
    }
    default: {
      const JsonFields fields(node, {"type", "radiance"});
      Emissive emissive;
      if (const auto radiance = fields.find("radiance")) emissive.radiance = read_rgb(*radiance, k_light);
      return emissive;
    }
  }
}

}  // namespace alidade
