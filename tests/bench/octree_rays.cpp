// SPDX-License-Identifier: MIT
// Our side of the ray benchmarks.
#include <benchmark/benchmark.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/instruction_set.h"
#include "octree/explained_query.h"
#include "tests/bench/bench_site.h"
#include "tests/bench/ray_bench.h"
#include "tests/bench/timing.h"

namespace alidade::bench {
namespace {

/// Both queries under one name each: `one` returns whether a ray hits, `many` fills answers.
struct Closest {
  using Answer = std::optional<Hit>;
  static bool one(const Octree& octree, const Ray& ray, const RayQuery& query) {
    const std::optional<Hit> hit = closest(octree, ray, query);
    if (hit) benchmark::DoNotOptimize(hit->point_id);
    return hit.has_value();
  }
  static void many(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
                   std::span<Answer> answers) {
    closest(octree, rays, query, answers);
  }
  static QueryStatistics explain(const Octree& octree, std::span<const Ray> rays, const RayQuery& query) {
    QueryStatistics work;
    ExplainedQuery<Ray, Octree>::find(octree, rays, query, 1, work);
    return work;
  }
};

struct Occluded {
  using Answer = std::uint8_t;
  static bool one(const Octree& octree, const Ray& ray, const RayQuery& query) {
    return occluded(octree, ray, query);
  }
  static void many(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
                   std::span<Answer> answers) {
    occluded(octree, rays, query, answers);
  }
  static QueryStatistics explain(const Octree& octree, std::span<const Ray> rays, const RayQuery& query) {
    QueryStatistics work;
    std::vector<std::size_t> counts(rays.size());
    ExplainedQuery<Ray, Octree>::count(octree, rays, query, counts, work);
    return work;
  }
};

template <class Answer>
std::size_t count_hits(std::span<const Answer> answers) {
  return static_cast<std::size_t>(
      std::ranges::count_if(answers, [](const Answer& answer) { return bool(answer); }));
}

template <class Question>
void time_single(benchmark::State& state, std::int64_t points, const std::string& set,
                 InstructionSet instruction_set, int threads) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  const Octree octree = site.octree.with_instruction_set(instruction_set);
  const std::vector<Ray>& rays = site.rays(set);
  const RayQuery query = site.query();
  std::size_t hits = 0;
  for (auto _ : state) {
    hits = on_threads(threads, [&] {
      return tbb::parallel_reduce(
          tbb::blocked_range<std::size_t>(0, rays.size(), k_rays_per_task), std::size_t{0},
          [&](const auto& range, std::size_t sum) {
            for (std::size_t i = range.begin(); i != range.end(); ++i)
              sum += Question::one(octree, rays[i], query);
            return sum;
          },
          std::plus<>());
    });
  }
  report_rays(state, rays.size(), hits);
}

template <class Question>
void time_batch(benchmark::State& state, std::int64_t points, const std::string& set,
                InstructionSet instruction_set, int threads) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  const Octree octree = site.octree.with_instruction_set(instruction_set);
  const std::vector<Ray>& rays = site.rays(set);
  std::vector<typename Question::Answer> answers(rays.size());
  for (auto _ : state) on_threads(threads, [&] { Question::many(octree, rays, site.query(), answers); });
  report_rays(state, rays.size(), count_hits<typename Question::Answer>(answers));
}

/// Like a program that has only so many rays at a time.
template <class Question>
void time_blocks(benchmark::State& state, std::int64_t points, const std::string& set, std::size_t block) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  const std::span<const Ray> rays = site.rays(set);
  const RayQuery query = site.query();
  std::vector<typename Question::Answer> answers(block);
  std::size_t hits = 0;
  for (auto _ : state) {
    on_threads(1, [&] {
      for (std::size_t begin = 0; begin < rays.size(); begin += block) {
        const std::size_t size = std::min(block, rays.size() - begin);
        const std::span<typename Question::Answer> room = std::span(answers).first(size);
        Question::many(site.octree, rays.subspan(begin, size), query, room);
        hits += count_hits<typename Question::Answer>(room);
      }
    });
  }
  report_rays(state, rays.size(), hits);
}

/// Counts instructions, and what a ray reads of the tree on its way, by Algorithm 1.
template <class Question>
void count_work(benchmark::State& state, std::int64_t points, const std::string& set, bool batch) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  const std::vector<Ray> rays = counted_rays(site.rays(set), batch);
  RayQuery query = site.query();
  std::vector<typename Question::Answer> answers(rays.size());
  for (auto _ : state) {
    report_instructions(state, rays.size(), [&] {
      if (batch) {
        on_threads(1, [&] { Question::many(site.octree, rays, query, answers); });
      } else {
        for (const Ray& ray : rays) benchmark::DoNotOptimize(Question::one(site.octree, ray, query));
      }
    });
  }
  query.k = 1;
  const QueryStatistics work = Question::explain(site.octree, rays, query);
  const std::uint64_t nodes = work.nodes_visited - work.leaves_visited;
  const auto count = static_cast<double>(rays.size());
  state.counters["nodes"] = static_cast<double>(nodes) / count;
  state.counters["leaves"] = static_cast<double>(work.leaves_visited) / count;
  constexpr std::size_t k_bytes_of_point = 3 * sizeof(std::uint16_t);
  state.counters["bytes"] =
      static_cast<double>(nodes * sizeof(Node) + work.points_tested * k_bytes_of_point) / count;
}

template <class Question>
void register_question(const std::string& question, const std::string& set, std::int64_t points) {
  const std::string count = std::to_string(points);
  for (const int threads : {1, 2}) {
    add_benchmark(threads, {question, set, with_threads("single", threads), count}, time_single<Question>,
                  points, set, InstructionSet::best, threads);
    add_benchmark(threads, {question, set, with_threads("batch", threads), count}, time_batch<Question>,
                  points, set, InstructionSet::best, threads);
  }
  add_benchmark(1, {question, set, "blocks_of_256", count}, time_blocks<Question>, points, set, 256);
  if (points == k_site_sizes[0]) {
    for (const char* mode : {"single", "batch"})
      add_benchmark(1, {"instructions", question, set, mode, count}, count_work<Question>, points, set,
                    mode == std::string("batch"));
  }
  for (const InstructionSet instruction_set : available_instruction_sets()) {
    const std::string_view of_set = name(instruction_set);
    add_benchmark(1, {"instruction_set", of_set, question, set, "single", count}, time_single<Question>,
                  points, set, instruction_set, 1);
    add_benchmark(1, {"instruction_set", of_set, question, set, "batch", count}, time_batch<Question>, points,
                  set, instruction_set, 1);
  }
}

}  // namespace

void register_octree_rays() {
  for (const std::int64_t points : k_site_sizes) {
    for (const char* set : k_closest_sets) register_question<Closest>("closest", set, points);
    for (const char* set : k_occluded_sets) register_question<Occluded>("occluded", set, points);
  }
}

}  // namespace alidade::bench
