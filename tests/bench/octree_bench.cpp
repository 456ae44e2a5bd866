// SPDX-License-Identifier: MIT
// Rays and builds, beside Embree's spheres on the same rays where Embree 3 is installed.
//   octree_bench --benchmark_filter=closest/P/.*/10000000/ --benchmark_repetitions=5
// Every name ends with its number of points and "/iterations:1"; nothing of sizes that the filter leaves out
// is made.
#include <benchmark/benchmark.h>

#include "tests/bench/ray_bench.h"

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  alidade::bench::register_octree_builds();
  alidade::bench::register_octree_rays();
  alidade::bench::register_ray_questions();
#ifdef ALIDADE_WITH_EMBREE
  alidade::bench::register_embree_builds();
  alidade::bench::register_embree_rays();
#endif
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
