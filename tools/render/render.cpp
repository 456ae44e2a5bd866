// SPDX-License-Identifier: MIT
#include "renderer/render.h"

#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "base/error.h"
#include "base/shown_text.h"
#include "geo/gdal_library.h"
#include "image/color_points.h"
#include "image/image_file.h"
#include "image/legend.h"
#include "jobs/mesh_files.h"
#include "renderer/cloud_in_view.h"
#include "renderer/mesh_surfaces.h"
#include "renderer/overview.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/render/light_and_color.h"
#include "tools/render/long_render.h"
#include "tools/render/render_options.h"
#include "tools/render/views.h"

namespace alidade::tools {
namespace {

/// Adds the files of a scene's meshes.
void add_mesh_files(const renderer::Scene& scene, std::vector<std::filesystem::path>& files) {
  for (const renderer::Object& object : scene.objects) {
    const auto* model = std::get_if<renderer::Model>(&object);
    if (model != nullptr && model->mesh) files.push_back(model->mesh->file);
  }
}

/// Reads a scene's meshes, shows progress, and prints their sizes. Errors: as read_mesh().
void load_meshes(renderer::Scene& scene, Verbosity verbosity) {
  Console console(verbosity);
  for (renderer::Object& object : scene.objects) {
    auto* const model = std::get_if<renderer::Model>(&object);
    if (model == nullptr || !model->mesh) continue;
    const renderer::MeshFile& source = *model->mesh;
    TriangleMesh mesh = jobs::load_mesh(source.file, source.placement, console);
    model->surfaces = jobs::sort_triangles(console, [&](const Progress& progress) {
      return std::make_shared<renderer::MeshSurfaces>(std::move(mesh), kept_name(source.file), progress);
    });
  }
}

std::vector<std::filesystem::path> input_files(const RenderCommand& command, const renderer::Scene& scene) {
  std::vector<std::filesystem::path> files{command.scene_file, command.camera.file, command.camera.lens_file};
  if (scene.cloud) files.insert(files.end(), scene.cloud->files.begin(), scene.cloud->files.end());
  if (const auto* sky = std::get_if<renderer::ImageSky>(&scene.sky)) files.push_back(sky->file);
  add_mesh_files(scene, files);
  return files;
}

std::string radius_text(const renderer::CloudSettings& settings, const renderer::LoadedCloud& cloud) {
  if (settings.shape != renderer::PointShape::sphere) {
    return fmt::format("discs of radius {:.4g} times the distance to neighbour 8, at most {:.4g}",
                       cloud.spacing_factor, cloud.radius);
  }
  if (settings.adapted_radius) {
    return fmt::format("spheres of radius {:.4g} times the distance to neighbour {}, at most {:.4g}",
                       cloud.spacing_factor, settings.adapted_radius->neighbours, cloud.radius);
  }
  return fmt::format("spheres of radius {:.4g}{}", cloud.radius,
                     settings.radius ? "" : " (from the spacing of the points)");
}

void check_in_view(const renderer::CloudSettings& settings, const renderer::Scene& scene,
                   const CloudInputs& clouds, std::span<const View> views) {
  if (clouds.size() != 1 || !has_parts(clouds.inputs.front())) {
    throw file_error(settings.files.empty() ? "" : settings.files.front().string(),
                     "--in-view requires a single cloud in a database",
                     "a database written by 'alidade sql load'");
  }
  if (views.empty())
    throw input_error("--in-view requires a camera that does not depend on the cloud",
                      "--camera, --panorama or a scene file");
  if (settings.max_level < renderer::k_max_level || settings.partial)
    throw Error({.problem = "--in-view cannot be combined with --max-level or --partial"});
  if (std::ranges::find(scene.output.layers, image::Layer::id) != scene.output.layers.end())
    throw Error({.problem = "--in-view cannot be combined with the layer id"});
}

/// One filter per view; points further from its half-spaces than their radius are not seen.
std::vector<database::PointFilter> view_filters(std::span<const View> views, double radius) {
  std::vector<database::PointFilter> filters;
  for (const View& view : views) {
    database::PointFilter& filter = filters.emplace_back();
    for (const Plane& plane : renderer::view_planes(view.camera).planes)
      filter.planes.push_back({plane, {-radius, std::numeric_limits<double>::infinity()}});
  }
  return filters;
}

/// The part of the scene's cloud, in a database, that the cameras see: points whose spheres, as far as their
/// radius is given, may be in an image. `measuring` as in load_cloud(). Prints how much was read. Errors:
/// the cloud is of another kind; no camera is given; layers that need the whole cloud; the database's.
renderer::LoadedCloud load_in_view(const RenderCommand& command, const renderer::Scene& scene,
                                   const CloudInputs& clouds, std::span<const View> views,
                                   const Progress& measuring) {
  const renderer::CloudSettings& settings = *scene.cloud;
  check_in_view(settings, scene, clouds, views);
  const CloudInput& input = clouds.inputs.front();
  const Verbosity verbosity = command.verbosity;
  const char* const unit = part_unit(input);
  ProgressLine line(fmt::format("loading {} in view", unit), unit, verbosity);
  database::CloudPart part = read_database_part(input, view_filters(views, settings.radius.value_or(0.0)),
                                                image::attributes_for(settings.color), line.callback());
  line.finish();
  if (verbosity != Verbosity::quiet && part.chunk_count > 0)
    say_note(fmt::format("read {} of {} chunks of {}", part.chunks_read, part.chunk_count,
                         public_name(input.name.string())));
  renderer::LoadedCloud loaded =
      renderer::index_cloud(std::move(part.cloud), part.attributes, settings, input.name.string());
  renderer::choose_radius(settings, loaded, measuring);
  return loaded;
}

/// A warning if all values that a cloud is coloured by are equal; empty if they differ.
std::string remark_on_colors(const image::ColorKey& key) {
  const std::uint64_t count = key.point_count - key.missing_count;
  if (count == 0) return "";
  if (key.scale && key.scale->extent.low == key.scale->extent.high)
    return fmt::format("--color-by {}: all values are {:g}", key.word, key.scale->extent.low);
  const bool is_one = !key.scale && key.swatches.size() == 1 && key.swatches.front().count;
  return is_one ? fmt::format("--color-by {}: all values are {}", key.word,
                              key.swatches.front().number.empty() ? key.swatches.front().label
                                                                  : key.swatches.front().number)
                : "";
}

/// Loads the scene's cloud. `views` are those of the images; empty if they are chosen after loading.
renderer::LoadedCloud load(const RenderCommand& command, const renderer::Scene& scene,
                           const CloudInputs& clouds, std::span<const View> views) {
  const renderer::CloudSettings& settings = *scene.cloud;
  const Verbosity verbosity = command.verbosity;
  ProgressLine line("loading cloud", "B", verbosity);
  std::optional<ProgressLine> measuring;
  const Progress measure = [&](std::uint64_t done, std::uint64_t total) {
    if (!measuring) {
      line.finish();
      const bool fits = settings.shape != renderer::PointShape::sphere;
      measuring.emplace(fits ? "measuring surfaces" : "measuring spacings", "points", verbosity);
    }
    return measuring->callback()(done, total);
  };
  renderer::LoadedCloud cloud = command.in_view
                                    ? load_in_view(command, scene, clouds, views, measure)
                                    : renderer::load_cloud(settings, clouds, line.callback(), measure);
  if (measuring || !command.in_view) (measuring ? *measuring : line).finish();
  say_warnings(verbosity, cloud.warnings);
  check_map_unit(cloud.crs, clouds);
  const std::string color = cloud.color.by == image::PointColor::rgb ? "rgb" : cloud.color.word;
  say_note(verbosity, fmt::format("{} points, coloured by {}, {}", cloud.octree.size(), color,
                                  radius_text(settings, cloud)));
  if (const std::string remark = remark_on_colors(cloud.color); !remark.empty())
    say_warnings(verbosity, {remark});
  if (cloud.color.scale) say_note(verbosity, cloud.color.word + ": " + image::scale_text(cloud.color));
  return cloud;
}

constexpr std::uint64_t k_growth = 8;
// Two cores render this in half a second.
constexpr int k_longest_side = 640;
constexpr int k_samples = 8;
constexpr double k_seconds = 0.5;

/// The camera for an image no larger than a first look needs.
camera::Camera reduced(const camera::Camera& camera) {
  const double share = static_cast<double>(k_longest_side) / std::max(camera.width, camera.height);
  if (share >= 1.0) return camera;
  const auto side = [&](int pixels) { return std::max(1, static_cast<int>(pixels * share)); };
  return camera::resized(camera, side(camera.width), side(camera.height));
}

/// Renders a scene with a part of its cloud and shows the image.
void show(const RenderCommand& command, renderer::Scene scene, const View* view,
          const renderer::LoadedCloud& cloud, const Progress& progress) {
  scene.camera =
      reduced(view ? view->camera : view_of_cloud(command.camera, scene, &cloud, command.scene_file).camera);
  prepare_light(scene, &cloud, Verbosity::quiet);
  scene.render.samples = std::min(scene.render.samples, k_samples);
  LongRenderRequest preview_only;
  preview_only.preview = command.long_render.preview;
  render_options(preview_only, scene.output, false, {})
      .preview->show(renderer::render(
          scene, &cloud,
          {.progress = progress, .layers = std::vector{image::Layer::color}, .time_limit = k_seconds}));
}

/// Shows an image in its preview file before its cloud is loaded, if the cloud consists of COPC files with
/// more than twice `preview_points` points: first with so many of them, then with eight times as many, and so
/// on up to half of them or 50 million. `view` is that of the image, or null to show the whole cloud;
/// `scene` has its sky. Failures are no errors here: loading reports them. Errors: Cancelled.
void show_first_looks(const RenderCommand& command, const renderer::Scene& scene, const CloudInputs& clouds,
                      const View* view) {
  const Verbosity verbosity = command.verbosity;
  const Progress progress = [](std::uint64_t, std::uint64_t) { return !interrupted(); };
  try {
    const std::vector<std::unique_ptr<CopcFile>> files = renderer::open_copc_cloud(clouds);
    std::uint64_t all = 0;
    for (const auto& file : files) all += file->header().point_count;
    for (std::uint64_t points = command.long_render.preview_points;
         points > 0 && points <= std::min(all / 2, k_most_preview_points); points *= k_growth) {
      const renderer::LoadedCloud cloud = renderer::load_coarse_cloud(
          *scene.cloud, clouds, files, view ? &view->camera : nullptr, points, progress);
      if (cloud.octree.size() == 0) return;
      show(command, scene, view, cloud, progress);
      say_note(verbosity, fmt::format("{} shows {} of {} points", command.long_render.preview.string(),
                                      short_count(static_cast<double>(cloud.octree.size())),
                                      short_count(static_cast<double>(all))));
    }
  } catch (const Error& error) {
    if (verbosity == Verbosity::verbose) say_note(fmt::format("no early preview: {}", error.what()));
  }
}

/// A view and the image it becomes.
struct RequestedImage {
  View view;
  std::filesystem::path file;
  std::size_t number = 0;  ///< of its view
};

/// The images to make, and existing ones that stay.
struct ImageList {
  std::vector<RequestedImage> images;
  std::vector<std::filesystem::path> finished;

  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> names;
    for (const RequestedImage& image : images) names.push_back(image.file);
    return names;
  }
};

ImageList requested_images(const RenderCommand& command, const renderer::Scene& scene,
                           std::span<const View> views) {
  std::vector<std::filesystem::path> names{scene.output.file};
  if (command.flight.orbits)
    names =
        image_names(scene.output.file, std::vector<View>(static_cast<std::size_t>(command.flight.frames)));
  else if (is_set(command.camera) || command.flight.given())
    names = image_names(scene.output.file, views);
  const std::vector<std::filesystem::path> inputs = input_files(command, scene);
  ImageList list;
  std::vector<std::filesystem::path> outputs;
  for (std::size_t i = 0; i < names.size(); ++i) {
    outputs.push_back(written_file(command.long_render, names[i]));
    std::error_code error;
    if (command.skip_existing && std::filesystem::exists(outputs[i], error)) {
      list.finished.push_back(names[i]);
      continue;
    }
    if (command.ground.with_color) check_writable(outputs[i], command.overwrite, inputs);
    // A view that is missing is chosen once the cloud is loaded.
    list.images.push_back({i < views.size() ? views[i] : View(), names[i], i});
  }
  for (const std::filesystem::path& file : command.ground.files(scene.output.file))
    check_writable(file, command.overwrite, inputs);
  if (!command.color.legend.empty()) outputs.push_back(command.color.legend);
  check_long_render(command.long_render,
                    {.any = command.overwrite,
                     .earlier_preview = command.skip_existing || command.long_render.checkpoint.resume},
                    outputs, inputs);
  return list;
}

/// Whether a legend is to be written: it is requested, and no existing one may stay. `resumed`: the render
/// resumes from a checkpoint, whose run has written the legend.
bool is_wanted(const std::filesystem::path& legend, const RenderCommand& command, bool resumed) {
  std::error_code error;
  // Parts have one legend, which the first one writes.
  if (command.long_render.part && command.long_render.part->number > 1) return false;
  const bool may_stay = !command.overwrite && (command.skip_existing || resumed);
  return !legend.empty() && !(may_stay && std::filesystem::exists(legend, error));
}

/// Errors: as check_writable; the legend would be one of the images.
void check_legend_file(const RenderCommand& command, const renderer::Scene& scene,
                       std::span<const RequestedImage> images) {
  check_writable(command.color.legend, command.overwrite, input_files(command, scene));
  for (const RequestedImage& image : images) {
    if (image.file.lexically_normal() == command.color.legend.lexically_normal())
      throw file_error(image.file, "image and legend have the same name");
  }
}

std::uint64_t camera_rays(const renderer::Scene& scene, const camera::Camera& camera,
                          const std::optional<renderer::ImagePart>& part) {
  return renderer::pixel_count(camera.width, camera.height, part.value_or(renderer::ImagePart())) *
         static_cast<std::uint32_t>(scene.render.samples);
}

DepthPlan requested_depth(const RenderCommand& command, const renderer::Scene& scene,
                          std::span<const View> views, const ImageList& list) {
  // Like the legend, they come with the first part.
  if (command.long_render.part && command.long_render.part->number > 1) return {};
  const CheckpointRequest& checkpoint = command.long_render.checkpoint;
  std::error_code error;
  // The run that wrote the checkpoint wrote them before.
  const bool resumes = checkpoint.resume && std::filesystem::exists(checkpoint.file, error);
  std::vector<std::filesystem::path> others = list.files();
  others.insert(others.end(), list.finished.begin(), list.finished.end());
  others.insert(others.end(),
                {command.color.legend, command.long_render.preview, command.long_render.checkpoint.file});
  return plan_depth_maps(command.depth, command.camera, views,
                         {command.overwrite, command.skip_existing || (resumes && !command.overwrite)},
                         input_files(command, scene), others);
}

void check_views(std::span<const RequestedImage> images, const renderer::Scene& scene,
                 const renderer::LoadedCloud* cloud) {
  for (const RequestedImage& image : images) {
    try {
      if (image::image_format(image.file) == image::ImageFormat::geotiff)
        camera::ground_transform(image.view.camera);
      if (cloud != nullptr) renderer::check_camera_position(image.view.camera, scene, *cloud);
    } catch (const Error& error) {
      Error::Parts parts = error.parts();
      if (!image.view.name.empty())
        parts.problem = fmt::format("camera '{}': {}", image.view.name, parts.problem);
      throw Error(parts);
    }
  }
}

/// The metadata of an image or depth map of a scene. `cloud` may be null; `words` is the command line.
renderer::ImageMetadata image_metadata(const renderer::Scene& scene, const View& view,
                                       const renderer::LoadedCloud* cloud, const CommandLine& words) {
  renderer::ImageMetadata metadata;
  metadata.camera = view.camera;
  metadata.render = scene.render;
  metadata.command = metadata_command(words);
  if (!scene.sun_origin.empty()) metadata.further.emplace_back("alidade:sun", scene.sun_origin);
  if (!view.name.empty()) metadata.further.emplace_back("alidade:camera_name", view.name);
  for (const renderer::Object& object : scene.objects)
    if (const auto* model = std::get_if<renderer::Model>(&object))
      metadata.further.emplace_back(model->mesh ? "alidade:mesh" : "alidade:site", model->surfaces->name());
  if (cloud == nullptr) return metadata;
  if (scene.cloud->shape != renderer::PointShape::sphere)
    metadata.further.emplace_back("alidade:surface",
                                  scene.cloud->shape == renderer::PointShape::disc ? "disc" : "blend");
  for (const CloudFile& file : cloud->files) metadata.cloud_files.push_back(kept_name(file.path));
  metadata.cloud_offset = cloud->octree.lattice().offset;
  metadata.crs = cloud->crs;
  metadata.radius = cloud->radius;
  if (cloud->spacing_factor > 0.0) {
    metadata.further.emplace_back("alidade:radius_factor", fmt::format("{:.17g}", cloud->spacing_factor));
    metadata.further.emplace_back("alidade:radius_neighbours",
                                  std::to_string(cloud->octree.view().spacing_neighbours));
  }
  for (const auto& text : image::color_metadata(cloud->color)) metadata.further.push_back(text);
  return metadata;
}

/// Renders and writes one image after the other under one progress line. `resumed`: what the first one
/// resumes from. `empty` gets the views that see nothing.
renderer::RenderStatistics render_all(std::span<const RequestedImage> images, renderer::Scene& scene,
                                      const renderer::LoadedCloud* cloud, const RenderCommand& command,
                                      const std::optional<Resumption>& resumed, EmptyViews& empty) {
  std::uint64_t total = 0, done = 0;
  const std::optional<renderer::ImagePart>& part = command.long_render.part;
  for (const RequestedImage& image : images) total += camera_rays(scene, image.view.camera, part);
  const Verbosity verbosity = command.verbosity;
  ProgressLine line(images.size() == 1 ? "rendering" : fmt::format("rendering {} images", images.size()),
                    "camera rays", verbosity);
  if (resumed) line.skip(resumed->samples);
  const Progress progress = line.callback();
  renderer::RenderStatistics statistics;
  for (const RequestedImage& image : images) {
    scene.camera = image.view.camera;
    scene.output.file = image.file;
    total -= camera_rays(scene, image.view.camera, part);
    std::uint64_t rays_of_image = 0;
    renderer::ImageMetadata texts = image_metadata(scene, image.view, cloud, command.words);
    renderer::RenderOptions options =
        render_options(command.long_render, scene.output, resumed && &image == &images.front(), texts);
    if (options.checkpoint && resumed && verbosity != Verbosity::quiet)
      options.checkpoint->resumed = [&] { line.interject(resumed->note); };
    options.progress = [&](std::uint64_t rays, std::uint64_t all_rays) {
      rays_of_image = rays;
      return progress(done + rays, done + all_rays + total);
    };
    renderer::RenderStatistics of_image;
    if (const auto film = render_to_file(command.long_render, scene, cloud, options, std::move(texts),
                                         command.overwrite, of_image))
      empty.check(image.view, film->sees_anything());
    remove_checkpoint(command.long_render);
    const std::string reached = describe_reached(command.long_render, of_image);
    if (!reached.empty() && verbosity != Verbosity::quiet)
      line.interject(fmt::format("{}: {}", image.file.string(), reached));
    done += rays_of_image;
    statistics.ray_count += of_image.ray_count;
    statistics.seconds += of_image.seconds;
  }
  line.finish();
  return statistics;
}

/// requested_views(), or those of a flight.
std::vector<View> chosen_views(const RenderCommand& command, const renderer::Scene& scene,
                               std::vector<std::string>& warnings) {
  if (command.flight.orbits) return {};
  if (command.flight.keyframes.empty()) return requested_views(command.camera, scene, warnings);
  CameraRequest keyframes = command.camera;
  keyframes.file = command.flight.keyframes;
  renderer::Scene with_lens = scene;
  if (!with_lens.camera) {
    // Trajectories have no lens: a plain one.
    const ImageSize size = command.camera.size.value_or(ImageSize{1280, 720});
    with_lens.camera = camera::pinhole_from_fov(size.width, size.height, 50.0, camera::CameraPose());
  }
  return flight_views(command.flight, requested_views(keyframes, with_lens, warnings));
}

ExitCode run(const RenderCommand& given) {
  RenderCommand command = given;
  const Verbosity verbosity = command.verbosity;
  take_video(command.flight, command.camera, command.output, command.overwrite);
  const EmptyFolder frames(command.flight.file.empty() ? "" : command.output.parent_path());
  renderer::Scene scene = requested_scene(command);
  const bool has_image = !scene.output.file.empty();
  if (has_image) image::check_image_name(scene.output.file);
  std::vector<std::string> warnings;
  const std::vector<View> views = chosen_views(command, scene, warnings);
  say_warnings(verbosity, warnings);
  ImageList list;
  if (has_image) list = requested_images(command, scene, views);
  std::vector<RequestedImage>& images = list.images;
  DepthPlan depth = requested_depth(command, scene, views, list);
  if (images.empty() && depth.empty()) {
    write_video(command.flight, list.finished, command.output, command.overwrite, verbosity);
    remove_finished_checkpoint(command.long_render, list.finished);
    say_note(verbosity, "all images exist");
    return ExitCode::done;
  }
  std::optional<Resumption> resumed;
  if (!images.empty()) resumed = find_resumption(command.long_render, list.files(), list.finished, verbosity);
  if (verbosity != Verbosity::quiet) warn_of_few_samples(command.long_render, scene.render.samples);
  // Before the work, so that a program that cannot write images does not render for hours first.
  image::load_library();
  const auto is_map = [](const RequestedImage& image) {
    return image::image_format(image.file) == image::ImageFormat::geotiff;
  };
  if (std::ranges::any_of(images, is_map)) geo::load_gdal();
  const bool wants_legend = is_wanted(command.color.legend, command, resumed.has_value());
  if (wants_legend) check_legend_file(command, scene, images);
  if (verbosity == Verbosity::verbose)
    say_note(fmt::format("instruction set {}", name(best_instruction_set())));
  if (!views.empty()) check_views(images, scene, nullptr);
  if (!images.empty()) prepare_sky(scene, command.scene_file, verbosity);
  load_meshes(scene, verbosity);

  CloudInputs clouds = command.files;
  if (scene.cloud && clouds.empty())
    clouds = command.view.apply(resolve_clouds(scene.cloud->files, cloud_formats()));
  if (scene.cloud && !command.long_render.preview.empty() && !resumed && !images.empty())
    show_first_looks(command, scene, clouds, views.empty() ? nullptr : &images.front().view);
  std::optional<renderer::LoadedCloud> loaded;
  if (scene.cloud) loaded = load(command, scene, clouds, views);
  const renderer::LoadedCloud* const cloud = loaded ? &*loaded : nullptr;
  std::vector<View> all_views = views;
  if (views.empty()) {
    const std::uint64_t strays =
        cloud == nullptr || command.camera.from_above ? 0 : renderer::stray_count(*cloud);
    if (strays > 0)
      say_note(verbosity, fmt::format("the view leaves out {} points far from all others", strays));
    all_views = views_of_cloud(command.camera, command.flight, scene, cloud, command.scene_file);
    for (RequestedImage& image : images) image.view = all_views[image.number];
    for (DepthJob& job : depth.jobs) job.view = all_views.front();
  }
  check_views(images, scene, cloud);
  for (const DepthJob& job : depth.jobs) check_views(std::array{RequestedImage{job.view, {}}}, scene, cloud);
  if (!depth.jobs.empty() && cloud != nullptr && !command.shape) warn_of_spheres(scene, *cloud, verbosity);
  EmptyViews empty;
  const auto finish = [&] { return empty.report(command.camera, scene, cloud, verbosity); };
  write_depth_maps(
      depth, scene, cloud,
      [&](const View& view) { return image_metadata(scene, view, cloud, command.words); }, empty, verbosity);
  if (!command.ground.layers.empty() && cloud != nullptr) {
    write_ground_layers(command.ground, scene, *cloud, clouds, all_views.front(), scene.output.file,
                        command.overwrite, empty, verbosity);
    if (!command.ground.with_color) return finish();
  }
  if (images.empty()) return finish();
  if (command.is_overview() && !command.light.sun && cloud != nullptr && all_views.size() == 1)
    renderer::light_from_scanners(scene, *cloud, all_views.front().camera);
  prepare_light(scene, cloud, verbosity);
  const bool is_lit = scene.render.mode == renderer::RenderMode::path;
  const bool is_automatic =
      command.exposure ? !command.exposure->has_value() : command.is_overview() && is_lit;
  if (is_automatic && image::image_format(images.front().file) != image::ImageFormat::exr) {
    // By the first image of a set, whether or not it exists already.
    scene.output.exposure = renderer::automatic_exposure(scene, cloud, all_views.front().camera);
    say_note(verbosity, fmt::format("exposure {:+.2f} stops (--exposure)", scene.output.exposure));
  }
  if (wants_legend)
    image::write_legend(cloud->color, command.color.legend, command.color.legend_size, command.overwrite);

  renderer::RenderStatistics statistics;
  try {
    statistics = render_all(images, scene, cloud, command, resumed, empty);
  } catch (const Cancelled&) {
    const std::filesystem::path& checkpoint = command.long_render.checkpoint.file;
    Console console(verbosity);
    if (!checkpoint.empty()) jobs::say_how_to_resume(console, checkpoint.string());
    throw;
  }
  const std::string first = written_file(command.long_render, images.front().file).string(),
                    last = written_file(command.long_render, images.back().file).string(),
                    written = images.size() == 1 ? first : fmt::format("{} to {}", first, last);
  const std::string hint = fmt::format(" with {} samples per pixel (--samples)", scene.render.samples);
  say_note(verbosity, fmt::format("{} rays in {:.1f} s ({} rays/s); wrote {}{}",
                                  short_count(static_cast<double>(statistics.ray_count)), statistics.seconds,
                                  short_count(static_cast<double>(statistics.ray_count) / statistics.seconds),
                                  written, command.is_overview() && is_lit ? hint : ""));

  if (!command.flight.file.empty()) {
    std::vector<std::filesystem::path> all = list.finished;
    for (const RequestedImage& image : images) all.push_back(image.file);
    write_video(command.flight, all, command.output, command.overwrite, verbosity);
  }
  return finish();
}

}  // namespace

Command add_render(const Options& program) {
  const Options render = program.command("render", "Render an image of a scene or of cloud files");
  const std::shared_ptr<RenderCommand> command = add_render_options(render);
  return command_of(render, command, run);
}

}  // namespace alidade::tools
