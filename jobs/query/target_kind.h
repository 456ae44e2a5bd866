// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// The targets of queries and how they are written: as rows of numbers with named columns, alike in CSV, in
// JSON lines, on the command line and in arrays.

namespace alidade::jobs {

/// The families of targets; all targets of a run are of one family.
enum class TargetFamily { rays, lines, cones, path, planes, boxes, points };
constexpr std::size_t k_target_families = 7;
constexpr std::size_t k_most_target_columns = 10;  ///< of any family

/// The valid numbers of a column, which never include NaN.
enum class ValueRule {
  coordinate,  ///< finite
  limit,       ///< also infinite
  width,       ///< finite, at least 0
  half_angle,  ///< degrees, 0 <= value < 90
  number,      ///< whole, 0 .. 2^53
};

struct TargetColumn {
  std::string_view name;
  ValueRule rule = ValueRule::coordinate;
  bool required = true;
};

/// Three columns in a row that JSON may also give as an array.
struct TargetVector {
  std::string_view name;
  std::size_t first = 0;      ///< of its columns
  bool is_direction = false;  ///< may not have length zero
};

struct TargetKind {
  std::string_view name;                  ///< "ray": also of the option that takes one, and in errors
  std::string_view plural;                ///< "rays"
  std::string_view id_name;               ///< of the column that holds the target's id in answers
  std::string_view dimension;             ///< prefix of LAS dimensions: "Ray" for RayId and RayT
  std::span<const TargetColumn> columns;  ///< in the order of the command line
  std::span<const TargetVector> vectors;
  const char* texts_option;  ///< takes a file
  const char* value_option;  ///< takes one target, or a part of one
  const char* help;

  std::size_t required_count() const;
  /// "ox,oy,oz,dx,dy,dz[,t_min][,t_max]"
  std::string form() const;
  /// "ox, oy, ...": every column by name.
  std::string names() const;
  /// Index in `columns` of the column with that name; columns.size() if no column has it.
  std::size_t column(std::string_view name) const;
};

const TargetKind& target_kind(TargetFamily family);

/// How targets of one family were given: in one of these ways.
struct GivenTargets {
  std::string text{};                 ///< a file of CSV or JSON lines; "-" is standard input
  std::vector<std::string> values{};  ///< the columns of the kind, one row each
  /// A value for every column of the kind, row after row, maybe of no row; NaN where an optional one is not
  /// given.
  std::optional<std::span<const double>> rows{};

  bool empty() const { return text.empty() && values.empty() && !rows; }
  /// Whether they can be read twice: they come neither through standard input nor through a pipe.
  bool can_be_reread() const;
};

/// What the value of a column must be; nullptr if it is that.
const char* expected_value(ValueRule rule, double value);

}  // namespace alidade::jobs
