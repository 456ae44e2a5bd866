// SPDX-License-Identifier: MIT
#include <array>

#include "base/error.h"
#include "renderer/read_scene_parts.h"

namespace alidade {
namespace {

constexpr NumberRange k_angle{-360, 360}, k_diameter{0, 180, false, true};

Moment read_date_time(const JsonNode& node) {
  try {
    return parse_date_time(node.text());
  } catch (const Error& error) {
    const Error::Parts& parts = error.parts();
    // An Error of the node itself has its file and place already.
    if (!parts.file.empty()) throw;
    node.fail(parts.problem, parts.expected, parts.found);
  }
}

/// Keys of a sun that is given by its place in the sky, and of one that is given by date and place.
constexpr std::array<std::string_view, 2> k_by_angles{"azimuth", "elevation"};
constexpr std::array<std::string_view, 5> k_by_place{"latitude", "longitude", "height", "pressure",
                                                     "temperature"};

Sun read_sun_by_angles(const JsonFields& fields) {
  for (const std::string_view key : k_by_place) {
    if (const auto found = fields.find(key))
      found->fail("a sun by place but without a time", "\"date_time\" beside it", "none");
  }
  Sun sun;
  if (const auto azimuth = fields.find("azimuth")) sun.azimuth = azimuth->number(k_angle);
  if (const auto elevation = fields.find("elevation")) sun.elevation = elevation->number({-90, 90, true});
  if (const auto irradiance = fields.find("irradiance")) sun.irradiance = read_rgb(*irradiance, k_light);
  if (const auto diameter = fields.find("angular_diameter"))
    sun.angular_diameter = diameter->number(k_diameter);
  return sun;
}

SunByTime read_sun_by_time(const JsonNode& date_time, const JsonFields& fields) {
  for (const std::string_view key : k_by_angles) {
    if (const auto found = fields.find(key))
      found->fail("a sun both by angles and by time",
                  "\"date_time\" alone, or \"azimuth\" and \"elevation\"");
  }
  SunByTime sun{.moment = read_date_time(date_time)};
  const auto latitude = fields.find("latitude"), longitude = fields.find("longitude");
  if (latitude.has_value() != longitude.has_value())
    (latitude ? *latitude : *longitude).fail("half a place", "\"latitude\" and \"longitude\"", "one of them");
  if (latitude) sun.latitude = latitude->number({-90, 90});
  if (longitude) sun.longitude = longitude->number({-180, 180});
  if (const auto height = fields.find("height")) sun.height = height->number({-1000, 100000});
  if (const auto pressure = fields.find("pressure")) sun.pressure = pressure->number({0, 2000});
  if (const auto temperature = fields.find("temperature")) sun.temperature = temperature->number({-150, 100});
  if (const auto irradiance = fields.find("irradiance")) {
    constexpr std::array<std::string_view, 1> words{"auto"};
    if (irradiance->is_string())
      irradiance->choice(words);
    else
      sun.irradiance = read_rgb(*irradiance, k_light);
  }
  if (const auto diameter = fields.find("angular_diameter"))
    sun.angular_diameter = diameter->number(k_diameter);
  return sun;
}

}  // namespace

Sky read_sky(const JsonNode& node, const std::filesystem::path& scene_file) {
  constexpr std::array<std::string_view, 3> types{"constant", "gradient", "image"};
  const JsonNode type = type_of(node, {"type", "radiance", "horizon", "zenith", "file", "scale", "rotation"});
  switch (type.choice(types)) {
    case 0: {
      const JsonFields fields(node, {"type", "radiance"});
      ConstantSky sky;
      if (const auto radiance = fields.find("radiance")) sky.radiance = read_rgb(*radiance, k_light);
      return sky;
    }
    case 1: {
      const JsonFields fields(node, {"type", "horizon", "zenith"});
      GradientSky sky;
      if (const auto horizon = fields.find("horizon")) sky.horizon = read_rgb(*horizon, k_light);
      if (const auto zenith = fields.find("zenith")) sky.zenith = read_rgb(*zenith, k_light);
      return sky;
    }
    default: {
      const JsonFields fields(node, {"type", "file", "scale", "rotation"});
      ImageSky sky{.file = path_beside(scene_file, fields.require("file")), .image = {}};
      if (const auto scale = fields.find("scale")) sky.scale = scale->number(k_light);
      if (const auto rotation = fields.find("rotation")) sky.rotation = rotation->number(k_angle);
      return sky;
    }
  }
}

void read_sun(const JsonNode& node, Scene& scene) {
  const JsonFields fields(node, {"azimuth", "elevation", "date_time", "latitude", "longitude", "height",
                                 "pressure", "temperature", "irradiance", "angular_diameter"});
  if (const auto date_time = fields.find("date_time"))
    scene.sun_by_time = read_sun_by_time(*date_time, fields);
  else
    scene.sun = read_sun_by_angles(fields);
}

}  // namespace alidade
