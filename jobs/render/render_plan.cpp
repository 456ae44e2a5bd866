// SPDX-License-Identifier: MIT
#include "jobs/render/render_plan.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <utility>

#include "base/error.h"
#include "base/output_file.h"
#include "base/shown_text.h"
#include "camera/projection.h"
#include "image/image_file.h"
#include "image/legend.h"
#include "jobs/cloud_formats.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "mesh/triangle_mesh.h"
#include "renderer/checkpoint.h"

namespace alidade::jobs {
namespace {

namespace fs = std::filesystem;

bool file_exists(const fs::path& file) {
  std::error_code error;
  return fs::exists(file, error);
}

/// Errors: nothing is to be written; a field that only images have.
void check_without_image(const RenderRequest& request) {
  if (request.returns_films && !request.part) return;
  if (request.depth.file.empty()) throw file_error(request.scene_file, "missing output", "-o FILE");
  const std::pair<const char*, bool> given[] = {{"--layers", !request.layers.empty()},
                                                {"--legend", !request.legend.empty()},
                                                {"--preview", !request.preview.empty()},
                                                {"--checkpoint", !request.checkpoint.file.empty()},
                                                {"--time-limit", !!request.time_limit},
                                                {"--target-noise", !!request.target_noise},
                                                {"--part", !!request.part}};
  for (const auto& [field, is_given] : given)
    if (is_given) throw input_error(fmt::format("{} requires an image", field), "-o FILE beside --depth");
}

/// Completes the settings of the output. Errors: they do not fit its format.
void complete_output(RenderRequest& request) {
  image::OutputSettings& output = request.scene.output;
  if (request.returns_films || !request.output.empty() || !request.depth.file.empty())
    output.file = request.output;
  // The sky of an overview is only its background, which must not change with the exposure.
  if (request.is_overview() && request.scene.render.mode != renderer::RenderMode::flat)
    output.background = renderer::k_overview_background;
  const std::optional<image::ImageFormat> format = image::image_format(output.file);
  if (output.transparent && format == image::ImageFormat::jpeg)
    throw file_error(output.file, "JPEG has no alpha",
                     "the extension .png, .exr or .tif, or no --transparent");
  const bool is_on_ground = request.views.from_above && format == image::ImageFormat::geotiff;
  if (!request.ground.layers.empty() && !is_on_ground)
    throw file_error(output.file, "layers of the ground require an orthophoto",
                     "--orthographic top and the extension .tif");
  if (!request.ground.layers.empty() && !request.scene.cloud)
    throw file_error(output.file, "layers of the ground require a cloud", "CLOUD..., or other --layers");
  if (!request.layers.empty()) output.layers = request.layers;
  if (output.file.empty()) return check_without_image(request);
  const bool is_color = request.layers == std::vector{image::Layer::color};
  if (!request.layers.empty() && !(is_on_ground && is_color) && format != image::ImageFormat::exr)
    throw file_error(output.file, "layers require EXR", "the extension .exr, or no --layers");
  image::check_image_name(output.file);
}

/// Leaves what is beside the image to its first part. Errors: there is no image that has parts.
void complete_part(RenderRequest& request) {
  if (!request.part) return;
  if (!request.flight.file.empty())
    throw file_error(request.flight.file, "a video has no parts", "images, as in -o yard_%05d.png");
  if (!request.ground.with_color)
    throw file_error(request.scene.output.file, "--part requires an image", "color among --layers");
  if (request.part->number == 1) return;
  request.ground.layers.clear();
  request.legend.clear();
  request.depth = {};
}

/// Completes the scene. Errors: settings that contradict each other or do not fit the scene.
void complete_scene(RenderRequest& request) {
  check_surfaces(request);
  renderer::Scene& scene = request.scene;
  if (request.partial) cloud_settings(request, "--partial").partial = true;
  if (request.in_view) cloud_settings(request, "--in-view");
  if (!request.legend.empty() && cloud_settings(request, "--legend").color.by == image::PointColor::rgb)
    image::check_legend({.by = image::PointColor::rgb});
  if (scene.cloud) renderer::check_shape(*scene.cloud);
  for (const renderer::Object& object : scene.objects) {
    const auto* const model = std::get_if<renderer::Model>(&object);
    if (model != nullptr && model->mesh) check_mesh_name(model->mesh->file);
  }
  // Without points there is no extent to choose a distance by.
  if (request.adds_models && !scene.cloud && scene.render.mode == renderer::RenderMode::ambient_occlusion &&
      !scene.render.ao_distance)
    throw input_error("an image without a cloud requires a distance for ambient occlusion",
                      "--ao-distance METRES");
  // Enough to look at, and few seconds of work; limits by noise or time have their own end.
  const bool is_quick = request.is_overview() && !request.target_noise && !request.time_limit;
  scene.render.samples =
      request.samples.value_or(is_quick ? renderer::k_overview_samples : scene.render.samples);
  complete_output(request);
  complete_part(request);
}

/// requested_views(), or those of a flight.
std::vector<camera::NamedCamera> planned_views(const RenderRequest& request,
                                               std::vector<std::string>& warnings) {
  const std::optional<camera::Camera>& of_scene = request.scene.camera;
  if (request.flight.orbits) return {};
  if (request.flight.keyframes.empty()) return requested_views(request.views, of_scene, warnings);
  ViewsRequest keyframes = request.views;
  keyframes.file = request.flight.keyframes;
  // Trajectories have no lens: a plain one.
  const ImageSize size = request.views.size.value_or(ImageSize{1280, 720});
  const camera::Camera lens =
      of_scene.value_or(camera::pinhole_from_fov(size.width, size.height, 50.0, camera::CameraPose()));
  return flight_views(request.flight, requested_views(keyframes, lens, warnings));
}

/// The name of each image; empty if they are not written.
std::vector<fs::path> names_of_images(const RenderRequest& request,
                                      std::span<const camera::NamedCamera> views) {
  const fs::path& file = request.scene.output.file;
  // Those of an orbit are chosen once the cloud is loaded.
  const std::vector<camera::NamedCamera> of_orbit(static_cast<std::size_t>(request.flight.frames));
  if (request.flight.orbits) views = of_orbit;
  if (file.empty()) return std::vector<fs::path>(std::max<std::size_t>(views.size(), 1));
  const bool is_set = request.views.is_set() || request.flight.given();
  return is_set ? image_names(file, views) : std::vector{file};
}

/// Whether a file exists and was written as a preview. Formats store texts before the pixels.
bool is_preview_of_ours(const fs::path& path) {
  constexpr std::size_t k_most_bytes = 1 << 20;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  InputFile file(path);
  const auto start = file.view_up_to(0, k_most_bytes);
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  return text.find(k_preview_mark) != std::string_view::npos;
}

/// Errors: a preview that is one of the outputs or inputs, exists and is no earlier preview, or cannot be
/// written; a preview that is neither PNG nor JPEG.
void check_preview(const RenderRequest& request, std::span<const fs::path> outputs,
                   std::span<const fs::path> inputs) {
  const fs::path& preview = request.preview;
  if (preview.empty()) return;
  const std::optional<image::ImageFormat> format = image::image_format(preview);
  if (format != image::ImageFormat::png && format != image::ImageFormat::jpeg)
    throw file_error(preview, "unknown output format", "the extension .png, .jpg or .jpeg");
  if (!request.checkpoint.file.empty() && same_file(preview, request.checkpoint.file))
    throw file_error(preview, "preview and checkpoint have the same name");
  for (const fs::path& output : outputs)
    if (same_file(preview, output)) throw file_error(preview, "two outputs have this name", "another name");
  const bool continues = request.skips_existing || request.checkpoint.resume;
  check_writable(preview, request.overwrite || (continues && is_preview_of_ours(preview)), inputs);
}

/// Plans the images. Errors: those of their names and files, and of previews and checkpoints.
void plan_images(RenderPlan& plan, std::span<const fs::path> inputs) {
  const RenderRequest& request = plan.request();
  std::vector<fs::path> outputs;
  const std::vector<fs::path> names = names_of_images(request, plan.views);
  // It belongs to one image, by its name.
  if (names.size() > 1 && names.front().empty() && !request.checkpoint.file.empty())
    throw input_error("--checkpoint requires names of the images", "-o FILE");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const fs::path& written = outputs.emplace_back(request.written_file(names[i]));
    if (request.skips_existing && file_exists(written)) {
      plan.finished.push_back(names[i]);
      continue;
    }
    if (request.ground.with_color && !written.empty()) check_writable(written, request.overwrite, inputs);
    plan.images.push_back({i, names[i]});
  }
  for (const fs::path& file : request.ground.files(request.scene.output.file)) {
    check_writable(file, request.overwrite, inputs);
    outputs.push_back(file);
  }
  if (!request.legend.empty()) outputs.push_back(request.legend);
  check_preview(request, outputs, inputs);
  PlannedWork work{.reads = {inputs.begin(), inputs.end()}, .writes = std::move(outputs)};
  check_checkpoint(request.checkpoint, request.overwrite, work, renderer::is_checkpoint,
                   "an Alidade checkpoint");
}

DepthPlan plan_depth(const RenderPlan& plan, std::span<const fs::path> inputs) {
  const RenderRequest& request = plan.request();
  // The run that wrote the checkpoint wrote them before.
  const bool resumes = request.checkpoint.resume && file_exists(request.checkpoint.file);
  std::vector<fs::path> others = plan.finished;
  for (const PlannedImage& image : plan.images) others.push_back(image.file);
  others.insert(others.end(), {request.legend, request.preview, request.checkpoint.file});
  std::ranges::copy(request.ground.files(request.scene.output.file), std::back_inserter(others));
  return plan_depth_maps(request.depth, request.views, plan.views,
                         {request.overwrite, request.skips_existing || (resumes && !request.overwrite)},
                         inputs, others);
}

/// What to resume from. Empty without --resume. Errors: those of the checkpoint's head; it belongs to an
/// image that is neither finished nor the first.
std::optional<Resumption> find_resumption(const RenderPlan& plan) {
  const CheckpointRequest& checkpoint = plan.request().checkpoint;
  if (!checkpoint.resume) return std::nullopt;
  const std::string file = checkpoint.file.string();
  if (!file_exists(checkpoint.file)) return Resumption{{}, beginning_text(checkpoint)};
  const renderer::CheckpointSummary summary = renderer::read_checkpoint_summary(checkpoint.file);
  const std::string image = shown_name(plan.images.front());
  if (summary.image == image_in_checkpoint(plan.images.front().file)) {
    return Resumption{summary.samples_taken,
                      fmt::format("resuming from {}: {} has {:.0f} % of its samples after {}", file, image,
                                  100.0 * summary.share, clock_time(summary.seconds))};
  }
  if (std::ranges::find(plan.finished, summary.image, image_in_checkpoint) == plan.finished.end())
    throw file_error(file, "the checkpoint belongs to another image", fmt::format("one of {}", image),
                     summary.image);
  return Resumption{
      {},
      fmt::format("{} belongs to {}, which is finished: starting from the beginning", file, summary.image)};
}

/// Whether a legend is to be written: it is requested, and no existing one may stay. Errors: as
/// check_writable(); it would be one of the images.
bool plan_legend(const RenderPlan& plan, std::span<const fs::path> inputs) {
  const RenderRequest& request = plan.request();
  if (request.legend.empty()) return false;
  // The run that wrote the checkpoint wrote the legend.
  const bool may_stay = !request.overwrite && (request.skips_existing || plan.is_resumed());
  if (may_stay && file_exists(request.legend)) return false;
  check_writable(request.legend, request.overwrite, inputs);
  for (const PlannedImage& image : plan.images)
    if (image.file.lexically_normal() == request.legend.lexically_normal())
      throw file_error(image.file, "image and legend have the same name");
  return true;
}

/// Errors: the cloud cannot be read in part, or something requires all of it.
void check_in_view(const RenderPlan& plan) {
  const RenderRequest& request = plan.request();
  const renderer::CloudSettings& settings = *request.scene.cloud;
  if (request.files.size() != 1 || !has_parts(request.files.inputs.front())) {
    throw file_error(settings.files.empty() ? "" : settings.files.front().string(),
                     "--in-view requires a single cloud in a database",
                     "a database written by 'alidade sql load'");
  }
  if (plan.views.empty())
    throw input_error("--in-view requires a camera that does not depend on the cloud",
                      "--camera, --panorama or a scene file");
  if (settings.max_level < renderer::k_max_level || settings.partial)
    throw Error({.problem = "--in-view cannot be combined with --max-level or --partial"});
  if (std::ranges::count(request.scene.output.layers, image::Layer::id) > 0)
    throw Error({.problem = "--in-view cannot be combined with the layer id"});
}

}  // namespace

