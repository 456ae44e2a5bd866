// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/output_file.h"
#include "cloud/las/write_las.h"
#include "octree/index_file/index_file.h"
#include "octree/query.h"
#include "tools/console.h"
#include "tools/query/query_executor.h"
#include "tools/query/target_kind.h"

namespace alidade::tools {

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

/// A column of the answer as text: its name and the member that holds its value.
struct AnswerColumn {
  std::string name;
  std::uint64_t AnswerRow::*whole = nullptr;  ///< one of these two, or else an axis of the position
  double AnswerRow::*real = nullptr;
  int axis = 0;
};

/// How numbers that are not whole are written.
struct NumberForm {
  std::array<std::optional<int>, 3> decimals{};  ///< of coordinates; empty: as other numbers
  std::optional<int> digits{};                   ///< of others; empty: as many as give the same number again
};

/// Rows of answers that are made when they are written, from several threads at once.
struct AnswerRows {
  std::size_t size = 0;
  /// Fills `rows` with the rows [first, first + rows.size()).
  std::function<void(std::size_t first, std::span<AnswerRow> rows)> fill;
};

/// Where answers go, in their order.
class AnswerOutput {
 public:
  virtual ~AnswerOutput() = default;
  /// Errors: no space, and other failures to write.
  virtual void write(const AnswerRows& rows) = 0;
  /// Ends the output; files appear under their name only here.
  virtual void finish() = 0;
};

enum class AnswerForm {
  csv,         ///< a header and a line per row; infinite numbers are "inf" and "-inf"
  json_lines,  ///< an object per row; numbers as in csv, null for infinite ones
  las,         ///< found points
};

/// Answers as text of the form; to stdout without a file. Formats rows in parallel. Errors: OutputFile's.
std::unique_ptr<AnswerOutput> answers_as_text(std::vector<AnswerColumn> columns, AnswerForm form,
                                              const NumberForm& numbers, std::unique_ptr<OutputFile> file);

/// An extra dimension of found points: its name and the value of a row.
struct AnswerDimension {
  std::string name, description;
  std::uint64_t AnswerRow::*whole = nullptr;  ///< written as uint64; or else
  double AnswerRow::*real = nullptr;          ///< written as float64
};

/// Found points as LAS 1.4: a point for every row, with the integers, all attributes, coordinate reference
/// system and records of the cloud, and with the results of the query as extra dimensions. A dimension of the
/// cloud with one of their names is left out, with a warning. Attributes are fetched in parallel. `cloud`
/// must outlive the output. Errors: LasWriter's.
std::unique_ptr<AnswerOutput> answers_as_las(const std::filesystem::path& file, bool overwrite,
                                             const IndexedCloud& cloud,
                                             std::vector<AnswerDimension> dimensions, Verbosity verbosity);

// The columns and dimensions of the answers of each family.

/// Columns of found points as text.
template <class Target>
std::vector<AnswerColumn> answer_columns() {
  using Answer = typename QueryFamily<Target>::Answer;
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

/// Columns of queries for a number alone, which is called `name`.
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
  if constexpr (!std::is_same_v<typename QueryFamily<Target>::Answer, PointHit>) {
    dimensions.push_back({.name = std::string(kind.dimension) + "T",
                          .description = "position along the target",
                          .real = &AnswerRow::t});
  }
  dimensions.push_back({.name = std::string(kind.dimension) + "Id",
                        .description = "index of the target",
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

/// The answers of the targets [begin, end) as rows. `ids`: of all targets. Both arguments must outlive the
/// rows.
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

}  // namespace alidade::tools
