// SPDX-License-Identifier: MIT
#include "jobs/render/render_request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <fstream>
#include <functional>
#include <variant>

#include "base/error.h"
#include "base/words.h"
#include "jobs/load_cloud.h"
#include "jobs/mesh_files.h"
#include "octree/spacing.h"
#include "renderer/read_scene.h"
#include "renderer/scene_forms.h"
#include "simulation/courtyard.h"
#include "surface/point_surface.h"

namespace alidade::jobs {
namespace {

/// Whether something was given to the field of this name.
bool is_given(const RenderRequest& request, std::string_view name) {
  return std::ranges::any_of(request.checkpoint.fields->given(), [name](const auto& field) {
    return field.first == name && !field.second.empty();
  });
}

double parse_positive(const std::string& text, const std::string& expected) {
  const double value = parse_number(text);
  if (!(value > 0.0)) throw UsageError("invalid value; expected " + expected + ", found '" + text + "'");
  return value;
}

/// Two numbers separated by a comma; blanks around the comma are ignored, as maps on the web print them.
glm::dvec2 parse_pair(const std::string& text, double largest_first, double largest_second) {
  const std::vector<std::string> words = split_list(text, 2, "two numbers separated by a comma");
  return {parse_number(std::string(trim(words[0])), -largest_first, largest_first),
          parse_number(std::string(trim(words[1])), -largest_second, largest_second)};
}

/// Whether a file is a scene, by its name or its first character: clouds of text do not begin with a brace.
bool is_scene(const std::filesystem::path& file) {
  if (file_extension(file) == ".json") return true;
  std::error_code failure;
  if (!std::filesystem::is_regular_file(file, failure)) return false;
  std::ifstream stream(file);
  char first = ' ';
  stream >> std::ws >> first;
  return stream && first == '{';
}

void take_clouds(const std::vector<std::string>& words, RenderRequest& request) {
  request.files = request.view.apply(
      resolve_clouds(std::vector<std::filesystem::path>(words.begin(), words.end()), cloud_formats()));
  request.scene = renderer::daylight_scene(request.files.names());
}

void take_scene_or_clouds(const std::vector<std::string>& words, RenderRequest& request) {
  const auto scene = std::ranges::find_if(words, is_scene);
  if (scene == words.end()) return take_clouds(words, request);
  if (words.size() > 1)
    throw UsageError("invalid operands; expected one scene file, or clouds, found the scene '" + *scene +
                     "' and " + std::to_string(words.size() - 1) + " more");
  request.scene_file = *scene;
  request.scene = renderer::read_scene(request.scene_file);
}

/// Replaces the scene's cloud by the site.
void take_site(RenderRequest& request) {
  if (!request.files.empty())
    throw input_error("--site does not apply to a cloud", "the site alone, or a scene file");
  renderer::Scene& scene = request.scene;
  renderer::Model model{std::make_shared<simulation::Site>(simulation::courtyard()), "courtyard"};
  if (scene.cloud) model.material = scene.cloud->material;
  if (std::holds_alternative<renderer::Dielectric>(model.material))
    throw file_error(request.scene_file, "--site does not support glass as the cloud's material");
  scene.cloud.reset();
  scene.objects.emplace_back(std::move(model));
  request.adds_models = true;
}

void add_surfaces(const Fields& fields, RenderRequest& request) {
  request.view = add_view_fields(fields);
  const Field scene = fields.words(
      "scene", "SCENE.json|CLOUD...",
      "scene file; or " + k_files_help + ", rendered without one" + database_help(),
      [&request](const std::vector<std::string>& words) { take_scene_or_clouds(words, request); });
  const Field cloud = fields.excludes(scene).words(
      "--cloud", "FILE...", "the same as CLOUD",
      [&request](const std::vector<std::string>& words) { take_clouds(words, request); });
  fields.excludes(cloud).value(
      "--site", "courtyard",
      "render the exact surfaces of the site that 'alidade generate' scans, in place of the "
      "scene's cloud: the truth for renders of its scans",
      [&request](const std::string& text) {
        if (text != "courtyard") throw UsageError("invalid value; expected courtyard, found '" + text + "'");
        take_site(request);
      });
  add_mesh_field(fields, "beside the cloud or the scene", [&request](const std::string& file) {
    request.scene.objects.emplace_back(renderer::Model{.surfaces = {}, .mesh = renderer::MeshFile{file, {}}});
    request.adds_models = true;
  });
}

void add_output(const Fields& fields, RenderRequest& request) {
  fields.file("-o,--output", "FILE",
              "output image: .png, .jpg, .exr or .tif (default: the scene's); for a set of cameras with %04d "
              "(number, from 0), %s (name of the photograph) or %f (the same with folders and extension)",
              request.output);
  fields.flag(
      "--in-view",
      "read only the points of a database cloud that the cameras see: others cast no shadow, send no light, "
      "and do not affect automatic radii, colour ranges and the smooth normals of points at the border",
      request.in_view);
  fields.flag("--overwrite", "replace an existing image", request.overwrite);
  fields.flag("--skip-existing", "skip existing images, to continue an interrupted set",
              request.skips_existing);
}

/// Errors: the scene's images show no light of the sun and of surfaces.
void require_path_mode(const renderer::Scene& scene, const std::string& field) {
  if (scene.render.mode == renderer::RenderMode::path) return;
  const auto mode = std::ranges::find(renderer::k_modes, scene.render.mode, &renderer::NamedMode::mode);
  throw input_error(field + " does not apply to this mode", "--mode path", std::string(mode->name));
}

/// A sun that gets another position in the sky keeps its brightness.
void take_sun(const std::optional<glm::dvec2>& angles, renderer::Scene& scene) {
  geo::Sun sun = scene.sun.value_or(geo::Sun{});
  if (scene.sun_by_time) {
    sun.angular_diameter = scene.sun_by_time->angular_diameter;
    sun.irradiance = scene.sun_by_time->irradiance.value_or(sun.irradiance);
  }
  scene.sun.reset();
  scene.sun_by_time.reset();
  if (!angles) return;
  sun.azimuth = angles->x;
  sun.elevation = angles->y;
  scene.sun = sun;
}

/// A sun that gets another time keeps all else; one that had no time keeps its angular diameter only, since
/// brightness depends on elevation.
void take_sun_time(const Moment& moment, renderer::Scene& scene) {
  if (!scene.sun_by_time) {
    scene.sun_by_time.emplace();
    if (scene.sun) scene.sun_by_time->angular_diameter = scene.sun->angular_diameter;
  }
  scene.sun_by_time->moment = moment;
  scene.sun.reset();
}

void add_sun(const Fields& fields, RenderRequest& request) {
  const Field sun = fields.value(
      "--sun", "AZIMUTH,ELEVATION",
      "position of the sun, degrees: azimuth clockwise from north (+y), elevation above the "
      "horizon; the scene's brightness is kept",
      [&request](const std::string& text) {
        const glm::dvec2 angles = parse_pair(text, 360.0, 90.0);
        if (angles.y == -90.0)
          throw UsageError("invalid value; expected an elevation above -90, found '" + text + "'");
        require_path_mode(request.scene, "--sun");
        take_sun(angles, request.scene);
        request.has_given_sun = true;
      });
  const Field time =
      fields.excludes(sun).value("--sun-time", "DATE-TIME",
                                 "the sun at this time, such as 2026-06-21T12:00:00+02:00; brightness by "
                                 "elevation, even if the scene's sun by angles sets one",
                                 [&request](const std::string& text) {
                                   const Moment moment = parse_moment(text);
                                   require_path_mode(request.scene, "--sun-time");
                                   take_sun_time(moment, request.scene);
                                 });
  const Field place = fields.excludes(sun).value(
      "--sun-place", "LAT,LON",
      "latitude and longitude for --sun-time, degrees (default: from the cloud's reference system)",
      [&request](const std::string& text) {
        const glm::dvec2 degrees = parse_pair(text, 90.0, 180.0);
        require_path_mode(request.scene, "--sun-place");
        if (!request.scene.sun_by_time)
          throw input_error("--sun-place requires --sun-time", "--sun-time DATE-TIME", "none");
        request.scene.sun_by_time->latitude = degrees.x;
        request.scene.sun_by_time->longitude = degrees.y;
      });
  fields.excludes(sun).excludes(time).excludes(place).flag(
      "--no-sun", "no sun, only the sky", [&request] { take_sun(std::nullopt, request.scene); });
}

void add_light(const Fields& fields, RenderRequest& request) {
  fields.choice("--mode", renderer::meaning_of("render/mode") + " (default path)", request.scene.render.mode,
                [] {
                  std::vector<std::pair<std::string, renderer::RenderMode>> words;
                  for (const renderer::NamedMode& each : renderer::k_modes)
                    words.emplace_back(each.name, each.mode);
                  return words;
                }());
  fields.value("--ao-distance", "METRES|auto", renderer::meaning_of("render/ao_distance") + " (default auto)",
               [&render = request.scene.render](const std::string& text) {
                 render.ao_distance =
                     text == "auto" ? std::nullopt : std::optional(parse_number(text, 1e-6, 1e12));
                 if (render.mode != renderer::RenderMode::ambient_occlusion)
                   throw input_error("--ao-distance requires ambient occlusion", "--mode ambient_occlusion");
               });
  add_sun(fields, request);
}

std::string layer_list() {
  std::vector<std::string_view> names;
  for (const image::NamedLayer& known : image::k_layers) names.push_back(known.name);
  return fmt::format("{}", fmt::join(names, ","));
}

/// Takes layers of both kinds: those of EXR, and those of GeoTIFF.
void take_layers(const std::string& text, RenderRequest& request) {
  request.layers.clear();
  request.ground.layers.clear();
  const std::vector<std::string> words = split_list(text);
  for (const std::string& word : words) {
    const auto known = std::ranges::find(image::k_layers, word, &image::NamedLayer::name);
    const auto ground =
        std::ranges::find(k_ground_layers, word, [](const char* name) { return std::string(name); });
    if (std::ranges::count(words, word) > 1)
      throw UsageError("duplicate layer; expected each layer once, found '" + word + "'");
    if (known != image::k_layers.end())
      request.layers.push_back(known->layer);
    else if (ground != std::end(k_ground_layers))
      request.ground.layers.push_back(static_cast<GroundLayer>(ground - k_ground_layers));
    else
      throw UsageError(
          fmt::format("unknown layer; expected one of {} or of a GeoTIFF one of color,{}, found '{}'",
                      layer_list(), fmt::join(k_ground_layers, ","), word));
  }
  request.ground.with_color = !request.layers.empty();
}

void take_exposure(const std::string& text, RenderRequest& request) {
  request.has_auto_exposure = text == "auto";
  if (text == "auto") return;
  if (text.find_first_of("0123456789") == text.npos)
    throw UsageError("invalid value; expected a number of stops or auto, found '" + text + "'");
  request.scene.output.exposure = parse_number(text, -64.0, 64.0);
}

void add_image(const Fields& fields, RenderRequest& request) {
  fields.count(
      "--samples", "N",
      "paths per pixel; noise halves with four times as many (default: the scene's, else 50; 16 for an "
      "overview)",
      request.samples, 1, renderer::k_max_samples);
  fields.value(
      "--max-bounces", "N",
      "scattering events after the first surface (default 8; 0: direct light of sun, sky and lamps only)",
      [&scene = request.scene](const std::string& text) {
        scene.render.max_bounces = static_cast<int>(parse_count(text, 0, renderer::k_max_bounces));
        require_path_mode(scene, "--max-bounces");
      });
  fields.value(
      "--exposure", "STOPS|auto",
      "brightness of PNG, JPEG and GeoTIFF: +1 is twice as bright; auto: the first view's surfaces get a "
      "medium brightness (default: auto for an overview, without a scene and a camera, else the scene's)",
      [&request](const std::string& text) { take_exposure(text, request); });
  fields.flag("--transparent",
              "leave the sky out: PNG, EXR and GeoTIFF have alpha 0 where the camera sees no surface",
              request.scene.output.transparent);
  fields.value("--layers", "LIST",
               fmt::format("layers of an EXR: {}; rasters of --orthographic as GeoTIFF: color,{}, each in a "
                           "file of its own, such as site_elevation.tif (default color)",
                           layer_list(), fmt::join(k_ground_layers, ",")),
               [&request](const std::string& text) { take_layers(text, request); });
  fields.count("--seed", "N", renderer::meaning_of("render/seed") + " (default 1)", request.scene.render.seed,
               0, UINT64_MAX);
}

void take_radius(const std::string& text, renderer::CloudSettings& cloud) {
  cloud.radius.reset();
  if (text == "adapted") {
    if (!cloud.adapted_radius) cloud.adapted_radius.emplace();
    return;
  }
  cloud.adapted_radius.reset();
  if (text != "auto") cloud.radius = parse_positive(text, "auto, adapted or a positive length");
}

/// A field that applies to spheres only makes the points spheres, unless --surface is given.
void use_spheres(RenderRequest& request) {
  if (!is_given(request, "surface")) request.scene.cloud->shape = renderer::PointShape::sphere;
}

void add_radius(const Fields& fields, RenderRequest& request) {
  fields.value(
      "--radius", "R|auto|adapted",
      "radius of the points, metres; auto: one radius from the spacing, of discs adapted; adapted: one per "
      "point from the distance to its neighbours, small where the scan is dense (default auto)",
      [&request](const std::string& text) {
        renderer::CloudSettings& cloud = cloud_settings(request, "--radius");
        take_radius(text, cloud);
        if (cloud.radius) use_spheres(request);
      });
  // Each of these requests adapted radii; they are read after --radius.
  const auto add = [&](const std::string& key, const std::string& kind,
                       const std::function<void(const std::string&, renderer::AdaptedRadius&)>& take) {
    const std::string name = "--radius-" + key;
    const std::string help = renderer::meaning_of("cloud/radius/" + key) + "; implies --radius adapted";
    fields.value(name, kind, help, [&request, name, take](const std::string& text) {
      renderer::CloudSettings& cloud = cloud_settings(request, name);
      if (is_given(request, "radius") && !cloud.adapted_radius) throw UsageError("requires --radius adapted");
      take_radius("adapted", cloud);
      take(text, *cloud.adapted_radius);
      if (name == "--radius-neighbours" && cloud.adapted_radius->neighbours != k_surface_neighbours)
        use_spheres(request);
    });
  };
  add("factor", "F", [](const std::string& text, renderer::AdaptedRadius& adapted) {
    adapted.factor = parse_positive(text, "a positive number");
  });
  add("neighbours", "N", [](const std::string& text, renderer::AdaptedRadius& adapted) {
    adapted.neighbours = static_cast<int>(parse_count(text, 1, k_most_spacing_neighbours));
  });
  add("max", "R|auto", [](const std::string& text, renderer::AdaptedRadius& adapted) {
    adapted.max.reset();
    if (text != "auto") adapted.max = parse_positive(text, "auto or a positive length");
  });
}

/// A given field that applies to spheres only; empty if there is none.
std::string sphere_field(const RenderRequest& request, const renderer::CloudSettings& cloud) {
  if (is_given(request, "radius") && cloud.radius) return "--radius METRES";
  if (is_given(request, "radius-neighbours") && cloud.adapted_radius->neighbours != k_surface_neighbours)
    return "--radius-neighbours";
  for (const char* const name : {"hits", "normals", "max-level"})
    if (is_given(request, name)) return std::string("--") + name;
  return {};
}

void take_surface(renderer::PointShape shape, RenderRequest& request) {
  renderer::CloudSettings& cloud = cloud_settings(request, "--surface");
  request.has_given_shape = true;
  cloud.shape = shape;
  if (shape == renderer::PointShape::sphere) return;
  if (const std::string only_spheres = sphere_field(request, cloud); !only_spheres.empty())
    throw input_error(only_spheres + " has no effect on discs", "--surface sphere, or no such option");
}

void add_points(const Fields& fields, RenderRequest& request) {
  fields.choice<ColorDepth>(
      "--color-depth", "bits in use in LAS colour fields (default: detected from the values)",
      {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}},
      [&request](ColorDepth depth) { cloud_settings(request, "--color-depth").color_depth = depth; });
  fields.choice<renderer::HitMode>("--hits", renderer::meaning_of("cloud/hits") + " (default entry)",
                                   {{"entry", renderer::HitMode::entry}, {"t", renderer::HitMode::t}},
                                   [&request](renderer::HitMode hits) {
                                     cloud_settings(request, "--hits").hits = hits;
                                     use_spheres(request);
                                   });
  fields.choice<renderer::NormalMode>(
      "--normals", renderer::meaning_of("cloud/normals") + " (default: the scene's; smooth without a scene)",
      {{"sphere", renderer::NormalMode::sphere}, {"smooth", renderer::NormalMode::smooth}},
      [&request](renderer::NormalMode normals) {
        cloud_settings(request, "--normals").normals = normals;
        use_spheres(request);
      });
  fields.choice<renderer::PointShape>(
      "--surface", renderer::meaning_of("cloud/surface"),
      {{"sphere", renderer::PointShape::sphere},
       {"disc", renderer::PointShape::disc},
       {"blend", renderer::PointShape::blend}},
      [&request](renderer::PointShape shape) { take_surface(shape, request); });
  fields.value("--max-level", "N", renderer::meaning_of("cloud/max_level") + " (default: all levels)",
               [&request](const std::string& text) {
                 const auto level = static_cast<int>(parse_count(text, 0, renderer::k_max_level));
                 cloud_settings(request, "--max-level").max_level = level;
                 use_spheres(request);
               });
}

image::ValueRange parse_range(const std::string& text, double least, double most) {
  const std::vector<std::string> ends = split_list(text, 2, "two numbers");
  const image::ValueRange range{parse_number(ends[0], least, most), parse_number(ends[1], least, most)};
  if (!(range.low < range.high))
    throw UsageError("limits out of order; expected the smaller number first, found '" + text + "'");
  return range;
}

/// Another attribute to colour by replaces all of the colouring: map and range belong to the scene's.
void take_color(const std::string& text, image::PointColoring& coloring) {
  if (text.empty()) throw UsageError("missing value; expected a name");
  if (text != image::color_word(coloring)) coloring = image::coloring_by(text);
}

void take_class_colors(const std::string& text, image::PointColoring& coloring) {
  for (const std::string& part : split_list(text)) {
    const std::size_t sign = part.find('=');
    const std::optional<Color16> color =
        sign == std::string::npos ? std::nullopt : image::parse_hex_color(part.substr(sign + 1));
    if (!color) throw UsageError("invalid value; expected CLASS=#rrggbb, found '" + part + "'");
    const auto number = static_cast<std::uint8_t>(parse_count(part.substr(0, sign), 0, 255));
    const auto known = std::ranges::find(coloring.classes, number, &image::ClassColor::number);
    if (known == coloring.classes.end())
      coloring.classes.push_back({number, *color});
    else
      known->color = *color;
  }
}

std::filesystem::path parse_legend(const std::string& text) {
  const std::filesystem::path file(text);
  if (file.extension() != ".png" && file.extension() != ".PNG")
    throw UsageError("unknown output format; expected the extension .png, found '" + text + "'");
  return file;
}

glm::ivec2 parse_legend_size(const std::string& text) {
  // Margins and a line of the smallest type take more than this, whatever the text of the legend.
  constexpr int k_least_side = 24;
  const ImageSize size = parse_image_size(text);
  if (size.width < k_least_side || size.height < k_least_side) {
    throw UsageError("invalid value; expected at least " + std::to_string(k_least_side) +
                     " pixels in each direction, found '" + text + "'");
  }
  return {size.width, size.height};
}

void add_colors(const Fields& fields, RenderRequest& request) {
  const auto coloring = [&request](const char* field) -> image::PointColoring& {
    return cloud_settings(request, field).color;
  };
  fields.value("--color-by,--color", "NAME",
               "what colours the points. " + renderer::meaning_of("cloud/color/by") + " (default automatic)",
               [coloring](const std::string& text) { take_color(text, coloring("--color-by")); });
  std::vector<std::pair<std::string, std::optional<image::ColorMap>>> maps{{"auto", std::nullopt}};
  for (const image::NamedColorMap& known : image::k_color_maps) maps.emplace_back(known.name, known.map);
  fields.choice<std::optional<image::ColorMap>>(
      "--color-map", renderer::meaning_of("cloud/color/map") + " (default auto)", maps,
      [coloring](const std::optional<image::ColorMap>& map) { coloring("--color-map").map = map; });
  const Field range = fields.value(
      "--color-range", "MIN,MAX", "values of the first and last colour (default: by percentiles)",
      [coloring](const std::string& text) {
        coloring("--color-range").range = parse_range(text, -image::k_largest_value, image::k_largest_value);
      });
  fields.excludes(range).value("--color-percentiles", "LOW,HIGH",
                               "percentiles of the first and last colour (default 1,99)",
                               [coloring](const std::string& text) {
                                 image::PointColoring& colors = coloring("--color-percentiles");
                                 colors.percentiles = parse_range(text, 0.0, 100.0);
                                 colors.range.reset();
                               });
  fields.value("--class-color", "CLASS=#RRGGBB,...",
               "colours of individual classes of --color-by classification",
               [coloring](const std::string& text) { take_class_colors(text, coloring("--class-color")); });
  const Field legend =
      fields.value("--legend", "FILE.png",
                   "also write a legend: a colour bar, or the classes with their numbers of points",
                   request.legend, parse_legend);
  fields.needs(legend).value("--legend-size", "WxH", "size of the legend in pixels (default: fits its text)",
                             request.legend_size, parse_legend_size);
}

renderer::ImagePart parse_part(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos)
    throw UsageError("invalid value; expected I/N, such as 3/20, found '" + text + "'");
  renderer::ImagePart part;
  part.count = static_cast<int>(parse_count(text.substr(slash + 1), 1, renderer::k_most_parts));
  part.number =
      static_cast<int>(parse_count(text.substr(0, slash), 1, static_cast<std::uint64_t>(part.count)));
  return part;
}

