// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/checkpoint.h"
#include "base/progress.h"
#include "visibility/lines/line_curve.h"
#include "visibility/lines/line_measure.h"

// Whether the ends of pairs see each other, and what is between them.
//
//   const std::vector<LinePair> pairs = {{"mast", {mast}, "roof", end_near_surface(occluders, roof)}};
//   for (const LineReport& line : report_lines(occluders, pairs, {})) use(line.blocker);

namespace alidade::visibility {

struct LinePair {
  std::string from_name{};
  SightEnd from{};
  std::string to_name{};
  SightEnd to{};
};

struct LineReport {
  double length = 0.0;  ///< of the chord, metres
  /// The first point or triangle that blocks; its distance is metres along the chord.
  /// Empty: they see each other.
  std::optional<Blocker> blocker{};
  /// The point nearest to the line (nearest_point()); empty if none lies beside it.
  std::optional<LinePoint> nearest{};
};

/// What is measured of lines beside that.
using LineMeasures = std::vector<std::shared_ptr<LineMeasure>>;

struct LineReportOptions {
  LineOptions line{};
  LineMeasures measures{};
};

/// Checks the options of a report beforehand. Errors: margin negative or not finite; Earth radius not above
/// 0; a transparency above 1 for lines that bend, since they are queried in pieces.
void check_line_report(const LineReportOptions& options, int transparency);

/// Reports on every pair, in their order; the same on any number of threads. `progress` is in pairs. Cost:
/// some microseconds per pair, and that of the measures, which hold their results afterwards. Errors: ends not
/// finite; those of check_line_report() and of the measures. Finished pairs are kept in `parts` unless it is
/// null.
std::vector<LineReport> report_lines(const Occluders& occluders, std::span<const LinePair> pairs,
                                     const LineReportOptions& options, const Progress& progress = {},
                                     PartCheckpoint* parts = nullptr);

/// Writes a report to a part (base/checkpoint.h).
void put_report(const LineReport& report, PartWriter& writer);

/// Reads a report from a part. Errors: those of PartReader; point ids not below point_count.
LineReport take_report(PartReader& reader, std::uint64_t point_count);

}  // namespace alidade::visibility
