// SPDX-License-Identifier: MIT
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/ray.h"
#include "tests/bench/instructions.h"

// What octree_bench measures. Each function registers benchmarks; names are words joined by '/', the number
// of points last.

namespace alidade::bench {

/// The rays of a set whose instructions are counted: neighbours for a batch, otherwise some of everywhere.
inline std::vector<Ray> counted_rays(std::span<const Ray> all, bool batch) {
  const std::size_t count = std::min<std::size_t>(all.size(), batch ? 1024 : 256);
  if (batch) all = all.subspan((all.size() - count) / 2, count);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) rays.push_back(all[i * all.size() / count]);
  return rays;
}

/// Counts those of `work`, which traces so many rays.
template <class Work>
void report_instructions(benchmark::State& state, std::size_t rays, const Work& work) {
  state.counters["instructions"] = static_cast<double>(count_instructions(work)) / static_cast<double>(rays);
}

/// Rays on the campus, SET as in bench_site.h, MODE single, batch (the whole set in one call), both also with
/// _2_threads, and blocks_of_256:
/// - closest/SET/MODE/POINTS and occluded/SET/MODE/POINTS
/// - instructions/closest/SET/MODE/POINTS, instructions/occluded/...: MODE single and batch, counted
/// - instruction_set/NAME/closest/SET/MODE/POINTS: single and batch with every instruction set
void register_octree_rays();

/// MODE single, packet8, packet16, stream, all also with _2_threads:
/// - embree/closest/SET/MODE/POINTS and embree/occluded/SET/MODE/POINTS
/// - embree/instructions/closest/SET/MODE/POINTS, embree/instructions/occluded/...: counted
void register_embree_rays();

/// Bytes per point of the octree, and at the peak of its build beside the cloud; all also with _2_threads:
/// - build/octree/POINTS
/// - build/wide/POINTS: more than 2^21 lattice steps on an axis
/// - build/without_ids/POINTS: in stored order
/// - build/surfaces/POINTS: the surface of every point, in seconds per point
void register_octree_builds();

/// - build/embree_2_threads/POINTS, with the points in the octree's order
void register_embree_builds();

/// The other questions to rays, one thread, each query by itself:
/// - uniform/nearest/K/POINTS, uniform/radius/R/POINTS, uniform/closest_K/R/POINTS: Figure 5 of the paper
/// - site/nearest/K/POINTS, site/closest_by_t/POINTS: 3000 primary rays of the campus
/// - identical/closest/POINTS, identical/occluded/POINTS: all points at one position
void register_ray_questions();

}  // namespace alidade::bench
