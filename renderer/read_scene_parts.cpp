// SPDX-License-Identifier: MIT
#include "renderer/read_scene_parts.h"

#include <algorithm>
#include <array>

#include "base/error.h"

namespace alidade {
namespace {

ValueRange read_range(const JsonNode& node, const NumberRange& allowed) {
  const std::vector<JsonNode> ends = node.elements(2, 2);
  const ValueRange range{ends[0].number(allowed), ends[1].number(allowed)};
  if (!(range.low < range.high)) node.fail("range is empty", "the smaller number first");
  return range;
}

Color16 read_hex_color(const JsonNode& node) {
  const std::string text = node.text();
  const std::optional<Color16> color = parse_hex_color(text);
  if (!color) node.fail("not a colour", "\"#rrggbb\" in hexadecimal");
  return *color;
}

ClassColor read_class(const JsonNode& node) {
  const JsonFields fields(node, {"class", "color", "name"});
  ClassColor result;
  result.number = static_cast<std::uint8_t>(fields.require("class").whole_number(0, 255));
  result.color = read_hex_color(fields.require("color"));
  if (const auto name = fields.find("name")) result.name = name->text();
  return result;
}

std::vector<ClassColor> read_classes(const JsonNode& node) {
  std::vector<ClassColor> classes;
  for (const JsonNode& each : node.elements(0, 256)) {
    const ClassColor read = read_class(each);
    if (std::ranges::find(classes, read.number, &ClassColor::number) != classes.end())
      each.fail("class stands twice", "every class once");
    classes.push_back(read);
  }
  return classes;
}

}  // namespace

PointColoring read_coloring(const JsonNode& node) {
  if (node.is_string()) return coloring_by(node.text());
  const JsonFields fields(node, {"by", "map", "range", "percentiles", "classes"});
  PointColoring coloring;
  if (const auto by = fields.find("by")) coloring = coloring_by(by->text());
  if (const auto map = fields.find("map")) {
    std::array<std::string_view, k_color_maps.size() + 1> words{"auto"};
    std::ranges::transform(k_color_maps, words.begin() + 1, &NamedColorMap::name);
    if (const std::size_t word = map->choice(words); word > 0) coloring.map = k_color_maps[word - 1].map;
  }
  if (const auto range = fields.find("range")) {
    constexpr std::array<std::string_view, 1> words{"auto"};
    if (range->is_string())
      range->choice(words);
    else
      coloring.range = read_range(*range, {-k_largest_value, k_largest_value});
  }
  if (const auto percentiles = fields.find("percentiles"))
    coloring.percentiles = read_range(*percentiles, {0, 100});
  if (const auto classes = fields.find("classes")) coloring.classes = read_classes(*classes);
  return coloring;
}

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
