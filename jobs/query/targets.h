// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/bounds.h"
#include "base/parallel.h"
#include "jobs/query/query.h"
#include "octree/targets.h"

namespace alidade::jobs {

/// Some targets and their ids in answers.
template <class Target>
struct TargetBatch {
  std::vector<Target> targets;
  std::vector<std::uint64_t> ids;
};

class RowReader;

/// Reads the targets of a query, whose geometry is Target, in their order and once. A row is a Ray, Cone,
/// Bounds or glm::dvec3, whose id is its number, from 0. Of HalfSpaces a row is a plane, of Path a vertex:
/// rows with the same `region` or `path` number, which is the id, are one target (all of them if there is no
/// such column). Texts are CSV with a header of column names in any order, or JSON lines: objects with column
/// names as keys, or arrays in the kind's order. Rows are parsed in parallel. Memory: some mebibytes.
template <class Target>
class TargetReader {
 public:
  /// Reads the first rows. `query`, whose interval is that of targets without their own, must outlive the
  /// reader; `stops`: whether to stop waiting for a pipe. Errors: the text cannot be opened, is empty, or its
  /// header is wrong.
  explicit TargetReader(const CheckedQuery& query, const std::function<bool()>& stops = {});
  ~TargetReader();

  /// Reads at most `most` targets; false at the end. Reports the first error with source, line and column:
  /// an invalid row, or values out of range; a line longer than a mebibyte; a region or path number below the
  /// one before; a path whose vertices are all the same. Cancelled.
  bool next(std::size_t most, TargetBatch<Target>& batch);

  /// Share of the text that is before the targets still to come; 0 if its size is not known.
  double share() const;

 private:
  void take_row(std::span<const double> row, TargetBatch<Target>& batch);
  void end_group(TargetBatch<Target>& batch);

  std::unique_ptr<RowReader> rows_;
  const CheckedQuery& query_;
  std::uint64_t next_id_ = 0;  ///< of the next row
  // The group that is being read.
  std::optional<std::uint64_t> group_;
  std::uint64_t group_line_ = 0;
  std::vector<glm::dvec3> vertices_;
  std::vector<Plane> planes_;
};

/// The number of targets in a batch, so that threads have work, answers fit into memory, and a batch ends
/// soon: between batches progress is reported and the job can be stopped.
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

}  // namespace alidade::jobs
