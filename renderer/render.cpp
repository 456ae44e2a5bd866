// SPDX-License-Identifier: MIT
#include "renderer/render.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/checkpoint.h"
#include "renderer/image_fingerprint.h"
#include "renderer/image_renderer.h"
#include "renderer/integrator.h"
#include "renderer/noise.h"

namespace alidade::renderer {
namespace {

void check_options(const Scene& scene, const RenderOptions& options) {
  if (!scene.camera) throw Error({.problem = "the scene has no camera"});
  const int samples = scene.render.samples;
  check_that(samples >= 1 && samples <= k_max_samples, "invalid number of samples", "1 to 16777216",
             std::to_string(samples));
  if (const auto& limit = options.time_limit)
    check_that(*limit >= 0.0, "invalid time limit", "seconds, at least 0", std::to_string(*limit));
  if (const auto& target = options.target_noise)
    check_that(*target > 0.0, "invalid noise target", "a positive number", std::to_string(*target));
  if (const auto& checkpoint = options.checkpoint)
    check_that(checkpoint->interval > 0.0, "invalid checkpoint interval", "a positive number of seconds",
               std::to_string(checkpoint->interval));
  const auto [number, count] = options.part;
  check_that(count >= 1 && count <= k_most_parts && number >= 1 && number <= count, "invalid part",
             fmt::format("1/N to N/N, N at most {}", k_most_parts), part_text(options.part));
  check_that(count == 1 || (!options.time_limit && !options.target_noise),
             "parts support neither a time limit nor a noise target", "a number of samples");
  if (const auto& preview = options.preview)
    check_that(preview->interval >= 0.0 && preview->longest_side >= 1, "invalid preview options",
               "seconds, at least 0, and at least one pixel", std::to_string(preview->interval));
}

bool wants(const RenderOptions& options, image::Layer layer) {
  return !options.layers || std::ranges::find(*options.layers, layer) != options.layers->end();
}

/// The layers that come from the pixels' centres, as far as they are requested.
std::vector<image::Layer> center_layers(const RenderOptions& options) {
  std::vector<image::Layer> layers = options.layers.value_or(image::all_layers());
  std::erase_if(layers, [](image::Layer layer) {
    return layer == image::Layer::color || layer == image::Layer::variance;
  });
  return layers;
}

std::uint64_t pixel_count(const TileGrid& grid, ImagePart part) {
  std::uint64_t count = 0;
  if (part.count == 1) return grid.pixel_count();
  for (const std::size_t tile : tiles_of(grid, part)) count += grid.box(tile).count();
  return count;
}

/// What was reached.
RenderStatistics statistics_of(const ImageState& state, const Scene& scene, const RenderOptions& options,
                               double floor) {
  RenderStatistics statistics;
  statistics.ray_count = state.ray_count();
  std::uint32_t least = state.order.empty() ? 0 : k_max_samples, most = 0;
  for (const std::size_t tile : state.order) {
    least = std::min(least, state.tiles[tile].samples);
    most = std::max(most, state.tiles[tile].samples);
  }
  statistics.least_samples = static_cast<int>(least);
  statistics.most_samples = static_cast<int>(most);
  if (!state.order.empty())
    statistics.mean_samples = static_cast<double>(state.sample_count()) /
                              static_cast<double>(pixel_count(state.grid, options.part));
  if (state.with_noise) statistics.noise = reached_noise(state, floor);
  statistics.tiles = state.order.size();
  for (const std::size_t each : state.order) {
    const TileState& tile = state.tiles[each];
    if (tile.stopped) continue;
    if (options.target_noise) ++statistics.noisy_tiles;
    if (tile.samples < static_cast<std::uint32_t>(scene.render.samples)) ++statistics.hurried_tiles;
  }
  return statistics;
}

/// What the rays through an image's pixels have given.
struct RenderedState {
  ImageState state;
  image::Film film;  ///< the layers of the pixels' centres
};

RenderedState render_state(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options,
                           RenderStatistics* statistics) {
  check_options(scene, options);
  const camera::Camera& camera = *scene.camera;
  camera::check_camera(camera);
  if (cloud != nullptr) check_camera_position(camera, scene, *cloud);
  const camera::Projection projection(camera);
  const World world(scene, cloud);
  const Lights lights(scene);
  const double floor = noise_floor(scene.output.exposure);

  RenderedState rendered{{camera.width, camera.height, keeps_noise(options), options.part}, {}};
  ImageState& state = rendered.state;
  Fingerprint fingerprint;
  if (options.checkpoint) {
    fingerprint = image_fingerprint(scene, cloud, options);
    const std::filesystem::path& file = options.checkpoint->file;
    if (options.checkpoint->resume && std::filesystem::exists(file)) {
      read_checkpoint(InputFile(file), fingerprint, scene.render.samples, state);
      if (options.checkpoint->resumed) options.checkpoint->resumed();
    }
  }
  image::Film& film = rendered.film = image::Film(camera.width, camera.height, center_layers(options));
  RenderWatch watch(options, state, scene.render.samples, std::move(fingerprint));
  const RenderTask task{projection,
                        scene.render,
                        world,
                        lights,
                        ambient_occlusion_distance(scene.render, cloud),
                        scene.output.transparent || scene.output.background,
                        [&watch] { watch.look(); }};
  try {
    render_image(task, options, floor, state, watch, film);
    watch.finish();
  } catch (const Cancelled&) {
    watch.save();
    throw;
  }
  if (statistics != nullptr) {
    *statistics = statistics_of(state, scene, options, floor);
    statistics->seconds = watch.seconds();
    if (film.holds_any()) statistics->ray_count += pixel_count(state.grid, options.part);
  }
  return rendered;
}

}  // namespace

std::string part_text(ImagePart part) {
  return fmt::format("{}/{}", part.number, part.count);
}

std::uint64_t pixel_count(int width, int height, ImagePart part) {
  return pixel_count(TileGrid(width, height), part);
}

void check_camera_position(const camera::Camera& camera, const Scene& scene, const LoadedCloud& cloud) {
  if (std::holds_alternative<camera::OrthographicLens>(camera.lens)) return;
  if (scene.cloud && scene.cloud->shape != PointShape::sphere) return;  // discs have no inside
  const bool all_levels = !scene.cloud || scene.cloud->max_level >= k_max_level;
  const int max_level = all_levels ? k_all_levels : scene.cloud->max_level;
  const std::optional<SphereAround> sphere = sphere_around(cloud, camera.pose.position, max_level);
  if (!sphere || sphere->distance < camera.near) return;
  throw Error(
      {.problem = fmt::format("the camera is inside the sphere of point {}", sphere->point_id),
       .expected = fmt::format("a distance above {:.6g}, or --near {:.3g} to look past it", sphere->radius,
                               std::max(1.01 * sphere->distance, 0.01 * sphere->radius)),
       .found = fmt::format("{:.6g}", sphere->distance)});
}

bool keeps_noise(const RenderOptions& options) {
  return options.target_noise || wants(options, image::Layer::variance);
}

image::Film render(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options,
                   RenderStatistics* statistics) {
  RenderedState rendered = render_state(scene, cloud, options, statistics);
  move_into_film(rendered.state, wants(options, image::Layer::variance), rendered.film);
  return std::move(rendered.film);
}

void render_part(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options,
                 const PartOutput& output, RenderStatistics* statistics) {
  const RenderedState rendered = render_state(scene, cloud, options, statistics);
  Fingerprint fingerprint = image_fingerprint(scene, cloud, options);
  // Machines may use different folders.
  std::erase_if(fingerprint, [](const FingerprintEntry& entry) { return entry.name == "picture"; });
  fingerprint.insert(fingerprint.end(), output.image.begin(), output.image.end());
  write_part(output.file, fingerprint, scene.render.samples, rendered.state, rendered.film, output.overwrite);
}

}  // namespace alidade::renderer
