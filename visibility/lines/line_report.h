// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/checkpoint.h"
#include "base/progress.h"
#include "visibility/lines/fresnel.h"
#include "visibility/lines/line_curve.h"

// Who sees whom, pair by pair, and what is in between.
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
  /// The first point or triangle that blocks; its distance is metres along the chord. Empty: they see each other.
  std::optional<Blocker> blocker{};
  /// The point that comes nearest to the line's open part (line_points.h); empty if none lies beside it.
  std::optional<LinePoint> nearest{};
  std::optional<FresnelClearance> fresnel{};  ///< if a wavelength was given
};

struct LineReportOptions {
  LineOptions line{};
  std::optional<double> wavelength{};  ///< metres
};

/// Lets a report fail before the work. Errors: margin negative or not finite; Earth radius not above 0; a
/// transparency above 1 for lines that bend, which are requested in pieces.
void check_line_report(const LineReportOptions& options, int transparency);

/// Reports on every pair, in their order; the same on any number of threads. `progress` is in pairs. Cost:
/// some microseconds per pair, and ten to fifty milliseconds with a wavelength. Errors: ends not finite;
/// those of check_line_report() and of fresnel_clearance(), whose wavelength may come with a transparency.
/// `parts` keeps what is finished unless it is null.
std::vector<LineReport> report_lines(const Occluders& occluders, std::span<const LinePair> pairs,
                                     const LineReportOptions& options, const Progress& progress = {},
                                     PartCheckpoint* parts = nullptr);

/// A report as the bytes of a part (run_parts.h).
void put_report(const LineReport& report, PartWriter& writer);

/// Gives it back. Errors: those of PartReader; points that a cloud of so many does not have.
LineReport take_report(PartReader& reader, std::uint64_t point_count);

}  // namespace alidade::visibility
