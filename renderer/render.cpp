// SPDX-License-Identifier: MIT
#include "renderer/render.h"

#include <fmt/format.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <mutex>

#include "renderer/camera/projection.h"
#include "renderer/point_radius.h"
#include "renderer/quick_modes.h"
#include "renderer/trace_samples.h"

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

/// Everything a pixel needs; the same for all of them.
struct Task {
  const Projection& projection;
  const RenderSettings& settings;
  const World& world;
  const Lights& lights;
  double ao_distance;
};

/// Depth along the camera's axis over distance along the ray. A panorama has no axis: its depth is the
/// distance.
double depth_share(const Camera& camera, const Ray& ray) {
  if (std::holds_alternative<EquirectangularLens>(camera.lens)) return 1.0;
  return glm::dot(ray.direction, camera.pose.forward);
}

/// A tile of the image, by one thread. Its paths advance together, several samples of every pixel at a time.
class TileRenderer {
 public:
  TileRenderer(const Task& task, const tbb::blocked_range2d<int>& tile, Film& film)
      : task_(task), film_(film) {
    for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
      for (int x = tile.cols().begin(); x < tile.cols().end(); ++x) pixels_.push_back({.x = x, .y = y});
  }

  /// Returns the number of rays.
  std::uint64_t render(SharedProgress& progress) {
    const int samples = task_.settings.samples;
    const int at_once = std::max(1, k_most_paths / static_cast<int>(pixels_.size()));
    for (int first = 0; first < samples; first += at_once) {
      const int last = std::min(first + at_once, samples);
      trace(first, last);
      progress.add(pixels_.size() * static_cast<std::size_t>(last - first));
    }
    for (const Pixel& pixel : pixels_) {
      const std::size_t index = film_.index(pixel.x, pixel.y);
      film_.color[index] = pixel.color.mean();
      film_.variance[index] = pixel.color.variance_of_mean();
      film_.alpha[index] = static_cast<float>(pixel.met_count) / static_cast<float>(samples);
    }
    fill_layers();
    return ray_count_;
  }

 private:
  /// More paths share more of the cloud, fewer stay in the processor's second-level cache.
  static constexpr int k_most_paths = 4096;

  struct Pixel {
    int x = 0, y = 0;
    RunningMean color = {};
    int met_count = 0;
  };

  /// Samples first .. last - 1 of every pixel.
  void trace(int first, int last) {
    std::vector<CameraPath> paths;
    std::vector<bool> sees;
    for (const Pixel& pixel : pixels_) {
      for (int sample = first; sample < last; ++sample) {
        Sampler sampler(task_.settings.seed, static_cast<std::uint32_t>(pixel.x),
                        static_cast<std::uint32_t>(pixel.y), static_cast<std::uint32_t>(sample));
        const glm::dvec2 place = sampler.next_2d();
        const std::optional<Ray> ray = task_.projection.ray({pixel.x + place.x, pixel.y + place.y});
        // Outside the circle of a fisheye there is no light and no surface.
        sees.push_back(ray.has_value());
        if (ray) paths.push_back({*ray, sampler});
      }
    }
    std::vector<PathResult> results(paths.size());
    trace_samples(task_.world, task_.lights, task_.settings, task_.ao_distance, paths, results);
    std::size_t sample = 0, traced = 0;
    for (Pixel& pixel : pixels_) {
      for (int i = first; i < last; ++i) {
        const PathResult path = sees[sample++] ? results[traced++] : PathResult{};
        pixel.color.add(path.radiance);
        pixel.met_count += path.met_surface ? 1 : 0;
        ray_count_ += path.ray_count;
      }
    }
  }

  /// What the centres of the pixels see.
  void fill_layers() {
    std::vector<Ray> rays;
    std::vector<std::size_t> indices;
    for (const Pixel& pixel : pixels_) {
      const std::optional<Ray> ray = task_.projection.ray({pixel.x + 0.5, pixel.y + 0.5});
      if (!ray) continue;
      rays.push_back(*ray);
      indices.push_back(film_.index(pixel.x, pixel.y));
    }
    std::vector<std::optional<Intersection>> met(rays.size());
    task_.world.nearest(rays, std::vector<Departure>(rays.size()), met);
    ray_count_ += pixels_.size();
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (met[i]) fill_layers(rays[i], *met[i], indices[i]);
  }

  void fill_layers(const Ray& ray, const Intersection& met, std::size_t pixel) {
    const Surface surface = task_.world.surface_at(ray, met);
    film_.depth[pixel] = static_cast<float>(met.t * depth_share(task_.projection.camera(), ray));
    film_.distance[pixel] = static_cast<float>(met.t);
    film_.normal[pixel] =
        glm::vec3(glm::dot(surface.normal, ray.direction) > 0.0 ? -surface.normal : surface.normal);
    film_.position[pixel] = surface.position;
    film_.albedo[pixel] = albedo(*surface.material, surface.color);
    film_.id[pixel] =
        met.on_cloud ? static_cast<std::uint32_t>(met.index + 1) : static_cast<std::uint32_t>(~met.index);
  }

  const Task& task_;
  Film& film_;
  std::vector<Pixel> pixels_;
  std::uint64_t ray_count_ = 0;
};

}  // namespace

void check_camera_place(const Camera& camera, const Scene& scene, const LoadedCloud& cloud) {
  if (std::holds_alternative<OrthographicLens>(camera.lens)) return;
  const bool all_levels = !scene.cloud || scene.cloud->max_level >= k_max_level;
  const int max_level = all_levels ? k_all_levels : scene.cloud->max_level;
  const std::optional<SphereAround> sphere = sphere_around(cloud, camera.pose.position, max_level);
  if (!sphere) return;
  throw Error({.problem = fmt::format("the camera stands inside the sphere of point {}", sphere->point_id),
               .expected = fmt::format("a place more than {:.6g} from it", sphere->radius),
               .found = fmt::format("{:.6g} away", sphere->distance)});
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
  const Task task{projection, scene.render, world, lights, ambient_occlusion_distance(scene.render, cloud)};
  Film film(camera.width, camera.height);
  SharedProgress progress(options.progress, std::uint64_t{film.color.size()} * scene.render.samples);
  std::atomic<std::uint64_t> ray_count{0};

  tbb::parallel_for(
      tbb::blocked_range2d<int>(0, camera.height, k_tile, 0, camera.width, k_tile),
      [&](const tbb::blocked_range2d<int>& tile) {
        // Threads have tiles of their own: the rays of one are not to be shared out again.
        tbb::task_arena alone(1);
        alone.execute([&] { ray_count += TileRenderer(task, tile, film).render(progress); });
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
