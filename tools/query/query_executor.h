// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "octree/copc_tiles.h"
#include "octree/octree.h"
#include "octree/query.h"
#include "octree/query_batch.h"
#include "octree/query_targets.h"
#include "octree/tree_query.h"
#include "tools/query/target_kind.h"

namespace alidade::tools {

/// The number of targets in a batch, so that threads have work, answers fit into memory, and a batch ends
/// soon: between batches progress is reported and the program can be interrupted.
class BatchSize {
 public:
  /// Targets of the next batch.
  std::size_t targets() const { return targets_.next(); }

  /// Answers of one target that are requested at first. A target that has more is repeated alone.
  std::size_t answers_per_target() const { return std::max(k_most_answers / targets(), k_least_limit); }

  /// Learns from a batch.
  void learn(std::size_t targets, std::size_t answers, PieceSize::Clock::duration time) {
    if (targets > 0) targets_.learn(targets, time, k_wanted_answers / (answers / targets + 1));
  }

 private:
  static constexpr std::size_t k_wanted_answers = 1 << 18, k_most_answers = 1 << 20;
  static constexpr std::size_t k_least_limit = 32;

  PieceSize targets_{{.first = 32, .least = 8, .most = 1 << 15, .wanted = std::chrono::milliseconds(200)}};
};

/// Queries one tree with batches of targets by Algorithm 1, in parallel, and counts its steps.
template <class Target, SpatialTree Tree>
class TreeExecutor {
 public:
  using Query = typename QueryFamily<Target>::Query;
  using Answer = typename QueryFamily<Target>::Answer;

  TreeExecutor(Tree tree, Query query) : tree_(std::move(tree)), query_(std::move(query)) {}

  std::size_t k() const { return query_.k; }

  /// The first `most` of the answers that the query requests, for each target: as find() of octree/query.h.
  Answers<Answer> find(std::span<const Target> targets, std::size_t most) {
    const std::size_t k = std::min(query_.k, most);
    return answer_all<Answer>(targets, k_grain, [&](std::size_t i, std::vector<Answer>& answers) {
      const auto target = make_target(targets[i], query_, i);
      Nearest neighbors(target, k);
      statistics_.local() += tree_query(tree_, target, neighbors);
      const std::vector<Answer> found = neighbors.in_order();
      answers.insert(answers.end(), found.begin(), found.end());
    });
  }

  /// How many answers each target has: as count() of octree/query.h; with `any_is_enough` 0 or 1.
  std::vector<std::size_t> count(std::span<const Target> targets, bool any_is_enough) {
    std::vector<std::size_t> counts(targets.size());
    for_each_target(targets, k_grain, [&](std::size_t i) {
      Counter counter(any_is_enough ? 1 : query_.k);
      statistics_.local() += tree_query(tree_, make_target(targets[i], query_, i), counter);
      counts[i] = counter.count();
    });
    return counts;
  }

  /// All work so far.
  QueryStatistics statistics() const {
    QueryStatistics sum;
    for (const QueryStatistics& part : statistics_) sum += part;
    return sum;
  }

 private:
  static constexpr std::size_t k_grain = 4;

  Tree tree_;
  Query query_;
  tbb::enumerable_thread_specific<QueryStatistics> statistics_;
};

/// TreeExecutor over COPC files. If targets meet several remote files, it opens these ahead, many at once,
/// and reads their points, too, if all points that a target meets are needed: one request after another would
/// mostly wait for servers.
template <class Target>
class TilesExecutor {
 public:
  using Query = typename QueryFamily<Target>::Query;

  TilesExecutor(const CopcTiles& tiles, bool reads_ahead, const Query& query)
      : tiles_(tiles), query_(query), executor_(CopcTilesTree(tiles), query), reads_ahead_(reads_ahead) {}

  std::size_t k() const { return executor_.k(); }
  auto find(std::span<const Target> targets, std::size_t most) {
    read_ahead(targets, most);
    return executor_.find(targets, most);
  }
  std::vector<std::size_t> count(std::span<const Target> targets, bool any_is_enough) {
    read_ahead(targets, any_is_enough ? 1 : k_all);
    return executor_.count(targets, any_is_enough);
  }
  QueryStatistics statistics() const { return executor_.statistics(); }

 private:
  static constexpr std::size_t k_most_at_once = 16;
  static constexpr std::size_t k_most_ahead = 1024;     // of a batch
  static constexpr std::size_t k_most_met = 64;         // of a target, if only some of them may matter
  static constexpr std::size_t k_likely_to_matter = 8;  // of these

  /// A file that a target meets.
  struct Meeting {
    std::size_t target;
    std::uint32_t file;
  };

