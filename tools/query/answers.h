// SPDX-License-Identifier: MIT
#pragma once

#include <type_traits>
#include <vector>

#include "tools/query/answer_las.h"
#include "tools/query/answer_row.h"
#include "tools/query/ask.h"
#include "tools/query/target_kind.h"

// What the answers of each family look like.

namespace alidade {

/// Columns of found points as text.
template <class Target>
std::vector<AnswerColumn> answer_columns() {
  using Answer = typename Family<Target>::Answer;
  std::vector<AnswerColumn> columns = {
      {.name = std::string(target_kind<Target>().id_name), .whole = &AnswerRow::target_id},
      {.name = "rank", .whole = &AnswerRow::rank},
      {.name = "point_id", .whole = &AnswerRow::point_id},
      {.name = "x", .axis = 0},
      {.name = "y", .axis = 1},
      {.name = "z", .axis = 2}};
  if constexpr (std::is_same_v<Answer, PathHit>)
    columns.push_back({.name = "segment", .whole = &AnswerRow::segment});
  if constexpr (!std::is_same_v<Answer, PointHit>) columns.push_back({.name = "t", .real = &AnswerRow::t});
  if constexpr (!std::is_same_v<Target, Bounds>)
    columns.push_back({.name = "distance", .real = &AnswerRow::distance});
  if constexpr (std::is_same_v<Answer, Hit>) columns.push_back({.name = "entry", .real = &AnswerRow::entry});
  return columns;
}

/// Columns where only a number was asked for; `name` is that number's.
template <class Target>
std::vector<AnswerColumn> number_columns(std::string name) {
  return {{.name = std::string(target_kind<Target>().id_name), .whole = &AnswerRow::target_id},
          {.name = std::move(name), .whole = &AnswerRow::count}};
}

/// Extra dimensions of found points in LAS.
template <class Target>
std::vector<AnswerDimension> answer_dimensions() {
  const TargetKind& kind = target_kind<Target>();
  std::vector<AnswerDimension> dimensions;
  if constexpr (!std::is_same_v<Target, Bounds>) {
    dimensions.push_back(
        {.name = "Distance", .description = "distance to the target", .real = &AnswerRow::distance});
  }
  if constexpr (!std::is_same_v<typename Family<Target>::Answer, PointHit>) {
    dimensions.push_back({.name = std::string(kind.dimension) + "T",
                          .description = "place on the target",
                          .real = &AnswerRow::t});
  }
  dimensions.push_back({.name = std::string(kind.dimension) + "Id",
                        .description = "number of the target",
                        .whole = &AnswerRow::target_id});
  return dimensions;
}

/// A hit as a row; target_id and rank are left to the caller.
template <class Answer>
AnswerRow answer_row(const Answer& hit) {
  AnswerRow row{.point_id = hit.point_id, .position = hit.position, .distance = hit.distance};
  if constexpr (requires { hit.t; }) row.t = hit.t;
  if constexpr (requires { hit.entry; }) row.entry = hit.entry;
  if constexpr (requires { hit.segment; }) row.segment = hit.segment;
  return row;
}

/// The answers of the targets [begin, end) as rows; ids: of all targets. What they are made of must outlive
/// them.
template <class Answer>
AnswerRows answer_rows(const Answers<Answer>& answers, std::size_t begin, std::size_t end,
                       std::span<const std::uint64_t> ids) {
  const std::size_t before = answers.begin[begin];
  return {answers.begin[end] - before, [&answers, ids, before](std::size_t first, std::span<AnswerRow> rows) {
            const auto& starts = answers.begin;
            const auto next = std::ranges::upper_bound(starts, before + first);
            auto target = static_cast<std::size_t>(next - starts.begin()) - 1;
            for (std::size_t i = before + first; AnswerRow & row : rows) {
              while (starts[target + 1] <= i) ++target;
              row = answer_row(answers.all[i]);
              row.target_id = ids[target];
              row.rank = i - starts[target];
              ++i;
            }
          }};
}

inline AnswerRows number_rows(std::span<const std::size_t> counts, std::span<const std::uint64_t> ids) {
  return {counts.size(), [counts, ids](std::size_t first, std::span<AnswerRow> rows) {
            for (std::size_t i = 0; i < rows.size(); ++i)
              rows[i] = {.target_id = ids[first + i], .count = counts[first + i]};
          }};
}

}  // namespace alidade