void add_long_render(const Fields& fields, RenderRequest& request) {
  constexpr double k_most_seconds = 1e9;
  const Field time_limit =
      fields.number("--time-limit", "S",
                    "seconds per image: rendering stops then and reports the number of samples. At least one "
                    "sample per pixel, at most --samples. The bytes depend on the time",
                    request.time_limit, 0.0, k_most_seconds);
  const Field target_noise =
      fields.number("--target-noise", "E",
                    "stop a tile of about 16x16 pixels at an estimated relative error of at most E, such as "
                    "0.02; a tile gets at least 32 samples and at most --samples",
                    request.target_noise, 1e-6, 1e6);
  const Field preview = fields.value(
      "--preview", "FILE", "preview of the unfinished image, .png or .jpg, rewritten every few seconds",
      request.preview, std::identity());
  fields.needs(preview).number("--preview-interval", "S", "seconds between previews (default 3)",
                               request.preview_interval, 0.0, k_most_seconds);
  fields.needs(preview).count(
      "--preview-points", "N",
      "before COPC files of more than 2 N points are loaded, the preview shows N points, those the "
      "camera sees best, then 8 N and so on (default 300000; 0: only the image itself)",
      request.preview_points, 0, k_most_preview_points);
  add_checkpoint_fields(fields, request.checkpoint, "rewritten every minute", "image");
  fields.excludes(time_limit)
      .excludes(target_noise)
      .excludes(preview)
      .value(
          "--part", "I/N",
          "render part I of N, such as 3/20, for 'alidade merge': writes FILE.part3of20 instead of the image "
          "FILE. A part has every N-th tile of about 16x16 pixels",
          request.part, parse_part);
}

}  // namespace

