// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "base/checkpoint.h"
#include "visibility/lines/line_curve.h"
#include "visibility/row_text.h"

namespace alidade::visibility {

/// What is measured of every line beside what blocks it (LineReportOptions::measures). It holds the results,
/// which are numbered like the lines.
class LineMeasure {
 public:
  virtual ~LineMeasure() = default;

  /// Measures a line and writes the result to a part.
  using Measure = std::function<void(const SightEnd& from, const SightEnd& to, PartWriter& writer)>;
  /// Called once, before all others. What is returned is called by one thread at a time, while the occluders
  /// live. Errors: the occluders or the options do not suit the measure.
  virtual Measure begin(const Occluders& occluders, const LineOptions& options, std::size_t lines) = 0;
  /// Reads the result of a line, measured by this run or an earlier one. Errors: those of PartReader.
  virtual void take(std::size_t line, PartReader& reader) = 0;

  /// Adds values of a line to its row; every line has the same ones. `classes`: by point id; empty if the
  /// cloud has none.
  virtual void add_columns(std::size_t line, std::span<const std::uint8_t> classes, Row& row) const = 0;
  /// Adds what only JSON has.
  virtual void add_members(std::size_t, std::span<const std::uint8_t>, Row&) const {}
  /// The end of a sentence on all lines, such as "; 2 have this property"; empty: nothing to say.
  virtual std::string remark() const { return {}; }
};

// Points in the results of measures and reports: their bytes, and their values in rows.

void put_position(const glm::dvec3& position, PartWriter& writer);
glm::dvec3 take_position(PartReader& reader);
/// An id below point_count or, if it blocks, k_mesh_blocker. Errors: any other.
std::uint64_t take_blocker_id(PartReader& reader, std::uint64_t point_count);
void put_point(const std::optional<LinePoint>& point, PartWriter& writer);
/// Errors: an id not below point_count.
std::optional<LinePoint> take_point(PartReader& reader, std::uint64_t point_count);

/// Null for k_mesh_blocker.
Row id_value(std::uint64_t blocker_id);
Row class_value(std::span<const std::uint8_t> classes, std::uint64_t blocker_id);
/// Adds `prefix` + _at, _point and _class; null without a point.
void add_point(Row& row, const std::string& prefix, const std::optional<LinePoint>& point,
               std::span<const std::uint8_t> classes);

}  // namespace alidade::visibility
