// SPDX-License-Identifier: MIT
#include "renderer/render.h"

#include <fmt/format.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <mutex>

#include "octree/query.h"
#include "renderer/camera/projection.h"
#include "renderer/integrator.h"

namespace alidade {
namespace {

using Clock = std::chrono::steady_clock;

/// Mean and spread of a pixel's samples, taken in order. Source: Welford 1962.
class RunningMean {
 public:
  void add(const glm::dvec3& value) {
    ++count_;
    const glm::dvec3 difference = value - mean_;
    mean_ += difference / static_cast<double>(count_);
    squares_ += difference * (value - mean_);
  }
  Rgb mean() const { return Rgb(mean_); }
  Rgb variance_of_mean() const { return count_ < 2 ? Rgb(0.0f) : Rgb(squares_ / (count_ * (count_ - 1.0))); }

 private:
  glm::dvec3 mean_{0.0}, squares_{0.0};
  int count_ = 0;
};

/// Passes work done by many threads on to a Progress: one thread at a time, and not too often.
class SharedProgress {
 public:
  SharedProgress(const Progress& progress, std::uint64_t total) : progress_(progress), total_(total) {}

  /// Throws Cancelled in every thread once the task is to stop.
  void add(std::uint64_t amount) {
    done_ += amount;
    if (!progress_) return;
    if (stopped_) throw Cancelled();
    const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
    const Clock::time_point now = Clock::now();
    if (!lock || now < next_report_) return;
    next_report_ = now + std::chrono::milliseconds(50);
    if (progress_(done_, total_)) return;
    stopped_ = true;
    throw Cancelled();
  }
  void finish() const { report(progress_, total_, total_); }

 private:
  const Progress& progress_;
  const std::uint64_t total_;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  Clock::time_point next_report_ = Clock::now();
};

/// One thread's samples, told to the others every few milliseconds of work.
class SampleCount {
 public:
  explicit SampleCount(SharedProgress& progress) : progress_(progress) {}

  void add_one() {
    constexpr int k_samples_per_report = 2048;
    if (++pending_ == k_samples_per_report) report_pending();
  }
  void report_pending() {
    progress_.add(pending_);
    pending_ = 0;
  }

 private:
  SharedProgress& progress_;
  std::uint64_t pending_ = 0;
};

/// Everything a pixel needs; the same for all of them.
struct Task {
  const Projection& projection;
  const RenderSettings& settings;
  const World& world;
  const Lights& lights;
};

/// Depth along the camera's axis over distance along the ray. A panorama has no axis: its depth is the
/// distance.
double depth_share(const Camera& camera, const Ray& ray) {
  if (std::holds_alternative<EquirectangularLens>(camera.lens)) return 1.0;
  return glm::dot(ray.direction, camera.pose.forward);
}

void fill_layers(const Task& task, int x, int y, Film& film) {
  const std::optional<Ray> seen = task.projection.ray({x + 0.5, y + 0.5});
  if (!seen) return;
  const Ray& ray = *seen;
  const std::optional<Intersection> met = task.world.nearest(ray, {});
  if (!met) return;
  const Surface surface = task.world.surface_at(ray, *met);
  const std::size_t pixel = film.index(x, y);
  film.depth[pixel] = static_cast<float>(met->t * depth_share(task.projection.camera(), ray));
  film.distance[pixel] = static_cast<float>(met->t);
  film.normal[pixel] =
      glm::vec3(glm::dot(surface.normal, ray.direction) > 0.0 ? -surface.normal : surface.normal);
  film.position[pixel] = surface.position;
  film.albedo[pixel] = albedo(*surface.material, surface.color);
  film.id[pixel] =
      met->on_cloud ? static_cast<std::uint32_t>(met->index + 1) : static_cast<std::uint32_t>(~met->index);
}

std::uint64_t render_pixel(const Task& task, int x, int y, Film& film, SampleCount& samples) {
  RunningMean color;
  int met_count = 0;
  std::uint64_t ray_count = 1;
  for (int index = 0; index < task.settings.samples; ++index) {
    Sampler sampler(task.settings.seed, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                    static_cast<std::uint32_t>(index));
    const glm::dvec2 place = sampler.next_2d();
    const std::optional<Ray> ray = task.projection.ray({x + place.x, y + place.y});
    // Outside the circle of a fisheye there is no light and no surface.
    const PathResult path =
        ray ? trace_path(task.world, task.lights, *ray, sampler, task.settings.max_bounces) : PathResult{};
    color.add(path.radiance);
    met_count += path.met_surface ? 1 : 0;
    ray_count += path.ray_count;
    samples.add_one();
  }
  const std::size_t pixel = film.index(x, y);
  film.color[pixel] = color.mean();
  film.variance[pixel] = color.variance_of_mean();
  film.alpha[pixel] = static_cast<float>(met_count) / static_cast<float>(task.settings.samples);
  fill_layers(task, x, y, film);
  return ray_count;
}

}  // namespace

void check_camera_place(const Camera& camera, const Scene& scene, const LoadedCloud& cloud) {
  if (std::holds_alternative<OrthographicLens>(camera.lens)) return;
  const bool all_levels = !scene.cloud || scene.cloud->max_level >= k_max_level;
  const int max_level = all_levels ? k_all_levels : scene.cloud->max_level;
  const std::vector<PointHit> around =
      find(cloud.octree, camera.pose.position, {.radius = cloud.radius, .k = 1, .max_level = max_level});
  if (around.empty()) return;
  throw Error(
      {.problem = fmt::format("the camera stands inside the sphere of point {}", around.front().point_id),
       .expected = fmt::format("a place more than {:.6g} from every point", cloud.radius),
       .found = fmt::format("{:.6g} away", around.front().distance)});
}

Film render(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options,
            RenderStatistics* statistics) {
  constexpr int k_tile = 16;
  if (!scene.camera) throw Error({.problem = "the scene has no camera"});
  if (scene.render.samples < 1) {
    throw Error({.problem = "bad number of samples",
                 .expected = "at least 1",
                 .found = std::to_string(scene.render.samples)});
  }
  const Clock::time_point start = Clock::now();
  const Camera& camera = *scene.camera;
  check_camera(camera);
  if (cloud != nullptr) check_camera_place(camera, scene, *cloud);
  const Projection projection(camera);
  const World world(scene, cloud);
  const Lights lights(scene);
  const Task task{projection, scene.render, world, lights};
  Film film(camera.width, camera.height);
  SharedProgress progress(options.progress, std::uint64_t{film.color.size()} * scene.render.samples);
  std::atomic<std::uint64_t> ray_count{0};

  tbb::parallel_for(
      tbb::blocked_range2d<int>(0, camera.height, k_tile, 0, camera.width, k_tile),
      [&](const tbb::blocked_range2d<int>& tile) {
        std::uint64_t tile_rays = 0;
        SampleCount samples(progress);
        for (int y = tile.rows().begin(); y < tile.rows().end(); ++y) {
          for (int x = tile.cols().begin(); x < tile.cols().end(); ++x)
            tile_rays += render_pixel(task, x, y, film, samples);
        }
        ray_count += tile_rays;
        samples.report_pending();
      },
      tbb::simple_partitioner());

  progress.finish();
  if (statistics != nullptr) {
    statistics->ray_count = ray_count;
    statistics->seconds = std::chrono::duration<double>(Clock::now() - start).count();
  }
  return film;
}

}  // namespace alidade