  /// The files that a target meets, at most `most`; those first in which the first answers can be.
  template <class AnyTarget>
  std::vector<std::uint32_t> files_met(const AnyTarget& target, std::size_t most) const {
    std::vector<std::pair<double, std::uint32_t>> met;
    Reach reach;
    const auto is_met = [&](const Bounds& box) {
      if (met.size() == most) return false;
      reach = target.reach(box, DistanceBound::box);
      return !target.too_far(reach) && !target.outside_interval(reach);
    };
    tiles_.for_each_met(is_met, [&](std::uint32_t file) {
      const double least = target.least_measure(reach);
      met.emplace_back(std::isnan(least) ? -std::numeric_limits<double>::infinity() : least, file);
    });
    std::sort(met.begin(), met.end());
    std::vector<std::uint32_t> files;
    for (const auto& [measure, file] : met) files.push_back(file);
    return files;
  }

  void read_ahead(std::span<const Target> targets, std::size_t most) {
    if (!reads_ahead_) return;
    const bool needs_all = query_.k == k_all && most > 1;
    std::vector<Meeting> meetings;
    for (std::size_t i = 0; i < targets.size() && meetings.size() < k_most_ahead; ++i) {
      auto files = files_met(make_target(targets[i], query_, i), needs_all ? k_most_ahead : k_most_met);
      if (!needs_all)
        files.resize(files.size() < k_most_met ? std::min(files.size(), k_likely_to_matter) : 0);
      for (const std::uint32_t file : files) meetings.push_back({i, file});
    }
    if (meetings.size() < 2) return;
    std::atomic<std::size_t> next = 0;
    std::vector<std::jthread> readers;
    for (std::size_t i = 0; i < std::min(k_most_at_once, meetings.size()); ++i) {
      readers.emplace_back([&] {
        for (std::size_t at = next++; at < meetings.size(); at = next++) {
          try {
            const auto tile = tiles_.tile(meetings[at].file);
            Counter all(k_all);
            if (needs_all) tree_query(*tile->tree, make_target(targets[meetings[at].target], query_, 0), all);
          } catch (...) {  // the query itself meets the error again, in the order of the targets
            return;
          }
        }
      });
    }
  }

  const CopcTiles& tiles_;
  Query query_;
  TreeExecutor<Target, CopcTilesTree> executor_;
  bool reads_ahead_;
};

/// Queries one octree: by the functions of octree/query.h, or, if work is to be explained, as TreeExecutor,
/// with equal answers.
template <class Target>
class QueryExecutor {
 public:
  using Query = typename QueryFamily<Target>::Query;
  using Answer = typename QueryFamily<Target>::Answer;

  /// The octree must outlive this object.
  QueryExecutor(const Octree& octree, const Query& query, bool is_explained)
      : octree_(octree),
        query_(query),
        is_explained_(is_explained),
        explaining_(OctreeTree(octree.view(), query.max_level), query) {}

  std::size_t k() const { return query_.k; }

  Answers<Answer> find(std::span<const Target> targets, std::size_t most) {
    if (is_explained_) return explaining_.find(targets, most);
    Query query = query_;
    query.k = std::min(query.k, most);
    if constexpr (std::is_same_v<Target, Ray>) {
      if (query.k == 1) return closest_of(targets, query);
    }
    return alidade::find(octree_, targets, query);
  }

  std::vector<std::size_t> count(std::span<const Target> targets, bool any_is_enough) {
    if (is_explained_) return explaining_.count(targets, any_is_enough);
    Query query = query_;
    if (any_is_enough) query.k = 1;
    std::vector<std::size_t> counts(targets.size());
    if constexpr (std::is_same_v<Target, Ray>) {
      if (any_is_enough) {
        std::vector<std::uint8_t> answers(targets.size());
        occluded(octree_, targets, query, answers);
        std::copy(answers.begin(), answers.end(), counts.begin());
        return counts;
      }
    }
    alidade::count(octree_, targets, query, counts);
    return counts;
  }

  /// All work so far; only if it is explained.
  QueryStatistics statistics() const { return explaining_.statistics(); }

 private:
  Answers<Answer> closest_of(std::span<const Ray> rays, const RayQuery& query) {
    std::vector<std::optional<Hit>> hits(rays.size());
    closest(octree_, rays, query, hits);
    Answers<Hit> answers;
    for (const std::optional<Hit>& hit : hits) {
      if (hit) answers.all.push_back(*hit);
      answers.begin.push_back(answers.all.size());
    }
    return answers;
  }

  const Octree& octree_;
  Query query_;
  bool is_explained_;
  TreeExecutor<Target, OctreeTree> explaining_;
};

}  // namespace alidade::tools
