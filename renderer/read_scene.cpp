// SPDX-License-Identifier: MIT
#include "renderer/read_scene.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/input_file.h"
#include "base/json.h"
#include "camera/camera_json.h"
#include "image/output_settings.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"

// Ranges are those of scenes/schema, which the tests compare.

namespace alidade::renderer {
namespace {

/// Radiance and irradiance per channel.
constexpr NumberRange k_light{0.0, 1e9};

/// The name in the node, taken relative to the scene file.
std::filesystem::path path_beside(const std::filesystem::path& scene_file, const JsonNode& node) {
  // Addresses of servers are not relative to the scene file.
  if (node.text().find("://") != std::string::npos) return node.text();
  return (scene_file.parent_path() / node.text()).lexically_normal();
}

/// Which of these words the node is.
std::size_t choice_of(const JsonNode& node, std::initializer_list<std::string_view> words) {
  return node.choice({words.begin(), words.size()});
}

/// Whether the value is `word` instead of one of another type. Errors: another word.
bool is_word(const JsonNode& node, std::string_view word) {
  if (node.is_string()) choice_of(node, {word});
  return node.is_string();
}

/// The entry of a table whose name the node is.
template <class Table>
const auto& entry_of(const JsonNode& node, const Table& table) {
  std::vector<std::string_view> words;
  for (const auto& entry : table) words.push_back(entry.name);
  return table[node.choice(words)];
}

/// A length, or nothing for "auto".
std::optional<double> length_or_auto(const JsonNode& node) {
  return is_word(node, "auto") ? std::nullopt : std::optional(node.number(k_length));
}

/// Three values, each in `range`.
Rgb read_rgb(const JsonNode& node, const NumberRange& range) {
  return Rgb(node.vector(range));
}

image::ValueRange read_range(const JsonNode& node, const NumberRange& allowed) {
  const std::vector<JsonNode> ends = node.elements(2, 2);
  const image::ValueRange range{ends[0].number(allowed), ends[1].number(allowed)};
  if (!(range.low < range.high)) node.fail("empty range", "the smaller number first");
  return range;
}

Color16 read_hex_color(const JsonNode& node) {
  const std::string text = node.text();
  const std::optional<Color16> color = image::parse_hex_color(text);
  if (!color) node.fail("invalid colour", "\"#rrggbb\" in hexadecimal");
  return *color;
}

image::ClassColor read_class(const JsonNode& node) {
  const JsonFields fields(node, {"class", "color", "name"});
  image::ClassColor result;
  result.number = static_cast<std::uint8_t>(fields.require("class").whole_number(0, 255));
  result.color = read_hex_color(fields.require("color"));
  if (const auto name = fields.find("name")) result.name = name->text();
  return result;
}

std::vector<image::ClassColor> read_classes(const JsonNode& node) {
  std::vector<image::ClassColor> classes;
  for (const JsonNode& each : node.elements(0, 256)) {
    const image::ClassColor read = read_class(each);
    if (std::ranges::find(classes, read.number, &image::ClassColor::number) != classes.end())
      each.fail("duplicate class", "unique classes");
    classes.push_back(read);
  }
  return classes;
}

/// "color" of a cloud.
image::PointColoring read_coloring(const JsonNode& node) {
  if (node.is_string()) return image::coloring_by(node.text());
  const JsonFields fields(node, {"by", "map", "range", "percentiles", "classes"});
  image::PointColoring coloring;
  if (const auto by = fields.find("by")) coloring = image::coloring_by(by->text());
  if (const auto map = fields.find("map")) {
    std::array<std::string_view, image::k_color_maps.size() + 1> words{"auto"};
    std::ranges::transform(image::k_color_maps, words.begin() + 1, &image::NamedColorMap::name);
    if (const std::size_t word = map->choice(words); word > 0)
      coloring.map = image::k_color_maps[word - 1].map;
  }
  if (const auto range = fields.find("range"); range && !is_word(*range, "auto"))
    coloring.range = read_range(*range, {-image::k_largest_value, image::k_largest_value});
  if (const auto percentiles = fields.find("percentiles"))
    coloring.percentiles = read_range(*percentiles, {0, 100});
  if (const auto classes = fields.find("classes")) coloring.classes = read_classes(*classes);
  return coloring;
}

constexpr NumberRange k_share{0.0, 1.0};

// Objects have no colour of their own, so their materials must have one.
std::optional<Rgb> read_albedo(const JsonFields& fields, bool of_cloud) {
  if (!of_cloud) return read_rgb(fields.require("albedo"), k_share);
  if (const auto albedo = fields.find("albedo")) return read_rgb(*albedo, k_share);
  return {};
}

/// A material. `of_cloud`: points have a colour of their own, so that the albedo may be left out.
Material read_material(const JsonNode& node, bool of_cloud) {
  const JsonNode type = type_of(node, {"type", "albedo", "roughness", "refractive_index", "radiance"});
  switch (choice_of(type, {"lambertian", "metal", "dielectric", "emissive"})) {
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

constexpr NumberRange k_angle{-360, 360}, k_diameter{0, 180, false, true};

Moment read_date_time(const JsonNode& node) {
  try {
    return parse_date_time(node.text());
  } catch (const Error& error) {
    const Error::Parts& parts = error.parts();
    // An Error of the node itself has its file and location already.
    if (!parts.file.empty()) throw;
    node.fail(parts.problem, parts.expected, parts.found);
  }
}

/// Keys of a sun that is given by its position in the sky, and of one that is given by date and location.
constexpr std::array<std::string_view, 2> k_by_angles{"azimuth", "elevation"};
constexpr std::array<std::string_view, 5> k_by_location{"latitude", "longitude", "height", "pressure",
                                                        "temperature"};

geo::Sun read_sun_by_angles(const JsonFields& fields) {
  for (const std::string_view key : k_by_location) {
    if (const auto found = fields.find(key))
      found->fail("the location of the sun requires a time", "\"date_time\"", "none");
  }
  geo::Sun sun;
  if (const auto azimuth = fields.find("azimuth")) sun.azimuth = azimuth->number(k_angle);
  if (const auto elevation = fields.find("elevation")) sun.elevation = elevation->number({-90, 90, true});
  if (const auto irradiance = fields.find("irradiance")) sun.irradiance = read_rgb(*irradiance, k_light);
  if (const auto diameter = fields.find("angular_diameter"))
    sun.angular_diameter = diameter->number(k_diameter);
  return sun;
}

geo::SunByTime read_sun_by_time(const JsonNode& date_time, const JsonFields& fields) {
  for (const std::string_view key : k_by_angles) {
    if (const auto found = fields.find(key))
      found->fail("the sun has both angles and a time",
                  "\"date_time\" alone, or \"azimuth\" and \"elevation\"");
  }
  geo::SunByTime sun{.moment = read_date_time(date_time)};
  const auto latitude = fields.find("latitude"), longitude = fields.find("longitude");
  if (latitude.has_value() != longitude.has_value())
    (latitude ? *latitude : *longitude)
        .fail("incomplete location", "\"latitude\" and \"longitude\"", "one of them");
  if (latitude) sun.latitude = latitude->number({-90, 90});
  if (longitude) sun.longitude = longitude->number({-180, 180});
  if (const auto height = fields.find("height")) sun.height = height->number({-1000, 100000});
  if (const auto pressure = fields.find("pressure")) sun.pressure = pressure->number({0, 2000});
  if (const auto temperature = fields.find("temperature")) sun.temperature = temperature->number({-150, 100});
  if (const auto irradiance = fields.find("irradiance"); irradiance && !is_word(*irradiance, "auto"))
    sun.irradiance = read_rgb(*irradiance, k_light);
  if (const auto diameter = fields.find("angular_diameter"))
    sun.angular_diameter = diameter->number(k_diameter);
  return sun;
}

Sky read_sky(const JsonNode& node, const std::filesystem::path& scene_file) {
  const JsonNode type = type_of(node, {"type", "radiance", "horizon", "zenith", "file", "scale", "rotation"});
  switch (choice_of(type, {"constant", "gradient", "image"})) {
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

/// Sets `sun` or `sun_by_time`.
void read_sun(const JsonNode& node, Scene& scene) {
  const JsonFields fields(node, {"azimuth", "elevation", "date_time", "latitude", "longitude", "height",
                                 "pressure", "temperature", "irradiance", "angular_diameter"});
  if (const auto date_time = fields.find("date_time"))
    scene.sun_by_time = read_sun_by_time(*date_time, fields);
  else
    scene.sun = read_sun_by_angles(fields);
}

AdaptedRadius read_adapted_radius(const JsonNode& node) {
  const JsonFields fields(node, {"neighbours", "factor", "max"});
  AdaptedRadius radius;
  if (const auto neighbours = fields.find("neighbours"))
    radius.neighbours = static_cast<int>(neighbours->whole_number(1, k_most_spacing_neighbours));
  if (const auto factor = fields.find("factor")) radius.factor = factor->number(k_length);
  if (const auto max = fields.find("max")) radius.max = length_or_auto(*max);
  return radius;
}

CloudSettings read_cloud_settings(const JsonNode& node, const std::filesystem::path& scene_file) {
  const JsonFields fields(node, {"files", "file", "partial", "radius", "hits", "color", "color_depth",
                                 "normals", "surface", "max_level", "material"});
  CloudSettings cloud;
  const auto files = fields.find("files"), file = fields.find("file");
  if (files && file) file->fail("\"file\" and \"files\" exclude each other", "one of them", "both");
  if (!files && !file) node.fail("missing key \"files\"", "\"files\" or \"file\"", "neither");
  if (file) cloud.files.push_back(path_beside(scene_file, *file));
  if (files) {
    for (const JsonNode& each : files->elements(1, std::size_t(-1)))
      cloud.files.push_back(path_beside(scene_file, each));
  }
  if (const auto partial = fields.find("partial")) cloud.partial = partial->boolean();
  if (const auto radius = fields.find("radius")) {
    if (radius->is_object())
      cloud.adapted_radius = read_adapted_radius(*radius);
    else
      cloud.radius = length_or_auto(*radius);
  }
  if (const auto hits = fields.find("hits"))
    cloud.hits = choice_of(*hits, {"entry", "t"}) == 0 ? HitMode::entry : HitMode::t;
  if (const auto color = fields.find("color")) cloud.color = read_coloring(*color);
  if (const auto max_level = fields.find("max_level"))
    cloud.max_level = static_cast<int>(max_level->whole_number(0, k_max_level));
  if (const auto depth = fields.find("color_depth"); depth && !is_word(*depth, "automatic")) {
    const double bits = depth->number({8, 16});
    if (bits != 8 && bits != 16) depth->fail("invalid colour depth", "8, 16 or \"automatic\"");
    cloud.color_depth = bits == 8 ? ColorDepth::bits_8 : ColorDepth::bits_16;
  }
  if (const auto normals = fields.find("normals"))
    cloud.normals = choice_of(*normals, {"sphere", "smooth"}) == 0 ? NormalMode::sphere : NormalMode::smooth;
  if (const auto material = fields.find("material")) cloud.material = read_material(*material, true);
  if (const auto surface = fields.find("surface")) {
    cloud.shape = static_cast<PointShape>(choice_of(*surface, {"sphere", "disc", "blend"}));
  } else {
    // What applies to spheres only selects them, as the options of 'alidade render' do.
    const bool are_spheres =
        cloud.radius || fields.find("hits") || fields.find("normals") || fields.find("max_level") ||
        (cloud.adapted_radius && cloud.adapted_radius->neighbours != k_surface_neighbours) ||
        std::holds_alternative<Dielectric>(cloud.material);
    cloud.shape = are_spheres ? PointShape::sphere : PointShape::blend;
  }
  return cloud;
}

Model read_mesh_object(const JsonNode& node, const std::filesystem::path& scene_file) {
  const JsonFields fields(node, {"type", "file", "scale", "rotate_z", "translate", "material"});
  Model model;
  MeshFile& mesh = model.mesh.emplace();
  mesh.file = path_beside(scene_file, fields.require("file"));
  if (const auto scale = fields.find("scale")) mesh.placement.scale = scale->number(k_length);
  if (const auto turn = fields.find("rotate_z")) mesh.placement.rotate_z = turn->number(k_angle);
  if (const auto move = fields.find("translate")) mesh.placement.translate = move->vector(k_coordinate);
  if (const auto material = fields.find("material")) {
    model.material = read_material(*material, true);
    if (model.material.index() > 1)
      material->fail("invalid material of a mesh", "\"lambertian\" or \"metal\"");
  }
  return model;
}

Object read_object(const JsonNode& node, const std::filesystem::path& scene_file) {
  const JsonNode type = type_of(
      node, {"type", "center", "radius", "height", "file", "scale", "rotate_z", "translate", "material"});
  const std::size_t kind = choice_of(type, {"sphere", "ground_plane", "mesh"});
  if (kind == 2) return read_mesh_object(node, scene_file);
  if (kind == 1) {
    const JsonFields fields(node, {"type", "height", "material"});
    GroundPlane plane;
    if (const auto height = fields.find("height")) plane.height = height->number(k_coordinate);
    if (const auto material = fields.find("material")) plane.material = read_material(*material, false);
    return plane;
  }
  const JsonFields fields(node, {"type", "center", "radius", "material"});
  Sphere sphere;
  sphere.center = fields.require("center").vector(k_coordinate);
  sphere.radius = fields.require("radius").number(k_length);
  if (const auto material = fields.find("material")) sphere.material = read_material(*material, false);
  return sphere;
}

RenderSettings read_render_settings(const JsonNode& node) {
  const JsonFields fields(node, {"samples", "max_bounces", "seed", "mode", "ao_distance"});
  RenderSettings render;
  if (const auto samples = fields.find("samples"))
    render.samples = static_cast<int>(samples->whole_number(1, k_max_samples));
  if (const auto bounces = fields.find("max_bounces"))
    render.max_bounces = static_cast<int>(bounces->whole_number(0, k_max_bounces));
  if (const auto seed = fields.find("seed")) render.seed = seed->whole_number(0, UINT64_MAX);
  if (const auto mode = fields.find("mode")) render.mode = entry_of(*mode, k_modes).mode;
  if (const auto distance = fields.find("ao_distance")) render.ao_distance = length_or_auto(*distance);
  return render;
}

std::vector<image::Layer> read_layers(const JsonNode& node) {
  std::vector<image::Layer> layers;
  for (const JsonNode& each : node.elements(1, image::k_layers.size())) {
    const image::Layer layer = entry_of(each, image::k_layers).layer;
    if (std::ranges::find(layers, layer) != layers.end()) each.fail("duplicate layer", "unique layers");
    layers.push_back(layer);
  }
  return layers;
}

image::OutputSettings read_output_settings(const JsonNode& node, const std::filesystem::path& scene_file) {
  const JsonFields fields(node, {"file", "layers", "exposure", "precision", "transparent"});
  image::OutputSettings output;
  if (const auto file = fields.find("file")) {
    output.file = path_beside(scene_file, *file);
    if (!image::image_format(output.file))
      file->fail("unknown output format", "the extension .exr, .png, .jpg, .jpeg or .tif");
  }
  if (const auto layers = fields.find("layers")) output.layers = read_layers(*layers);
  if (const auto exposure = fields.find("exposure")) output.exposure = exposure->number({-64, 64});
  if (const auto transparent = fields.find("transparent")) output.transparent = transparent->boolean();
  if (const auto precision = fields.find("precision"))
    output.half = choice_of(*precision, {"half", "float"}) == 0;
  return output;
}

}  // namespace

Scene parse_scene(std::string_view text, const std::filesystem::path& name) {
  const JsonDocument document = parse_json(std::string(text), name.string());
  const JsonFields fields(JsonNode(document), {"version", "description", "cloud", "objects", "sky", "sun",
                                               "camera", "render", "output"});
  read_version(fields.require("version"));
  Scene scene;
  if (const auto description = fields.find("description")) description->text();
  if (const auto cloud = fields.find("cloud")) scene.cloud = read_cloud_settings(*cloud, name);
  if (const auto objects = fields.find("objects")) {
    for (const JsonNode& object : objects->elements(0, std::size_t(-1)))
      scene.objects.push_back(read_object(object, name));
  }
  if (const auto sky = fields.find("sky")) scene.sky = read_sky(*sky, name);
  if (const auto sun = fields.find("sun")) read_sun(*sun, scene);
  if (const auto camera = fields.find("camera")) {
    scene.camera = camera->is_string() ? camera::read_camera(path_beside(name, *camera))
                                       : camera::read_camera_node(*camera);
  }
  if (const auto render = fields.find("render")) scene.render = read_render_settings(*render);
  if (const auto output = fields.find("output")) scene.output = read_output_settings(*output, name);
  return scene;
}

Scene read_scene(const std::filesystem::path& file) {
  return parse_scene(read_text_file(file), file);
}

}  // namespace alidade::renderer
