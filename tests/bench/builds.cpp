// SPDX-License-Identifier: MIT
// Build times and memory, of the octree and of Embree's spheres.
#include <benchmark/benchmark.h>

#include <string>

#include "octree/build.h"
#include "octree/spacing.h"
#include "surface/point_surface.h"
#include "tests/bench/bench_site.h"
#include "tests/bench/process_memory.h"
#include "tests/bench/ray_bench.h"
#include "tests/bench/timing.h"
#ifdef ALIDADE_WITH_EMBREE
#include "tests/bench/embree_scene.h"
#endif

namespace alidade::bench {
namespace {

void report_per_point(benchmark::State& state, const char* name, std::size_t bytes, std::int64_t points) {
  state.counters[name] = static_cast<double>(bytes) / static_cast<double>(points);
}

/// Peak memory is what the build takes beside the cloud.
template <class Build>
void time_build(benchmark::State& state, const PointCloud& cloud, int threads, const Build& build_octree) {
  const auto points = static_cast<std::int64_t>(cloud.size());
  forget_peak();
  const std::size_t before = process_memory().resident;
  std::size_t memory = 0;
  for (auto _ : state) memory = on_threads(threads, build_octree);
  report_per_point(state, "bytes_per_point", memory, points);
  report_per_point(state, "peak_bytes_per_point", process_memory().peak - before, points);
}

void build_octree(benchmark::State& state, std::int64_t points, int threads) {
  const PointCloud& cloud = bench_site(static_cast<std::size_t>(points)).cloud;
  time_build(state, cloud, threads, [&] { return build(cloud).memory(); });
}

/// A cloud of the same points on a lattice of 0.1 mm that spans more than 2^21 steps.
void build_wide(benchmark::State& state, std::int64_t points, int threads) {
  PointCloud cloud = bench_site(static_cast<std::size_t>(points)).cloud;
  cloud.lattice.scale = glm::dvec3(0.0001);
  for (LatticePosition& position : cloud.positions) position *= 10;
  time_build(state, cloud, threads, [&] { return build(cloud).memory(); });
}

void build_without_ids(benchmark::State& state, std::int64_t points, int threads) {
  PointCloud cloud = bench_site(static_cast<std::size_t>(points)).cloud;
  time_build(state, cloud, threads, [&] { return build_in_stored_order(cloud).memory(); });
}

void fit_surfaces(benchmark::State& state, std::int64_t points, int threads) {
  const Octree octree =
      with_spacings(bench_site(static_cast<std::size_t>(points)).octree, k_surface_neighbours);
  for (auto _ : state) on_threads(threads, [&] { return with_surfaces(octree).size(); });
  state.counters["seconds_per_point"] = benchmark::Counter(
      static_cast<double>(points), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

#ifdef ALIDADE_WITH_EMBREE
/// Embree's memory with the vertices it reads, as the process grows.
void build_embree(benchmark::State& state, std::int64_t points) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  const std::size_t before = process_memory().resident;
  std::unique_ptr<test::EmbreeSpheres> scene;
  for (auto _ : state) scene = embree_scene(site);
  report_per_point(state, "bytes_per_point", process_memory().resident - before, points);
  report_per_point(state, "allocated_bytes_per_point", scene->memory(), points);
}
#endif

}  // namespace

void register_octree_builds() {
  for (const std::int64_t points : k_site_sizes) {
    const std::string count = std::to_string(points);
    for (const int threads : {1, 2}) {
      add_benchmark(threads, {"build", with_threads("octree", threads), count}, build_octree, points,
                    threads);
      add_benchmark(threads, {"build", with_threads("wide", threads), count}, build_wide, points, threads);
      add_benchmark(threads, {"build", with_threads("without_ids", threads), count}, build_without_ids,
                    points, threads);
      add_benchmark(threads, {"build", with_threads("surfaces", threads), count}, fit_surfaces, points,
                    threads);
    }
  }
}

#ifdef ALIDADE_WITH_EMBREE
void register_embree_builds() {
  for (const std::int64_t points : k_site_sizes)
    add_benchmark(2, {"build", with_threads("embree", 2), std::to_string(points)}, build_embree, points);
}
#endif

}  // namespace alidade::bench
