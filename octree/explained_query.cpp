// SPDX-License-Identifier: MIT
#include "octree/explained_query.h"

#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <thread>
#include <utility>

#include "octree/check_query.h"
#include "octree/copc_tiles.h"
#include "octree/query_batch.h"
#include "octree/query_targets.h"

namespace alidade {
namespace {

constexpr std::size_t k_targets_at_once = 4;

template <class T, class Use>
auto with_tree(const Octree& octree, const T& target, const QueryOf<T>& query, std::size_t i,
               const Use& use) {
  return with_tree_target(octree.view(), target, query, i, use);
}
template <class T, class Use>
auto with_tree(const CopcTiles& tiles, const T& target, const QueryOf<T>& query, std::size_t i,
               const Use& use) {
  return use(CopcTilesTree(tiles), make_target(target, query, i));
}

/// The files that a target meets, at most `most`; those first in which the first answers can be.
template <class Target>
std::vector<std::uint32_t> files_met(const CopcTiles& tiles, const Target& target, std::size_t most) {
  std::vector<std::pair<double, std::uint32_t>> met;
  Reach reach;
  const auto is_met = [&](const Bounds& box) {
    if (met.size() == most) return false;
    reach = target.reach(box, DistanceBound::box);
    return !target.too_far(reach) && !target.outside_interval(reach);
  };
  tiles.for_each_met(is_met, [&](std::uint32_t file) {
    const double least = target.least_measure(reach);
    met.emplace_back(std::isnan(least) ? -std::numeric_limits<double>::infinity() : least, file);
  });
  std::sort(met.begin(), met.end());
  std::vector<std::uint32_t> files;
  for (const auto& [measure, file] : met) files.push_back(file);
  return files;
}

/// A file that a target meets.
struct Meeting {
  std::size_t target;
  std::uint32_t file;
};

/// Of a batch some of the first. `needs_all`: all points that a target meets are needed.
template <class T>
std::vector<Meeting> meetings(const CopcTiles& tiles, std::span<const T> targets, const QueryOf<T>& query,
                              bool needs_all) {
  constexpr std::size_t k_most = 1024;
  constexpr std::size_t k_most_met = 64;         // of a target, if only some of them may matter
  constexpr std::size_t k_likely_to_matter = 8;  // of these
  std::vector<Meeting> all;
  for (std::size_t i = 0; i < targets.size() && all.size() < k_most; ++i) {
    auto files = files_met(tiles, make_target(targets[i], query, i), needs_all ? k_most : k_most_met);
    if (!needs_all) files.resize(files.size() < k_most_met ? std::min(files.size(), k_likely_to_matter) : 0);
    for (const std::uint32_t file : files) all.push_back({i, file});
  }
  return all;
}

template <class T>
void read_ahead(const CopcTiles& tiles, std::span<const T> targets, const QueryOf<T>& query, bool needs_all) {
  constexpr std::size_t k_most_at_once = 16;
  if (!tiles.is_any_remote()) return;
  const std::vector<Meeting> ahead = meetings(tiles, targets, query, needs_all);
  if (ahead.size() < 2) return;
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> readers;
  for (std::size_t i = 0; i < std::min(k_most_at_once, ahead.size()); ++i) {
    readers.emplace_back([&] {
      for (std::size_t at = next++; at < ahead.size(); at = next++) {
        try {
          const auto tile = tiles.tile(ahead[at].file);
          Counter all(k_all);
          if (needs_all) tree_query(*tile->tree, make_target(targets[ahead[at].target], query, 0), all);
        } catch (...) {  // the query itself meets the error again, in the order of the targets
          return;
        }
      }
    });
  }
}
template <class T>
void read_ahead(const Octree&, std::span<const T>, const QueryOf<T>&, bool) {}

using WorkOfThreads = tbb::enumerable_thread_specific<QueryStatistics>;

void add(const WorkOfThreads& parts, QueryStatistics& work) {
  for (const QueryStatistics& part : parts) work += part;
}

}  // namespace

template <TargetGeometry T, class Index>
Answers<AnswerOf<T>> ExplainedQuery<T, Index>::find(const Index& index, std::span<const T> targets,
                                                    const QueryOf<T>& query, std::size_t most,
                                                    QueryStatistics& work) {
  read_ahead(index, targets, query, query.k == k_all && most > 1);
  WorkOfThreads parts;
  const auto find_one = [&](std::size_t i, std::vector<AnswerOf<T>>& answers) {
    with_tree(index, targets[i], query, i, [&](const auto& tree, const auto& target) {
      Nearest neighbors(target, std::min(query.k, most));
      parts.local() += tree_query(tree, target, neighbors);
      const std::vector<AnswerOf<T>> found = neighbors.in_order();
      answers.insert(answers.end(), found.begin(), found.end());
    });
  };
  Answers<AnswerOf<T>> answers = answer_all<AnswerOf<T>>(targets, k_targets_at_once, find_one);
  add(parts, work);
  return answers;
}

template <TargetGeometry T, class Index>
void ExplainedQuery<T, Index>::count(const Index& index, std::span<const T> targets, const QueryOf<T>& query,
                                     std::span<std::size_t> counts, QueryStatistics& work) {
  check_room(targets.size(), counts.size());
  read_ahead(index, targets, query, query.k == k_all);
  WorkOfThreads parts;
  for_each_target(targets, k_targets_at_once, [&](std::size_t i) {
    Counter counter(query.k);
    with_tree(index, targets[i], query, i, [&](const auto& tree, const auto& target) {
      parts.local() += tree_query(tree, target, counter);
    });
    counts[i] = counter.count();
  });
  add(parts, work);
}

template struct ExplainedQuery<Ray, Octree>;
template struct ExplainedQuery<Cone, Octree>;
template struct ExplainedQuery<Path, Octree>;
template struct ExplainedQuery<HalfSpaces, Octree>;
template struct ExplainedQuery<Bounds, Octree>;
template struct ExplainedQuery<glm::dvec3, Octree>;
template struct ExplainedQuery<Ray, CopcTiles>;
template struct ExplainedQuery<Cone, CopcTiles>;
template struct ExplainedQuery<Path, CopcTiles>;
template struct ExplainedQuery<HalfSpaces, CopcTiles>;
template struct ExplainedQuery<Bounds, CopcTiles>;
template struct ExplainedQuery<glm::dvec3, CopcTiles>;

}  // namespace alidade