PlannedWork RenderPlan::work() const {
  if (is_empty()) return {.writes = {request().flight.file}};
  PlannedWork work{.clouds = request().files,
                   .partial = request().scene.cloud && request().scene.cloud->partial,
                   .reads = request().other_inputs(),
                   .bytes_per_point = 28.0};
  // Films, and OpenImageIO.
  const ImageSize size = request().views.size.value_or(k_overview_size);
  double pixels = views.empty() ? 1.0 * size.width * size.height : 0.0;
  for (const camera::NamedCamera& view : views)
    pixels = std::max(pixels, 1.0 * view.camera.width * view.camera.height);
  work.bytes_beside = 160e6 + 43.0 * pixels;
  const auto write = [&work](const fs::path& file) { work.writes.push_back(file); };
  // Images of a video are removed.
  write(request().flight.file);
  if (request().flight.file.empty() && request().ground.with_color)
    for (const PlannedImage& image : images) write(request().written_file(image.file));
  if (!images.empty()) {
    std::ranges::for_each(request().ground.files(request().scene.output.file), write);
    write(request().preview);
    write(request().checkpoint.file);
  }
  if (writes_legend) write(request().legend);
  for (const DepthMap& map : depth.maps) {
    write(map.file);
    write(map.mask);
  }
  if (depth.transforms) write(depth.transforms->output);
  return work;
}

