// SPDX-License-Identifier: MIT
#include "tools/render/first_looks.h"

#include <fmt/format.h>
#include <algorithm>
#include <memory>
#include <vector>

#include "renderer/cloud_in_view.h"
#include "renderer/render.h"
#include "tools/render/light_and_color.h"
#include "tools/render/long_render.h"

namespace alidade::tools {
namespace {

constexpr std::uint64_t k_growth = 8;
// Two cores render this in half a second.
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

/// Renders a scene with a part of its cloud and shows the picture.
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
    if (verbosity == Verbosity::verbose) say_note(fmt::format("no early preview: {}", error.what()));
  }
}

}  // namespace alidade::tools
