// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/crs.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "jobs/query/answers.h"
#include "jobs/query/targets.h"
#include "octree/query.h"

namespace alidade::jobs {

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
};

/// Declares all fields.
void add_query_fields(const Fields& fields, QueryRequest& request);

/// A checked request, its family of targets and the form of its answers.
class QueryPlan : public Plan<QueryRequest> {
 public:
  TargetFamily family() const { return family_; }
  AnswerForm form() const { return form_; }

 private:
  friend QueryPlan plan(const QueryRequest& request);
  QueryPlan(QueryRequest request, PlannedWork work, TargetFamily family, AnswerForm form)
      : Plan(std::move(request), std::move(work)), family_(family), form_(form) {}

  TargetFamily family_;
  AnswerForm form_;
};

/// Checks all that can be checked before a point is read, and the first targets if they can be read again.
/// Errors: no targets, or of several families; fields that exclude each other or do not apply; an output of
/// an unknown format, or that cannot be replaced or written; those of TargetReader.
QueryPlan plan(const QueryRequest& request);

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
