// SPDX-License-Identifier: MIT
#include "tools/render/load_scene.h"

#include <fmt/format.h>
#include <algorithm>

#include "camera/camera.h"
#include "image/color_points.h"
#include "renderer/cloud_in_view.h"
#include "renderer/load_cloud.h"
#include "tools/cloud/load_cloud.h"
#include "tools/console.h"

namespace alidade::tools {
namespace {

constexpr std::uint64_t k_growth = 8;
// What 2 cores do in half a second.
constexpr int k_longest_side = 640;
constexpr int k_samples = 8;
constexpr double k_seconds = 0.5;

/// The camera for a picture no larger than a first look needs.
camera::Camera reduced(const camera::Camera& camera) {
  const double share = static_cast<double>(k_longest_side) / std::max(camera.width, camera.height);
  if (share >= 1.0) return camera;
  const auto side = [&](int pixels) { return std::max(1, static_cast<int>(pixels * share)); };
  return camera::resized(camera, side(camera.width), side(camera.height));
}

/// Renders a scene of which only a part of the cloud is there, and shows it.
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

}  // namespace

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
    if (verbosity == Verbosity::verbose) say_note(fmt::format("no first look: {}", error.what()));
  }
}

namespace {

void check(const renderer::CloudSettings& settings, const renderer::Scene& scene, const CloudInputs& clouds,
           std::span<const View> views) {
  if (clouds.size() != 1 || !has_parts(clouds.inputs.front())) {
    throw Error({.file = settings.files.empty() ? "" : settings.files.front().string(),
                 .problem = "--in-view needs one cloud that lies in a database",
                 .expected = "a database that 'alidade sql load' wrote"});
  }
  if (views.empty())
    throw Error({.problem = "--in-view needs a camera that does not go by the cloud",
                 .expected = "--camera, --panorama or a scene file"});
  if (settings.max_level < renderer::k_max_level || settings.partial)
    throw Error({.problem = "--in-view cannot be used with --max-level or --partial"});
  if (std::ranges::find(scene.output.layers, image::Layer::id) != scene.output.layers.end()) {
    throw Error({.problem = "--in-view does not know the ids that points have in the whole cloud",
                 .expected = "layers without id"});
  }
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

}  // namespace

renderer::LoadedCloud load_in_view(const RenderCommand& command, const renderer::Scene& scene,
                                   const CloudInputs& clouds, std::span<const View> views,
                                   const Progress& measuring) {
  const renderer::CloudSettings& settings = *scene.cloud;
  check(settings, scene, clouds, views);
  const CloudInput& input = clouds.inputs.front();
  const Verbosity verbosity = command.verbosity;
  const char* const unit = part_unit(input);
  ProgressLine line(fmt::format("loading {} in view", unit), unit, verbosity);
  database::CloudPart part = read_database_part(input, view_filters(views, settings.radius.value_or(0.0)),
                                                image::attributes_for(settings.color), line.callback());
  line.finish();
  if (verbosity != Verbosity::quiet && part.chunk_count > 0)
    say_note(
        fmt::format("read {} of {} chunks of {}", part.chunks_read, part.chunk_count, input.name.string()));
  renderer::LoadedCloud loaded =
      renderer::index_cloud(std::move(part.cloud), part.attributes, settings, input.name.string());
  renderer::choose_radius(settings, loaded, measuring);
  return loaded;
}

}  // namespace alidade::tools
