// SPDX-License-Identifier: MIT
// Octree: build and ray queries, beside Embree's spheres on the same rays where Embree 3 is installed.
//   ./dev bench octree --benchmark_filter=1000000 --benchmark_repetitions=5
#include <benchmark/benchmark.h>

#include <memory>

#include "octree/simd/instruction_set.h"
#include "tests/bench/bench_site.h"
#ifdef ALIDADE_WITH_EMBREE
#include "tests/bench/embree_spheres.h"
#endif

namespace alidade::bench {
namespace {

const std::vector<Ray>& rays_of(const BenchSite& site, const std::string& set) {
  return set == "primary" ? site.primary : set == "secondary" ? site.secondary : site.sun;
}

void count_rays(benchmark::State& state, std::size_t rays) {
  state.counters["rays"] =
      benchmark::Counter(static_cast<double>(state.iterations() * rays), benchmark::Counter::kIsRate);
}

void build_octree(benchmark::State& state) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    const Octree octree = build(site.cloud);
    benchmark::DoNotOptimize(octree.view().nodes);
  }
  state.counters["points"] = benchmark::Counter(static_cast<double>(state.iterations() * site.cloud.size()),
                                                benchmark::Counter::kIsRate);
  state.counters["bytes_per_point"] =
      static_cast<double>(site.octree.memory()) / static_cast<double>(site.cloud.size());
}

void closest_single(benchmark::State& state, const std::string& set, InstructionSet instruction_set) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(state.range(0)));
  const Octree octree = site.octree.with_instruction_set(instruction_set);
  const std::vector<Ray>& rays = rays_of(site, set);
  const RayQuery query = site.query();
  for (auto _ : state) {
    std::uint64_t sum = 0;
    for (const Ray& ray : rays) {
      if (const std::optional<Hit> hit = closest(octree, ray, query)) sum += hit->point_id;
    }
    benchmark::DoNotOptimize(sum);
  }
  count_rays(state, rays.size());
}

void occluded_single(benchmark::State& state, const std::string& set) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(state.range(0)));
  const std::vector<Ray>& rays = rays_of(site, set);
  const RayQuery query = site.query();
  for (auto _ : state) {
    std::size_t sum = 0;
    for (const Ray& ray : rays) sum += occluded(site.octree, ray, query);
    benchmark::DoNotOptimize(sum);
  }
  count_rays(state, rays.size());
}

void closest_batch(benchmark::State& state, const std::string& set) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(state.range(0)));
  const std::vector<Ray>& rays = rays_of(site, set);
  std::vector<std::optional<Hit>> hits(rays.size());
  for (auto _ : state) {
    closest(site.octree, rays, site.query(), hits);
    benchmark::DoNotOptimize(hits.data());
  }
  count_rays(state, rays.size());
}

#ifdef ALIDADE_WITH_EMBREE
void embree_single(benchmark::State& state, const std::string& set, bool any) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(state.range(0)));
  const EmbreeSpheres& spheres = embree_spheres(site);
  const std::vector<Ray>& rays = rays_of(site, set);
  for (auto _ : state) {
    std::uint64_t sum = 0;
    for (const Ray& ray : rays) sum += any ? spheres.occluded(ray) : spheres.closest(ray);
    benchmark::DoNotOptimize(sum);
  }
  count_rays(state, rays.size());
}
#endif

void for_sizes(benchmark::internal::Benchmark* registered) {
  for (const std::int64_t points : {1'000'000, 10'000'000}) registered->Arg(points);
  registered->Unit(benchmark::kMillisecond)->UseRealTime();
}

}  // namespace

void register_all() {
  for_sizes(benchmark::RegisterBenchmark("build", build_octree));
  for (const std::string set : {"primary", "secondary", "sun"}) {
    for (const InstructionSet is : available_instruction_sets()) {
      for_sizes(benchmark::RegisterBenchmark(("closest/" + set + "/" + std::string(name(is))).c_str(),
                                             closest_single, set, is));
    }
    for_sizes(benchmark::RegisterBenchmark(("occluded/" + set).c_str(), occluded_single, set));
    for_sizes(benchmark::RegisterBenchmark(("closest_batch_all_threads/" + set).c_str(), closest_batch, set));
#ifdef ALIDADE_WITH_EMBREE
    for_sizes(benchmark::RegisterBenchmark(("embree_closest/" + set).c_str(), embree_single, set, false));
    for_sizes(benchmark::RegisterBenchmark(("embree_occluded/" + set).c_str(), embree_single, set, true));
#endif
  }
}

}  // namespace alidade::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  alidade::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
