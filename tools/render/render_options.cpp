// SPDX-License-Identifier: MIT
#include "tools/render/render_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>

#include "base/words.h"
#include "jobs/mesh_files.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"
#include "renderer/overview.h"
#include "renderer/read_scene.h"
#include "simulation/courtyard.h"
#include "tools/cloud/load_cloud.h"
#include "tools/render/site_surfaces.h"

namespace alidade::tools {
namespace {

std::string layer_list() {
  std::string list;
  for (const image::NamedLayer& known : image::k_layers)
    list += (list.empty() ? "" : ",") + std::string(known.name);
  return list;
}

std::string ground_layer_list() {
  return fmt::format("{}", fmt::join(k_ground_layers, ","));
}

/// Takes layers of both kinds: those of EXR, and those of GeoTIFF.
void parse_layers(const std::string& text, RenderCommand& command) {
  command.layers.clear();
  command.ground.layers.clear();
  for (const std::string& word : split_list(text)) {
    const auto known = std::ranges::find(image::k_layers, word, &image::NamedLayer::name);
    const auto ground =
        std::ranges::find(k_ground_layers, word, [](const char* name) { return std::string(name); });
    if (known != image::k_layers.end())
      command.layers.push_back(known->layer);
    else if (ground != std::end(k_ground_layers))
      command.ground.layers.push_back(static_cast<GroundLayer>(ground - k_ground_layers));
    else
      throw UsageError("unknown layer; expected one of " + layer_list() + " or of a GeoTIFF one of color," +
                       ground_layer_list() + ", found '" + word + "'");
  }
  command.ground.with_color = !command.layers.empty();
}

double parse_positive(const std::string& text, const std::string& expected) {
  const double value = parse_number(text);
  if (!(value > 0.0)) throw UsageError("invalid value; expected " + expected + ", found '" + text + "'");
  return value;
}

void parse_radius(const std::string& text, RadiusRequest& request) {
  using Kind = RadiusRequest::Kind;
  request.kind = text == "auto" ? Kind::automatic : text == "adapted" ? Kind::adapted : Kind::length;
  if (request.kind == Kind::length)
    request.length = parse_positive(text, "auto, adapted or a positive length");
}

/// Declares one of the options of adapted radii, any of which requests these. They are read after --radius.
void add_adapted_radius_option(const Fields& render, RadiusRequest& request, const std::string& name,
                               const std::string& kind, const std::string& help,
                               const std::function<void(const std::string&)>& take) {
  render.value(name, kind, help, [&request, take](const std::string& text) {
    if (request.kind.value_or(RadiusRequest::Kind::adapted) != RadiusRequest::Kind::adapted)
      throw UsageError("requires --radius adapted");
    request.kind = RadiusRequest::Kind::adapted;
    take(text);
  });
}

void add_image_options(const Fields& render, RenderCommand& command) {
  render.count(
      "--samples", "N",
      "paths per pixel; noise halves with four times as many (default: the scene's, else 50; 16 for an "
      "overview)",
      command.samples, 1, renderer::k_max_samples);
  render.count(
      "--max-bounces", "N",
      "scattering events after the first surface (default 8; 0: direct light of sun, sky and lamps only)",
      command.max_bounces, 0, renderer::k_max_bounces);
  render.value(
      "--exposure", "STOPS|auto",
      "brightness of PNG, JPEG and GeoTIFF: +1 is twice as bright; auto: the first view's surfaces get a "
      "medium brightness (default: auto for an overview, without a scene and a camera, else the scene's)",
      command.exposure, [](const std::string& text) {
        if (text == "auto") return std::optional<double>();
        if (text.find_first_of("0123456789") == text.npos)
          throw UsageError("invalid value; expected a number of stops or auto, found '" + text + "'");
        return std::optional(parse_number(text, -64.0, 64.0));
      });
  render.flag("--transparent",
              "leave the sky out: PNG, EXR and GeoTIFF have alpha 0 where the camera sees no surface",
              command.transparent);
  render.value("--layers", "LIST",
               "layers of an EXR: " + layer_list() + "; rasters of --orthographic as GeoTIFF: color," +
                   ground_layer_list() +
                   ", each in a file of its own, such as site_elevation.tif (default color)",
               [&command](const std::string& text) { parse_layers(text, command); });
  render.count("--seed", "N", "seed of the samples; the same seed gives the same bytes (default 1)",
               command.seed, 0, UINT64_MAX);
}

void add_cloud_options(const Fields& render, RenderCommand& command) {
  RadiusRequest& radius = command.radius;
  render.value(
      "--radius", "R|auto|adapted",
      "radius of the points, metres; auto: one radius from the spacing, of discs adapted; adapted: one per "
      "point from the distance to its neighbours, small where the scan is dense (default auto)",
      [&radius](const std::string& text) { parse_radius(text, radius); });
  add_adapted_radius_option(
      render, radius, "--radius-factor", "F",
      "adapted radii are F times the distance to the neighbour (default 0.75, of discs 0.92); implies "
      "--radius "
      "adapted",
      [&radius](const std::string& text) { radius.factor = parse_positive(text, "a positive number"); });
  add_adapted_radius_option(render, radius, "--radius-neighbours", "N",
                            "adapted radii use the distance to the N-th nearest neighbour, 1 to 64 (default "
                            "8); implies --radius adapted",
                            [&radius](const std::string& text) {
                              radius.neighbours =
                                  static_cast<int>(parse_count(text, 1, k_most_spacing_neighbours));
                            });
  add_adapted_radius_option(render, radius, "--radius-max", "R|auto",
                            "largest adapted radius in metres (default auto: four times that of --radius "
                            "auto); implies --radius adapted",
                            [&radius](const std::string& text) {
                              radius.max.emplace();
                              if (text != "auto")
                                *radius.max = parse_positive(text, "auto or a positive length");
                            });
  render.choice("--color-depth", "bits in use in LAS colour fields (default: detected from the values)",
                command.color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  render.choice("--hits", "first point by sphere entry (default) or by projection, as in the paper",
                command.hits, {{"entry", renderer::HitMode::entry}, {"t", renderer::HitMode::t}});
  render.choice("--normals",
                "normals of the spheres, or of a plane fitted to the neighbours, which smooths walls "
                "(default: the scene's; smooth without a scene)",
                command.normals,
                {{"sphere", renderer::NormalMode::sphere}, {"smooth", renderer::NormalMode::smooth}});
  render.choice("--surface",
                "what a point is to a ray: its sphere, as in the paper; the disc of the plane through its "
                "neighbours; or "
                "discs blended into one surface (default: the scene's, else blend, and sphere with --radius "
                "METRES, --hits, --normals, --max-level)",
                command.shape,
                {{"sphere", renderer::PointShape::sphere},
                 {"disc", renderer::PointShape::disc},
                 {"blend", renderer::PointShape::blend}});
  render.count("--max-level", "N",
               "only levels 0 to N of an index file made with --organisation layered: a quick preview of a "
               "thinned cloud (default: all levels)",
               command.max_level, 0, renderer::k_max_level);
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

void take_scene_or_cloud(const std::vector<std::string>& words, RenderCommand& command) {
  const auto scene = std::ranges::find_if(words, is_scene);
  if (scene == words.end()) {
    command.files = command.view.apply(
        resolve_clouds(std::vector<std::filesystem::path>(words.begin(), words.end()), cloud_formats()));
    return;
  }
  if (words.size() > 1)
    throw UsageError("invalid operands; expected one scene file, or clouds, found the scene '" + *scene +
                     "' and " + std::to_string(words.size() - 1) + " more");
  command.scene_file = *scene;
}

/// Applies the options of radii to the settings of a cloud.
void apply(const RadiusRequest& request, renderer::CloudSettings& cloud) {
  if (!request.kind) return;
  cloud.radius.reset();
  if (request.kind == RadiusRequest::Kind::length) cloud.radius = request.length;
  if (request.kind != RadiusRequest::Kind::adapted) {
    cloud.adapted_radius.reset();
    return;
  }
  if (!cloud.adapted_radius) cloud.adapted_radius.emplace();
  renderer::AdaptedRadius& adapted = *cloud.adapted_radius;
  if (request.factor) adapted.factor = request.factor;
  adapted.neighbours = request.neighbours.value_or(adapted.neighbours);
  adapted.max = request.max.value_or(adapted.max);
}

/// Replaces the scene's cloud by the site.
void put_exact_site(renderer::Scene& scene, const std::filesystem::path& scene_file) {
  renderer::Model model{std::make_shared<SiteSurfaces>(simulation::courtyard(), "courtyard")};
  if (scene.cloud) model.material = scene.cloud->material;
  if (std::holds_alternative<renderer::Dielectric>(model.material))
    throw file_error(scene_file, "--site does not support glass as the cloud's material");
  scene.cloud.reset();
  scene.objects.emplace_back(std::move(model));
}

/// One of the given options about the cloud; empty if there is none.
std::string cloud_option(const RenderCommand& command) {
  const RadiusRequest& radius = command.radius;
  if (radius.factor) return "--radius-factor";
  if (radius.neighbours) return "--radius-neighbours";
  if (radius.max) return "--radius-max";
  if (radius.kind) return "--radius";
  if (command.color_depth) return "--color-depth";
  if (command.hits) return "--hits";
  if (command.normals) return "--normals";
  if (command.shape) return "--surface";
  if (command.max_level) return "--max-level";
  if (command.partial) return "--partial";
  if (command.in_view) return "--in-view";
  return given_option(command.color);
}

/// One of the given options that apply to spheres only; empty if there is none.
std::string sphere_option(const RenderCommand& command) {
  const RadiusRequest& radius = command.radius;
  if (radius.kind == RadiusRequest::Kind::length) return "--radius METRES";
  if (radius.neighbours.value_or(k_surface_neighbours) != k_surface_neighbours) return "--radius-neighbours";
  if (command.hits) return "--hits";
  if (command.normals) return "--normals";
  if (command.max_level) return "--max-level";
  return {};
}

void apply_cloud_options(const RenderCommand& command, renderer::Scene& scene) {
  const std::string option = cloud_option(command);
  if (option.empty()) return;
  if (command.exact_site) throw Error({.problem = option + " has no effect with --site"});
  if (!scene.cloud) throw file_error(command.scene_file, "the scene has no cloud for " + option);
  renderer::CloudSettings& cloud = *scene.cloud;
  apply(command.radius, cloud);
  cloud.color_depth = command.color_depth.value_or(cloud.color_depth);
  apply(command.color, cloud.color);
  cloud.hits = command.hits.value_or(cloud.hits);
  cloud.normals = command.normals.value_or(cloud.normals);
  cloud.max_level = command.max_level.value_or(cloud.max_level);
  cloud.partial = cloud.partial || command.partial;
  if (command.shape) cloud.shape = *command.shape;
  if (cloud.shape == renderer::PointShape::sphere) return;
  const std::string only_spheres = sphere_option(command);
  if (only_spheres.empty()) return;
  if (command.shape)
    throw input_error(only_spheres + " has no effect on discs", "--surface sphere, or no such option");
  cloud.shape = renderer::PointShape::sphere;
}

/// Errors: nothing is to be written; an option that only images have.
void check_depth_alone(const RenderCommand& command) {
  if (command.depth.file.empty()) throw file_error(command.scene_file, "missing output", "-o FILE");
  const LongRenderRequest& long_render = command.long_render;
  const std::pair<const char*, bool> given[] = {{"--layers", !command.layers.empty()},
                                                {"--legend", !command.color.legend.empty()},
                                                {"--preview", !long_render.preview.empty()},
                                                {"--checkpoint", !long_render.checkpoint.file.empty()},
                                                {"--time-limit", !!long_render.time_limit},
                                                {"--target-noise", !!long_render.target_noise},
                                                {"--part", !!long_render.part}};
  for (const auto& [option, is_given] : given)
    if (is_given) throw input_error(fmt::format("{} requires an image", option), "-o FILE beside --depth");
}

}  // namespace

std::shared_ptr<RenderCommand> add_render_options(const Fields& render) {
  auto command = std::make_shared<RenderCommand>();
  command->view = add_view_fields(render);
  const Field scene =
      render.words("scene", "SCENE.json|CLOUD...",
                   "scene file; or " + k_files_help + ", rendered without one" + k_database_help,
                   [command = command.get()](const std::vector<std::string>& words) {
                     take_scene_or_cloud(words, *command);
                   });
  const Field cloud = add_cloud_files(render.excludes(scene), "--cloud", "FILE...", "the same as CLOUD",
                                      command->files, command->view);
  render.excludes(cloud).value(
      "--site", "courtyard",
      "render the exact surfaces of the site that 'alidade generate' scans, in place of the "
      "scene's cloud: the truth for renders of its scans",
      [command = command.get()](const std::string& text) {
        if (text != "courtyard") throw UsageError("invalid value; expected courtyard, found '" + text + "'");
        command->exact_site = true;
      });
  add_mesh_field(render, "beside the cloud or the scene", command->meshes);
  render.file("-o,--output", "FILE",
              "output image: .png, .jpg, .exr or .tif (default: the scene's); for a set of cameras with %04d "
              "(number, from 0), %s (name of the photograph) or %f (the same with folders and extension)",
              command->output);
  render.flag(
      "--in-view",
      "read only the points of a database cloud that the cameras see: others cast no shadow, send no light, "
      "and do not affect automatic radii, colour ranges and the smooth normals of points at the border",
      command->in_view);
  render.flag("--overwrite", "replace an existing image", command->overwrite);
  render.flag("--skip-existing", "skip existing images, to continue an interrupted set",
              command->skip_existing);
  add_camera_options(render, command->camera);
  add_flight_options(render, command->flight);
  add_depth_options(render, command->depth);
  add_light_options(render, command->light);
  add_image_options(render, *command);
  add_cloud_options(render, *command);
  add_color_options(render, command->color);
  add_long_render_options(render, command->long_render);
  add_run_options(render, *command);
  return command;
}

renderer::Scene requested_scene(const RenderCommand& command) {
  if (command.scene_file.empty() && command.files.empty() && command.meshes.empty() && !command.exact_site)
    throw input_error("nothing to render", "SCENE.json, CLOUD..., --mesh FILE or --site courtyard");
  if (command.exact_site && !command.files.empty())
    throw input_error("--site does not apply to a cloud", "the site alone, or a scene file");
  renderer::Scene scene = command.scene_file.empty() ? renderer::daylight_scene(command.files.names())
                                                     : renderer::read_scene(command.scene_file);
  if (command.exact_site) put_exact_site(scene, command.scene_file);
  for (const std::filesystem::path& file : command.meshes)
    scene.objects.emplace_back(renderer::Model{.surfaces = {}, .mesh = renderer::MeshFile{file, {}}});
  apply_cloud_options(command, scene);
  apply_light_options(command.light, scene);
  if (command.max_bounces) require_path_mode(scene, "--max-bounces");
  if (scene.cloud) renderer::check_shape(*scene.cloud);
  // Without points there is no extent to choose a distance by.
  const bool is_site_or_mesh = command.exact_site || !command.meshes.empty();
  if (is_site_or_mesh && !scene.cloud && scene.render.mode == renderer::RenderMode::ambient_occlusion &&
      !scene.render.ao_distance)
    throw input_error("an image without a cloud requires a distance for ambient occlusion",
                      "--ao-distance METRES");
  // Enough to look at, and few seconds of work; limits by noise or time have their own end.
  const bool is_quick =
      command.is_overview() && !command.long_render.target_noise && !command.long_render.time_limit;
  scene.render.samples =
      command.samples.value_or(is_quick ? renderer::k_overview_samples : scene.render.samples);
  scene.render.max_bounces = command.max_bounces.value_or(scene.render.max_bounces);
  scene.render.seed = command.seed.value_or(scene.render.seed);
  if (!command.output.empty() || !command.depth.file.empty()) scene.output.file = command.output;
  if (command.exposure && *command.exposure) scene.output.exposure = **command.exposure;
  if (command.transparent) scene.output.transparent = true;
  // The sky of an overview is only its background, which must not change with the exposure.
  const bool is_shaded = scene.render.mode != renderer::RenderMode::flat;
  if (command.is_overview() && is_shaded) scene.output.background = renderer::k_overview_background;
  if (scene.output.transparent && image::image_format(scene.output.file) == image::ImageFormat::jpeg)
    throw file_error(scene.output.file, "JPEG has no alpha",
                     "the extension .png, .exr or .tif, or no --transparent");
  const bool is_on_ground =
      command.camera.from_above && image::image_format(scene.output.file) == image::ImageFormat::geotiff;
  if (!command.ground.layers.empty() && !is_on_ground)
    throw file_error(scene.output.file, "layers of the ground require an orthophoto",
                     "--orthographic top and the extension .tif");
  if (!command.layers.empty()) scene.output.layers = command.layers;
  if (scene.output.file.empty()) check_depth_alone(command);
  const bool is_color = command.layers == std::vector{image::Layer::color};
  if (!scene.output.file.empty() && !command.layers.empty() && !(is_on_ground && is_color) &&
      image::image_format(scene.output.file) != image::ImageFormat::exr)
    throw file_error(scene.output.file, "layers require EXR", "the extension .exr, or no --layers");
  return scene;
}

}  // namespace alidade::tools
