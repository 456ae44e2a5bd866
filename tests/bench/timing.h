// SPDX-License-Identifier: MIT
#pragma once

#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

namespace alidade::bench {

/// Point counts of the sites; a filter picks some, and nothing of the others is made.
constexpr std::int64_t k_site_sizes[] = {1'000'000, 10'000'000, 50'000'000, 100'000'000};

/// Where a benchmark spreads rays over threads itself.
constexpr std::size_t k_rays_per_task = 4096;

/// Registers a benchmark under its words joined by '/'. Each repetition is one pass over all its queries, so
/// that repetitions of all benchmarks can be interleaved. One thread is timed by its processor time, which
/// other programs disturb least; more by the clock.
template <class Function, class... Arguments>
void add_benchmark(int threads, std::initializer_list<std::string_view> words, const Function& function,
                   const Arguments&... arguments) {
  std::string path;
  for (const std::string_view word : words) path.append(path.empty() ? "" : "/").append(word);
  benchmark::internal::Benchmark* registered =
      benchmark::RegisterBenchmark(path.c_str(), function, arguments...);
  registered->Iterations(1)->Unit(benchmark::kMillisecond);
  if (threads > 1) registered->UseRealTime();
}

/// A mode's name with its number of threads, if more than one.
inline std::string with_threads(std::string mode, int threads) {
  return threads == 1 ? mode : mode.append("_2_threads");
}

/// Runs `work` on so many threads, the calling one among them.
template <class Work>
auto on_threads(int threads, const Work& work) {
  tbb::task_arena arena(threads);
  return arena.execute(work);
}

/// Adds the figures of one pass.
inline void report_rays(benchmark::State& state, std::size_t rays, std::size_t hits) {
  state.counters["rays"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(rays), benchmark::Counter::kIsRate);
  state.counters["hit_share"] = static_cast<double>(hits) / static_cast<double>(rays);
}

/// Adds the figures of one pass of queries whose answers are lists.
inline void report_queries(benchmark::State& state, std::size_t queries, std::size_t found) {
  const auto passes = static_cast<double>(state.iterations()), count = static_cast<double>(queries);
  state.counters["queries"] = benchmark::Counter(passes * count, benchmark::Counter::kIsRate);
  state.counters["found"] = static_cast<double>(found) / (passes * count);
}

}  // namespace alidade::bench
