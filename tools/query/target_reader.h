// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "octree/query.h"
#include "tools/query/row_reader.h"

namespace alidade::tools {

/// Some targets and their ids in answers.
template <class Target>
struct TargetBatch {
  std::vector<Target> targets;
  std::vector<std::uint64_t> ids;
};

/// The interval on t of targets without their own; empty: the target's usual one.
struct DefaultInterval {
  std::optional<double> t_min, t_max;
};

/// Reads targets from rows. A row is a Ray, Cone, Bounds or glm::dvec3, whose id is its number in the order
/// of the text, from 0. Of HalfSpaces a row is a plane, of Path a vertex: rows with the same `region` or
/// `path` number, which is the id, are one target (all of them if there is no such column).
template <class Target>
class TargetReader {
 public:
  TargetReader(LineSource source, const DefaultInterval& interval)
      : rows_(std::move(source), target_kind<Target>()), interval_(interval) {}

  /// The next targets, at most so many; false if there are none left. Errors: RowReader's; a region or path
  /// number below the one before; a path whose vertices are all the same.
  bool next(std::size_t most, TargetBatch<Target>& batch);

  /// Share of the text that is before the targets still to come; 0 if its size is not known.
  double share() const;

 private:
  void take_row(std::size_t i, TargetBatch<Target>& batch);
  void end_group(TargetBatch<Target>& batch);
  /// Returns what make() returns; adds the line to its errors.
  template <class Make>
  auto at_line(std::uint64_t line, const Make& make) const;

  RowReader rows_;
  DefaultInterval interval_;
  TargetRows block_;
  std::size_t used_ = 0;       ///< rows of the block
  std::uint64_t next_id_ = 0;  ///< of the next row
  // The group that is being read.
  std::optional<std::uint64_t> group_;
  std::uint64_t group_line_ = 0;
  std::vector<glm::dvec3> vertices_;
  std::vector<Plane> planes_;
};

}  // namespace alidade::tools
