// SPDX-License-Identifier: MIT
#include "renderer/read_scene.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <system_error>

#include "base/error.h"
#include "image/image_file.h"
#include "octree/spacing.h"
#include "renderer/read_scene_parts.h"

namespace alidade {
namespace {

/// A length, or nothing for "auto".
std::optional<double> length_or_auto(const JsonNode& node) {
  constexpr std::array<std::string_view, 1> words{"auto"};
  if (!node.is_string()) return node.number(k_length);
  node.choice(words);
  return {};
}

AdaptedRadius read_adapted_radius(const JsonNode& node) {
  const JsonFields fields(node, {"neighbours", "factor", "max"});
  AdaptedRadius radius;
  if (const auto neighbours = fields.find("neighbours"))
    radius.neighbours = static_cast<int>(neighbours->whole_number(1, k_most_spacing_neighbours));
  if (const auto factor = fields.find("factor")) radius.factor = factor->number(k_length);
  if (const auto max = fields.find("max")) {
    constexpr std::array<std::string_view, 1> words{"auto"};
    if (max->is_string())
      max->choice(words);
    else
      radius.max = max->number(k_length);
  }
  return radius;
}

CloudSettings read_cloud_settings(const JsonNode& node, const std::filesystem::path& scene_file) {
  const JsonFields fields(node, {"files", "file", "partial", "radius", "hits", "color", "color_depth",
                                 "normals", "max_level", "material"});
  CloudSettings cloud;
  const auto files = fields.find("files"), file = fields.find("file");
  if (files && file) file->fail("both \"file\" and \"files\"", "one of them", "the second");
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
  if (const auto hits = fields.find("hits")) {
    constexpr std::array<std::string_view, 2> words{"entry", "t"};
    cloud.hits = std::array{HitMode::entry, HitMode::t}[hits->choice(words)];
  }
  if (const auto color = fields.find("color")) cloud.color = read_coloring(*color);
  if (const auto max_level = fields.find("max_level"))
    cloud.max_level = static_cast<int>(max_level->whole_number(0, k_max_level));
  if (const auto depth = fields.find("color_depth")) {
    constexpr std::array<std::string_view, 1> words{"automatic"};
    if (depth->is_string()) {
      depth->choice(words);
    } else {
      const double bits = depth->number({8, 16});
      if (bits != 8 && bits != 16) depth->fail("unknown color depth", "8, 16 or \"automatic\"");
      cloud.color_depth = bits == 8 ? ColorDepth::bits_8 : ColorDepth::bits_16;
    }
  }
  if (const auto normals = fields.find("normals")) {
    constexpr std::array<std::string_view, 2> words{"sphere", "smooth"};
    cloud.normals = std::array{NormalMode::sphere, NormalMode::smooth}[normals->choice(words)];
  }
  if (const auto material = fields.find("material")) cloud.material = read_material(*material, true);
  return cloud;
}

Object read_object(const JsonNode& node) {
  constexpr std::array<std::string_view, 2> types{"sphere", "ground_plane"};
  const JsonNode type = type_of(node, {"type", "center", "radius", "height", "material"});
  if (type.choice(types) == 1) {
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
  if (const auto samples = fields.find("samples")) {
    render.samples = static_cast<int>(samples->whole_number(1, k_max_samples));
  }
  if (const auto bounces = fields.find("max_bounces")) {
    render.max_bounces = static_cast<int>(bounces->whole_number(0, k_max_bounces));
  }
  if (const auto seed = fields.find("seed")) render.seed = seed->whole_number(0, UINT64_MAX);
  if (const auto mode = fields.find("mode")) {
    std::array<std::string_view, k_modes.size()> words;
    std::ranges::transform(k_modes, words.begin(), &NamedMode::name);
    render.mode = k_modes[mode->choice(words)].mode;
  }
  if (const auto distance = fields.find("ao_distance")) render.ao_distance = length_or_auto(*distance);
  return render;
}

std::vector<Layer> read_layers(const JsonNode& node) {
  std::array<std::string_view, k_layers.size()> words;
  std::ranges::transform(k_layers, words.begin(), &NamedLayer::name);
  std::vector<Layer> layers;
  for (const JsonNode& each : node.elements(1, words.size())) {
    const Layer layer = k_layers[each.choice(words)].layer;
    for (const Layer earlier : layers) {
      if (earlier == layer) each.fail("layer stands twice", "every layer once");
    }
    layers.push_back(layer);
  }
  return layers;
}

OutputSettings read_output_settings(const JsonNode& node, const std::filesystem::path& scene_file) {
  const JsonFields fields(node, {"file", "layers", "exposure", "precision"});
  OutputSettings output;
  if (const auto file = fields.find("file")) {
    output.file = path_beside(scene_file, *file);
    if (!image_format(output.file))
      file->fail("unknown kind of image", "a name that ends in .exr, .png, .jpg, .jpeg or .tif");
  }
  if (const auto layers = fields.find("layers")) output.layers = read_layers(*layers);
  if (const auto exposure = fields.find("exposure")) output.exposure = exposure->number({-64, 64});
  if (const auto precision = fields.find("precision")) {
    constexpr std::array<std::string_view, 2> words{"half", "float"};
    output.half = precision->choice(words) == 0;
  }
  return output;
}

}  // namespace

void read_version(const JsonNode& version) {
  if (version.number({-1e9, 1e9}) != 1) version.fail("unknown version", "1");
}

std::filesystem::path path_beside(const std::filesystem::path& scene_file, const JsonNode& node) {
  // A server's name lies beside nothing.
  if (node.text().find("://") != std::string::npos) return node.text();
  return (scene_file.parent_path() / node.text()).lexically_normal();
}

Rgb read_rgb(const JsonNode& node, const NumberRange& range) {
  return Rgb(node.vector(range));
}

std::string read_text_file(const std::filesystem::path& file, std::uintmax_t largest) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw Error({.file = file.string(), .problem = "no such file"});
  if (!std::filesystem::is_regular_file(status))
    throw Error({.file = file.string(), .problem = "not a regular file"});
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > largest) {
    throw Error({.file = file.string(),
                 .problem = "too large for a scene or camera",
                 .expected = "at most " + std::to_string(largest >> 20) + " MiB"});
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text(size, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(size));
  if (!stream && !stream.eof()) throw Error({.file = file.string(), .problem = "cannot be read"});
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

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
      scene.objects.push_back(read_object(object));
  }
  if (const auto sky = fields.find("sky")) scene.sky = read_sky(*sky, name);
  if (const auto sun = fields.find("sun")) read_sun(*sun, scene);
  if (const auto camera = fields.find("camera")) {
    scene.camera = camera->is_string() ? read_camera(path_beside(name, *camera)) : read_camera_node(*camera);
  }
  if (const auto render = fields.find("render")) scene.render = read_render_settings(*render);
  if (const auto output = fields.find("output")) scene.output = read_output_settings(*output, name);
  return scene;
}

Camera parse_camera(std::string_view text, const std::filesystem::path& name) {
  const JsonDocument document = parse_json(std::string(text), name.string());
  const JsonNode node(document);
  const Camera camera = read_camera_node(node);
  if (!node.find("version")) node.fail("missing key \"version\"", "the key", "an object without it");
  return camera;
}

Scene read_scene(const std::filesystem::path& file) {
  return parse_scene(read_text_file(file), file);
}
Camera read_camera(const std::filesystem::path& file) {
  return parse_camera(read_text_file(file), file);
}

}  // namespace alidade
