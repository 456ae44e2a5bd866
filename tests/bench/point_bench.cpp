// SPDX-License-Identifier: MIT
// Questions to points, beside the indexes of other libraries where they are installed.
//   point_bench --benchmark_filter=/100000/ --benchmark_repetitions=5
#include <benchmark/benchmark.h>

#include "tests/bench/point_questions.h"

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  alidade::bench::register_octree_points();
#ifdef ALIDADE_WITH_NANOFLANN
  alidade::bench::register_nanoflann_points();
#endif
#ifdef ALIDADE_WITH_BOOST
  alidade::bench::register_boost_points();
#endif
#ifdef ALIDADE_WITH_PCL
  alidade::bench::register_pcl_points();
#endif
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