bool RenderRequest::has_site() const {
  return std::ranges::any_of(scene.objects, [](const renderer::Object& object) {
    const auto* const model = std::get_if<renderer::Model>(&object);
    return model != nullptr && !model->mesh;
  });
}

std::vector<std::filesystem::path> RenderRequest::other_inputs() const {
  std::vector<std::filesystem::path> all{scene_file, views.file, views.lens, flight.keyframes};
  if (const auto* sky = std::get_if<renderer::ImageSky>(&scene.sky)) all.push_back(sky->file);
  for (const renderer::Object& object : scene.objects) {
    const auto* const model = std::get_if<renderer::Model>(&object);
    if (model != nullptr && model->mesh) all.push_back(model->mesh->file);
  }
  return all;
}

std::filesystem::path RenderRequest::written_file(const std::filesystem::path& image) const {
  if (!part) return image;
  return image.string() + fmt::format(".part{}of{}", part->number, part->count);
}

void add_render_fields(const Fields& fields, RenderRequest& request) {
  add_surfaces(fields, request);
  add_output(fields, request);
  add_views_fields(fields, request.views);
  add_flight_fields(fields, request.flight);
  add_depth_fields(fields, request.depth);
  add_light(fields, request);
  add_image(fields, request);
  add_radius(fields, request);
  add_points(fields, request);
  add_colors(fields, request);
  add_long_render(fields, request);
  add_partial(fields, request.partial);
}

void check_surfaces(const RenderRequest& request) {
  if (request.scene_file.empty() && !request.scene.cloud && request.scene.objects.empty())
    throw input_error("nothing to render", "SCENE.json, CLOUD..., --mesh FILE or --site courtyard");
}

renderer::CloudSettings& cloud_settings(RenderRequest& request, const std::string& field) {
  if (request.scene.cloud) return *request.scene.cloud;
  check_surfaces(request);
  if (request.has_site()) throw Error({.problem = field + " has no effect with --site"});
  throw file_error(request.scene_file, "the scene has no cloud for " + field);
}

}  // namespace alidade::jobs
