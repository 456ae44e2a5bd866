// SPDX-License-Identifier: MIT
#include "renderer/scene_forms.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/words.h"
#include "camera/camera_json.h"
#include "octree/spacing.h"
#include "renderer/sun_forms.h"
#include "surface/point_surface.h"

namespace alidade::renderer {
namespace {

constexpr NumberRange k_share{0.0, 1.0};

/// A file, relative to the one that names it.
JsonForm<std::filesystem::path> file_form() {
  JsonForm<std::string> text = text_form();
  return {[](const JsonNode& node) -> std::filesystem::path {
            // Addresses of servers are not relative.
            if (node.text().find("://") != std::string::npos) return node.text();
            const std::filesystem::path folder = std::filesystem::path(node.document_name()).parent_path();
            return (folder / node.text()).lexically_normal();
          },
          [](const std::filesystem::path& file) { return Json(file.string()); }, std::move(text.schema)};
}

/// The names of a table and their values; behind `more`, where there are any.
template <class Value, class Entry, class Member, std::size_t count>
JsonForm<Value> names_form(const std::array<Entry, count>& table, Member Entry::*member,
                           std::vector<std::pair<std::string_view, Value>> more = {}) {
  for (const Entry& entry : table) more.emplace_back(entry.name, entry.*member);
  return word_form(std::move(more));
}

/// Errors: two values are equal. `noun`, `nouns`: what they are, in messages.
template <class Value>
void check_unique(const JsonNode& node, const std::vector<Value>& values, const std::string& noun,
                  const std::string& nouns) {
  const std::vector<JsonNode> nodes = node.elements(0, values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::ranges::count(std::span(values).first(i), values[i]) > 0)
      nodes[i].fail("duplicate " + noun, "unique " + nouns);
}

JsonForm<image::ValueRange> range_form(const NumberRange& allowed) {
  JsonForm<std::vector<double>> ends = list_form(number_form(allowed), 2, 2);
  return {[read = ends.read](const JsonNode& node) {
            const std::vector<double> values = read(node);
            if (!(values[0] < values[1])) node.fail("empty range", "the smaller number first");
            return image::ValueRange{values[0], values[1]};
          },
          [write = ends.write](const image::ValueRange& range) {
            return write({range.low, range.high});
          },
          std::move(ends.schema)};
}

JsonForm<Color16> hex_color_form() {
  return {[](const JsonNode& node) {
            const std::string text = node.text();
            const std::optional<Color16> color = image::parse_hex_color(text);
            if (!color) node.fail("invalid colour", "\"#rrggbb\" in hexadecimal");
            return *color;
          },
          [](const Color16& color) {
            // Only colours of 8 bits have a text of this form; others are for comparing.
            const Color16 bytes = color / std::uint16_t{257};
            if (color != bytes * std::uint16_t{257}) return Json{color.x, color.y, color.z};
            return Json(fmt::format("#{:02x}{:02x}{:02x}", bytes.x, bytes.y, bytes.z));
          },
          {{"type", "string"}, {"minLength", 1}, {"pattern", "^#[0-9A-Fa-f]{6}$"}}};
}

JsonForm<std::vector<image::ClassColor>> classes_form() {
  using image::ClassColor;
  JsonForm<std::vector<ClassColor>> list = list_form(
      object_form<ClassColor>(
          "",
          {key<ClassColor>("class", &ClassColor::number, whole_form<std::uint8_t>(0, 255),
                           "number of the class")
               .required(),
           key<ClassColor>("color", &ClassColor::color, hex_color_form(), "#rrggbb, display-referred")
               .required(),
           key<ClassColor>("name", &ClassColor::name, text_form(), "for legends, instead of the usual one")}),
      0, 256);
  list.read = [read = list.read](const JsonNode& node) {
    const std::vector<ClassColor> classes = read(node);
    std::vector<std::uint8_t> numbers;
    for (const ClassColor& each : classes) numbers.push_back(each.number);
    check_unique(node, numbers, "class", "classes");
    return classes;
  };
  return list;
}

/// "color" of a cloud: a word, or an object.
JsonForm<image::PointColoring> coloring_form() {
  using image::PointColoring;
  JsonForm<PointColoring> by{[](const JsonNode& node) { return image::coloring_by(node.text()); },
                             [](const PointColoring& coloring) { return Json(color_word(coloring)); },
                             text_form().schema};
  JsonForm<PointColoring> object = object_form<PointColoring>(
      "",
      {// Sets all, so it must be the first.
       key<PointColoring>(
           "by", std::identity(), by,
           "automatic: rgb if the cloud has colours, else classification if it has several classes and at "
           "least half of the points one other than unclassified and noise, else height; rgb, intensity, "
           "height, classification, normal, gps_time, return_number, number_of_returns; or any other "
           "attribute of the cloud by its name"),
       key<PointColoring>("map", &PointColoring::map,
                          names_form<std::optional<image::ColorMap>>(
                              image::k_color_maps, &image::NamedColorMap::map, {{"auto", {}}}),
                          "colour map of values; auto: grey for intensity, terrain for height, else viridis"),
       key<PointColoring>("range", &PointColoring::range,
                          word_or("auto", range_form({-image::k_largest_value, image::k_largest_value})),
                          "values of the first and last colour, the smaller first; auto: by percentiles"),
       key<PointColoring>("percentiles", &PointColoring::percentiles, range_form({0, 100}),
                          "the limits of the range auto, the smaller first"),
       key<PointColoring>("classes", &PointColoring::classes, classes_form(),
                          "classes with other colours or names than the usual ones, each class once")});
  return {[by, object](const JsonNode& node) { return (node.is_object() ? object : by).read(node); },
          [by, object](const PointColoring& coloring) {
            const Json all = object.write(coloring);
            const bool is_word = all == object.write(image::coloring_by(color_word(coloring)));
            return is_word ? by.write(coloring) : all;
          },
          {{"oneOf", {by.schema, object.schema}}}};
}

/// "albedo". What has no colour of its own must have one.
template <class Struct>
JsonKey<Struct> albedo_key(bool has_own_color) {
  JsonKey<Struct> albedo =
      key<Struct>("albedo", &Struct::albedo, rgb_form(k_share),
                  has_own_color ? "share of the light that is reflected; left out: the colours of its own"
                                : "share of the light that is reflected");
  return has_own_color ? albedo : std::move(albedo).required();
}

/// A form whose schema is among "$defs", in scene_form().
template <class Value>
JsonForm<Value> defined(JsonForm<Value> form, const std::string& name) {
  form.schema = {{"$ref", "#/$defs/" + name}};
  return form;
}

JsonForm<Material> any_material_form(const std::string& description, bool has_own_color,
                                     bool is_mesh = false) {
  std::vector<JsonKind<Material>> kinds{
      kind<Material>("lambertian", "reflects evenly in all directions",
                     JsonKeys<Lambertian>{albedo_key<Lambertian>(has_own_color)}),
      kind<Material>("metal", "reflects like a mirror, blurred by roughness",
                     JsonKeys<Metal>{albedo_key<Metal>(has_own_color),
                                     key<Metal>("roughness", &Metal::roughness, number_form(k_share),
                                                "0 is a perfect mirror, 1 the roughest")})};
  if (!is_mesh) {
    kinds.push_back(kind<Material>("dielectric", "clear glass or water",
                                   JsonKeys<Dielectric>{key<Dielectric>(
                                       "refractive_index", &Dielectric::refractive_index,
                                       number_form({0.1, 10}), "relative to air; glass 1.5, water 1.33")}));
    kinds.push_back(
        kind<Material>("emissive", "emits light, reflects none",
                       JsonKeys<Emissive>{key<Emissive>("radiance", &Emissive::radiance, rgb_form(k_light),
                                                        "the same in all directions")}));
  }
  return kinds_form(description, std::move(kinds));
}

/// Of what has no colour of its own.
JsonForm<Material> object_material_form() {
  return any_material_form("what the surface does with light", false);
}

JsonForm<Material> mesh_material_form() {
  return any_material_form("what the triangles do with light", true, true);
}

JsonForm<AdaptedRadius> adapted_radius_form() {
  return object_form<AdaptedRadius>(
      "radii that follow the density of the points",
      {key<AdaptedRadius>("neighbours", &AdaptedRadius::neighbours,
                          whole_form<int>(1, k_most_spacing_neighbours),
                          "n: the distance to the n-th nearest neighbour is used"),
       key<AdaptedRadius>("factor", &AdaptedRadius::factor, number_form(k_length),
                          "radius divided by the distance to the n-th neighbour; 0.75 leaves 1 % of a "
                          "surface of scattered points open, 1 leaves "
                          "none, 0.5 leaves a tenth; left out: 0.75, and 0.92 for discs"),
       key<AdaptedRadius>(
           "max", &AdaptedRadius::max, word_or("auto", number_form(k_length)),
           "the largest radius, which limits isolated points; auto: four times what the radius auto is")});
}

/// "radius" of a cloud: a word, a number, or an object.
JsonKey<CloudSettings> radius_key() {
  const JsonForm<std::optional<double>> one = word_or("auto", number_form(k_length));
  const JsonForm<AdaptedRadius> adapted = adapted_radius_form();
  Json schema{
      {"description",
       "radius of the spheres; auto: one radius from the measured distance between neighbours, which is "
       "printed and stored; an object: a radius per point, from the distance to its neighbours"},
      {"oneOf", one.schema["oneOf"]}};
  schema["oneOf"].push_back(adapted.schema);
  return {"radius", std::move(schema),
          [=](const JsonNode& node, CloudSettings& cloud) {
            if (node.is_object())
              cloud.adapted_radius = adapted.read(node);
            else
              cloud.radius = one.read(node);
          },
          [=](const CloudSettings& cloud) {
            return cloud.adapted_radius ? adapted.write(*cloud.adapted_radius) : one.write(cloud.radius);
          }};
}

JsonForm<ColorDepth> color_depth_form() {
  return {[](const JsonNode& node) {
            if (node.is_word("automatic")) return ColorDepth::automatic;
            const double bits = node.number({8, 16});
            if (bits != 8 && bits != 16) node.fail("invalid colour depth", "8, 16 or \"automatic\"");
            return bits == 8 ? ColorDepth::bits_8 : ColorDepth::bits_16;
          },
          [](ColorDepth depth) {
            return depth == ColorDepth::automatic ? Json("automatic")
                                                  : Json(depth == ColorDepth::bits_8 ? 8 : 16);
          },
          {{"enum", {"automatic", 8, 16}}}};
}

JsonKeys<CloudSettings> cloud_keys() {
  // The same as a list of one.
  JsonKey<CloudSettings> file = key<CloudSettings>(
      "file", [](auto& cloud) -> auto& { return cloud.files; },
      JsonForm<std::vector<std::filesystem::path>>{
          [form = file_form()](const JsonNode& node) { return std::vector{form.read(node)}; },
          [](const std::vector<std::filesystem::path>&) { return Json(); }, file_form().schema},
      "as files, for a single name");
  return {
      key<CloudSettings>(
          "files", &CloudSettings::files, list_form(file_form(), 1),
          "cloud files, folders of them, or patterns such as tiles/*.las, joined into one cloud")
          .without_default(),
      std::move(file),
      key<CloudSettings>(
          "partial", &CloudSettings::partial, boolean_form(),
          "whether to read the intact part of damaged files and report what is lost; otherwise a damaged "
          "file causes an error"),
      radius_key(),
      key<CloudSettings>(
          "hits", &CloudSettings::hits, word_form<HitMode>({{"entry", HitMode::entry}, {"t", HitMode::t}}),
          "entry: a ray hits the sphere that it enters first, as seen by an observer; t: it hits the point "
          "whose projection on the ray comes first, as in the paper"),
      key<CloudSettings>(
          "color", &CloudSettings::color, coloring_form(),
          "the attribute that colours the points: a name, such as rgb, height or classification, or an "
          "object"),
      key<CloudSettings>(
          "color_depth", &CloudSettings::color_depth, color_depth_form(),
          "bits in use in the 16-bit colour fields of LAS files; automatic: detected from the values"),
      key<CloudSettings>(
          "normals", &CloudSettings::normals,
          word_form<NormalMode>({{"sphere", NormalMode::sphere}, {"smooth", NormalMode::smooth}}),
          "sphere: the normal of each point's sphere; smooth: the normal of a plane fitted to the "
          "neighbouring points, which makes walls even. Glass points are always spheres"),
      key<CloudSettings>(
          "surface", &CloudSettings::shape,
          word_form<PointShape>(
              {{"sphere", PointShape::sphere}, {"disc", PointShape::disc}, {"blend", PointShape::blend}}),
          "what a point is to a ray. sphere: the sphere around it; disc: the disc of the plane fitted to its "
          "neighbours, or a small sphere where there is no plane; blend: the same discs, blended into one "
          "surface. Left out: blend, and sphere with a number as radius, other neighbours than 8, hits, "
          "normals, max_level or glass. Of discs, a number as radius, max_level and glass are errors")
          .without_default(),
      key<CloudSettings>(
          "max_level", &CloudSettings::max_level, whole_form<int>(0, k_max_level),
          "only the levels 0 to max_level of an index file made with --organisation layered: a thinned cloud "
          "with a matching radius, for quick previews"),
      key<CloudSettings>("material", &CloudSettings::material, defined(material_form(), "cloud_material"),
                         "")};
}

CloudSettings read_cloud_settings(const JsonNode& node, const JsonForm<CloudSettings>& form) {
  CloudSettings cloud = form.read(node);
  const auto files = node.find("files"), file = node.find("file");
  if (files && file) file->fail("\"file\" and \"files\" exclude each other", "one of them", "both");
  if (!files && !file) node.fail("missing key \"files\"", "\"files\" or \"file\"", "neither");
  if (node.find("surface")) return cloud;
  // What applies to spheres only selects them, as the options of 'alidade render' do.
  const bool are_spheres =
      cloud.radius || node.find("hits") || node.find("normals") || node.find("max_level") ||
      (cloud.adapted_radius && cloud.adapted_radius->neighbours != k_surface_neighbours) ||
      std::holds_alternative<Dielectric>(cloud.material);
  cloud.shape = are_spheres ? PointShape::sphere : PointShape::blend;
  return cloud;
}

JsonKeys<Model> mesh_keys() {
  const auto placement = [](auto member) {
    return [member](auto& model) -> auto& {
      return model.mesh->placement.*member;
    };
  };
  return {key<Model>(
              "file", [](auto& model) -> auto& { return model.mesh->file; }, file_form(),
              "triangles and polygons in a PLY or OBJ file")
              .required(),
          key<Model>("scale", placement(&MeshPlacement::scale), number_form(k_length),
                     "factor on the file's coordinates"),
          key<Model>("rotate_z", placement(&MeshPlacement::rotate_z), number_form(k_angle),
                     "degrees counterclockwise, seen from above"),
          key<Model>("translate", placement(&MeshPlacement::translate), vector_form(k_coordinate),
                     "world coordinates of the file's origin"),
          key<Model>("material", &Model::material, defined(mesh_material_form(), "mesh_material"),
                     "without albedo, the colours of the file, or grey where it has none")};
}

JsonForm<image::OutputSettings> output_form() {
  using image::OutputSettings;
  JsonForm<std::filesystem::path> file = file_form();
  file.schema["pattern"] = "[^/]\\.([eE][xX][rR]|[pP][nN][gG]|[jJ][pP][eE]?[gG]|[tT][iI][fF][fF]?)$";
  file.read = [read = file.read](const JsonNode& node) {
    const std::filesystem::path name = read(node);
    if (!image::image_format(name))
      node.fail("unknown output format", "the extension .exr, .png, .jpg, .jpeg or .tif");
    return name;
  };
  JsonForm<std::vector<image::Layer>> layers = list_form(
      names_form<image::Layer>(image::k_layers, &image::NamedLayer::layer), 1, image::k_layers.size());
  layers.schema["uniqueItems"] = true;
  layers.read = [read = layers.read](const JsonNode& node) {
    const std::vector<image::Layer> all = read(node);
    check_unique(node, all, "layer", "layers");
    return all;
  };
  return object_form<OutputSettings>(
      "the image file",
      {key<OutputSettings>(
           "file", &OutputSettings::file, std::move(file),
           "name of the image; the extension selects the format: .exr, .png, .jpg, .jpeg, .tif or .tiff "
           "(GeoTIFF, for orthophotos), in upper or lower case"),
       key<OutputSettings>("layers", &OutputSettings::layers, std::move(layers),
                           "groups of channels, for EXR; each once"),
       key<OutputSettings>("exposure", &OutputSettings::exposure, number_form({-64, 64}),
                           "stops: PNG, JPEG and GeoTIFF contain the colour times 2^exposure"),
       key<OutputSettings>(
           "transparent", &OutputSettings::transparent, boolean_form(),
           "whether the sky that the camera sees is left out: alpha in PNG and GeoTIFF, premultiplied "
           "colours in EXR"),
       key<OutputSettings>("precision", &OutputSettings::half,
                           word_form<bool>({{"half", true}, {"float", false}}),
                           "of colour, normal and albedo in EXR")});
}

JsonForm<camera::Camera> camera_form() {
  Json schema{{"oneOf", {file_form().schema, {{"$ref", "camera.schema.json#/$defs/camera"}}}}};
  return {[file = file_form()](const JsonNode& node) {
            return node.is_string() ? camera::read_camera(file.read(node)) : camera::read_camera_node(node);
          },
          [](const camera::Camera& camera) {
            // Minus zero, which parses as a signed integer, keeps its sign.
            const auto keep_sign = [](int, Json::parse_event_t, Json& value) {
              if (value.is_number_integer() && !value.is_number_unsigned() && value == 0) value = -0.0;
              return true;
            };
            return Json::parse(camera::camera_json(camera), keep_sign);
          },
          std::move(schema)};
}

JsonKeys<Scene> scene_keys() {
  JsonKey<Scene> version{"version",
                         {{"description", "version of this format"}, {"const", 1}},
                         [](const JsonNode& node, Scene&) { read_version(node); },
                         [](const Scene&) { return Json(1); }};
  JsonKey<Scene> description{"description",
                             {{"description", "any text"}, {"type", "string"}, {"minLength", 1}},
                             [](const JsonNode& node, Scene&) { node.text(); },
                             [](const Scene&) { return Json(); }};
  return {std::move(version).required(),
          std::move(description),
          key<Scene>("cloud", &Scene::cloud, cloud_form(), "the point cloud; left out: none"),
          key<Scene>("objects", &Scene::objects, list_form(scene_object_form(), 0),
                     "what stands in the scene beside the cloud"),
          key<Scene>("sky", &Scene::sky, sky_form(), ""),
          sun_key(),
          key<Scene>("camera", &Scene::camera, camera_form(),
                     "a camera, or the name of a camera file; left out: a view of the whole cloud"),
          key<Scene>("render", &Scene::render, render_form(), ""),
          key<Scene>("output", &Scene::output, output_form(), "")};
}

}  // namespace

const JsonForm<Material>& material_form() {
  static const JsonForm<Material> form = any_material_form("what the points do with light", true);
  return form;
}

const JsonForm<CloudSettings>& cloud_form() {
  static const JsonForm<CloudSettings> form = [] {
    JsonForm<CloudSettings> keys = object_form<CloudSettings>("the point cloud", cloud_keys());
    keys.read = [keys](const JsonNode& node) { return read_cloud_settings(node, keys); };
    keys.schema["oneOf"] = {{{"required", {"files"}}}, {{"required", {"file"}}}};
    return keys;
  }();
  return form;
}

const JsonForm<Object>& scene_object_form() {
  static const JsonForm<Object> form = [] {
    const JsonForm<Material> material = defined(object_material_form(), "object_material");
    Model mesh;
    mesh.mesh.emplace();
    return kinds_form<Object>(
        "",
        {kind<Object>(
             "sphere", "a sphere",
             JsonKeys<Sphere>{
                 key<Sphere>("center", &Sphere::center, vector_form(k_coordinate), "world coordinates")
                     .required(),
                 key<Sphere>("radius", &Sphere::radius, number_form(k_length), "").required(),
                 key<Sphere>("material", &Sphere::material, material, "")}),
         kind<Object>(
             "ground_plane", "an infinite horizontal plane",
             JsonKeys<GroundPlane>{
                 key<GroundPlane>("height", &GroundPlane::height, number_form(k_coordinate), "its z"),
                 key<GroundPlane>("material", &GroundPlane::material, material, "")}),
         kind<Object>("mesh",
                      "the triangles of a file, seen from both sides: scaled about the file's origin, turned "
                      "about it, then moved",
                      mesh_keys(), mesh)});
  }();
  return form;
}

const JsonForm<RenderSettings>& render_form() {
  static const JsonForm<RenderSettings> form = object_form<RenderSettings>(
      "how the image is computed",
      {key<RenderSettings>("samples", &RenderSettings::samples, whole_form<int>(1, k_max_samples),
                           "paths per pixel"),
       key<RenderSettings>("max_bounces", &RenderSettings::max_bounces, whole_form<int>(0, k_max_bounces),
                           "most scattering events of a path after its first surface"),
       key<RenderSettings>("seed", &RenderSettings::seed, whole_form<std::uint64_t>(0, UINT64_MAX),
                           "seed of the random numbers; a different seed gives different noise"),
       key<RenderSettings>(
           "mode", &RenderSettings::mode, names_form<RenderMode>(k_modes, &NamedMode::mode),
           "path: light of sun, sky and lamps; ambient_occlusion: colours, darkened where other surfaces are "
           "near; headlight: colours lit from the camera; flat: the colours themselves"),
       key<RenderSettings>("ao_distance", &RenderSettings::ao_distance,
                           word_or("auto", number_form(k_length)),
                           "range of ambient occlusion; auto: a twentieth of the cloud's diagonal")});
  return form;
}

const JsonForm<Sky>& sky_form() {
  static const JsonForm<Sky> form = kinds_form<Sky>(
      "light from all directions",
      {kind<Sky>("constant", "the same from all directions, also from below",
                 JsonKeys<ConstantSky>{
                     key<ConstantSky>("radiance", &ConstantSky::radiance, rgb_form(k_light), "")}),
       kind<Sky>("gradient", "changes from horizon to zenith with the sine of the elevation",
                 JsonKeys<GradientSky>{key<GradientSky>("horizon", &GradientSky::horizon, rgb_form(k_light),
                                                        "radiance at the horizon and below"),
                                       key<GradientSky>("zenith", &GradientSky::zenith, rgb_form(k_light),
                                                        "radiance straight above")}),
       kind<Sky>("image", "an environment map with the layout of a panorama",
                 JsonKeys<ImageSky>{
                     key<ImageSky>("file", &ImageSky::file, file_form(),
                                   "EXR, HDR or another image; formats of whole numbers are sRGB")
                         .required(),
                     key<ImageSky>("scale", &ImageSky::scale, number_form(k_light),
                                   "factor on the values of the image"),
                     key<ImageSky>("rotation", &ImageSky::rotation, number_form(k_angle),
                                   "azimuth of the middle column, degrees clockwise from north (+y)")})});
  return form;
}

const JsonForm<Scene>& scene_form() {
  static const JsonForm<Scene> form = [] {
    JsonForm<Scene> keys = object_form<Scene>(
        "Lengths are in the unit of the cloud's reference system, mostly metres; z is up; paths are relative "
        "to the file.",
        scene_keys());
    Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                {"$id", "scene.schema.json"},
                {"title", "Alidade scene"}};
    schema.update(keys.schema);
    schema["$defs"] = {{"cloud_material", material_form().schema},
                       {"mesh_material", mesh_material_form().schema},
                       {"object_material", object_material_form().schema}};
    keys.schema = std::move(schema);
    return keys;
  }();
  return form;
}

std::string meaning_of(const std::string& key) {
  const Json* schema = &scene_form().schema;
  std::vector<std::string_view> steps;
  split_cells(key, '/', steps);
  for (const std::string_view step : steps) {
    // Of a value in several forms, the last one is the object.
    if (!schema->contains("properties")) schema = &schema->at("oneOf").back();
    schema = &schema->at("properties").at(std::string(step));
  }
  return schema->at("description");
}

}  // namespace alidade::renderer