std::string shown_name(const PlannedImage& image) {
  return image.file.empty() ? "the image" : image.file.string();
}

std::string image_in_checkpoint(const fs::path& image) {
  if (image.empty()) return {};
  return name_in_checkpoint(fs::absolute(image).lexically_normal());
}

void check_view(const camera::NamedCamera& view, const fs::path& image, const renderer::Scene& scene,
                const renderer::LoadedCloud* cloud) {
  try {
    if (image::image_format(image) == image::ImageFormat::geotiff) camera::ground_transform(view.camera);
    if (cloud != nullptr) renderer::check_camera_position(view.camera, scene, *cloud);
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    if (!view.name.empty()) parts.problem = fmt::format("camera '{}': {}", view.name, parts.problem);
    throw Error(parts);
  }
}

RenderPlan plan(const RenderRequest& given) {
  RenderRequest request = given;
  take_video(request.flight, request.views, request.output, request.overwrite);
  std::shared_ptr<const EmptyFolder> frames;
  if (!request.flight.file.empty())
    frames = std::make_shared<const EmptyFolder>(request.output.parent_path());
  request.returns_films = request.returns_films && request.output.empty() && request.depth.file.empty();
  complete_scene(request);
  if (request.scene.cloud && request.files.empty()) {
    request.files = resolve_clouds(request.scene.cloud->files, cloud_formats());
    if (request.view.view) request.files = request.view.apply(std::move(request.files));
  }
  if (request.scene.cloud && request.scene.cloud->max_level < renderer::k_max_level &&
      stored_organisation(request.files) != Organisation::layered) {
    request.files.check_files();
    throw file_error(request.files.title(), "max_level requires a layered index",
                     "an index file made with --organisation layered");
  }
  RenderPlan plan(std::move(request), {});
  plan.frames = std::move(frames);
  plan.views = planned_views(plan.request(), plan.warnings);
  std::vector<fs::path> inputs = plan.request().other_inputs();
  if (const auto& cloud = plan.request().scene.cloud)
    std::ranges::copy(cloud->files, std::back_inserter(inputs));
  if (!plan.request().scene.output.file.empty() || plan.request().returns_films) plan_images(plan, inputs);
  plan.depth = plan_depth(plan, inputs);
  if (plan.is_empty()) return plan;
  if (!plan.images.empty()) plan.resumption = find_resumption(plan);
  plan.writes_legend = plan_legend(plan, inputs);
  for (const PlannedImage& image : plan.images)
    if (!plan.views.empty()) check_view(plan.views[image.view], image.file, plan.request().scene, nullptr);
  if (plan.request().in_view) check_in_view(plan);
  return plan;
}

}  // namespace alidade::jobs
