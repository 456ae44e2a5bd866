// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/crs.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "jobs/query/target_kind.h"
#include "octree/query.h"

namespace alidade::jobs {

enum class AnswerForm {
  csv,         ///< a header and a line per row; infinite numbers are "inf" and "-inf"
  json_lines,  ///< an object per row; numbers as in csv, null for infinite ones
  las,         ///< found points
};

/// The points of a cloud near rays, paths and positions, and in cones, planes and boxes.
struct QueryRequest : CloudRequest {
  GivenTargets targets[k_target_families];  ///< of one family
  std::optional<double> radius, t_min, t_max, entry_min;
  std::optional<std::size_t> k;
  std::optional<Measure> measure;
  std::optional<int> max_level;
  std::optional<std::bitset<256>> classes;
  bool occluded = false, count = false, explain = false;
  /// Whether a COPC file is loaded whole; else it is read in place, and `memory` bytes of it are kept.
  bool is_loaded = false;
  // Answers go to the output; without one to write_text, if it is set; else they are the result.
  std::optional<AnswerForm> format;
  std::optional<int> precision;                      ///< significant digits of numbers in texts
  std::function<void(std::string_view)> write_text;  ///< takes the next piece of the text
  bool is_text_shown = false;  ///< on the terminal, where a progress of the listener would run into it

  GivenTargets& given(TargetFamily family) { return targets[static_cast<std::size_t>(family)]; }
  const GivenTargets& given(TargetFamily family) const { return targets[static_cast<std::size_t>(family)]; }
  bool has_only_numbers() const { return count || occluded; }
};

/// Declares all fields.
void add_query_fields(const Fields& fields, QueryRequest& request);

struct CheckedQuery : QueryRequest {
  TargetFamily family{};  ///< of the targets
  AnswerForm form{};      ///< of the answers

  const GivenTargets& given_targets() const { return given(family); }
};

using QueryPlan = Plan<CheckedQuery>;

/// Checks all that can be checked before a point is read, and the first targets if they can be read again.
/// Errors: no targets, or of several families; fields that exclude each other or do not apply; an output of
/// an unknown format, or that cannot be replaced or written; those of TargetReader.
QueryPlan plan(const QueryRequest& request);

/// A row of the answer to any query. A family fills what it has.
struct AnswerRow {
  std::uint64_t target_id = 0;
  std::uint64_t rank = 0;  ///< among the target's answers, from 0
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  std::uint64_t segment = 0;
  double t = 0.0, distance = 0.0, entry = 0.0;
  std::uint64_t count = 0;  ///< of queries for a number alone; of `occluded` 0 or 1
};

/// A column of the answer: its name and the member that holds its value.
struct AnswerColumn {
  std::string name;
  std::uint64_t AnswerRow::*whole = nullptr;  ///< one of these two, or else an axis of the position
  double AnswerRow::*real = nullptr;
  int axis = 0;
  std::string dimension{};  ///< name as an extra dimension of LAS; empty: none
  const char* description = "";
};

/// A count of the work of a query.
struct WorkCount {
  std::string name;
  std::uint64_t count = 0;
  std::optional<std::uint64_t> of{};  ///< it is a part of so many
  bool is_per_target = false;         ///< grows with the targets
};

struct QueryResult {
  std::vector<AnswerColumn> columns;
  std::vector<AnswerRow> rows;  ///< in the order of the targets; empty if they were written
  Crs crs;                      ///< of the cloud
  std::vector<WorkCount> work;  ///< targets, steps of Algorithm 1, what was read; filled if explained
};

/// Reads targets, queries the octree batch by batch in parallel, and passes the answers on. Errors: those of
/// cloud, targets and output; Cancelled. Memory beside cloud and octree: about 200 MB at most, whatever the
/// number of targets and answers, unless these are the result; a single target with more than a million
/// answers takes what these take; if work is explained, some dozens of them.
QueryResult run(const QueryPlan& plan, Listener& listener);

}  // namespace alidade::jobs
