// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "octree/query.h"

namespace alidade::tools {

/// The families of targets; all targets of a run are of one family.
enum class TargetFamily { rays, lines, cones, path, planes, boxes, points };
constexpr std::size_t k_target_families = 7;

// The targets of `alidade query` and how they are written: as rows of numbers with named columns, alike in
// CSV, in JSON lines and on the command line.

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

constexpr std::size_t k_most_target_columns = 10;  ///< of any kind

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
  /// Position in `columns`; their number if there is none of that name.
  std::size_t column(std::string_view name) const;
};

const TargetKind& target_kind(TargetFamily family);

/// The kind of Ray (lines are such, too), Cone, Path, HalfSpaces, Bounds, glm::dvec3.
template <TargetGeometry Target>
const TargetKind& target_kind() {
  using enum TargetFamily;
  return target_kind(std::same_as<Target, Ray>          ? rays
                     : std::same_as<Target, Cone>       ? cones
                     : std::same_as<Target, Path>       ? path
                     : std::same_as<Target, HalfSpaces> ? planes
                     : std::same_as<Target, Bounds>     ? boxes
                                                        : points);
}

/// A line of a text, with its location for errors.
struct TextLine {
  std::string_view source;  ///< name of the text in messages: a file, or an option of the command line
  bool is_command_line = false;
  std::string_view text;
  std::uint64_t number = 1;

  /// Throws an Error about the text at byte `offset`. It names source, line and column (in characters, from
  /// 1); for an option its whole value instead.
  [[noreturn]] void fail(std::size_t offset, std::string problem, std::string expected = {},
                         std::string found = {}) const;
};

/// Errors: the value breaks the rule of its column. `found`: the value as written, at byte `offset`.
void check_value(const TextLine& line, std::size_t offset, const TargetColumn& column, double value,
                 std::string_view found);

/// Errors, once all values are valid: a required one was not given (NaN), a direction has length zero.
/// `offsets`: the offset in the line of each column's value.
void check_row(const TextLine& line, const TargetKind& kind, std::span<const double> row,
               std::span<const std::size_t> offsets);

}  // namespace alidade::tools
