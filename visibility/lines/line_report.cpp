// SPDX-License-Identifier: MIT
#include "visibility/lines/line_report.h"

#include <algorithm>
#include <cmath>

#include "base/checkpoint.h"
#include "base/error.h"
#include "base/parallel.h"

namespace alidade::visibility {
namespace {

/// A pair that is measured takes as long as many that are not.
constexpr std::size_t k_pairs_at_once = 4096, k_measured_at_once = 8;

/// Finds what blocks the lines and what comes nearest to them, of pairs [begin, end).
void report_middles(const Occluders& occluders, std::span<const LinePair> pairs, const LineOptions& options,
                    std::span<LineReport> reports) {
  std::vector<LineCurve> curves;
  for (const LinePair& pair : pairs) curves.emplace_back(pair.from, pair.to, options);
  std::vector<CurveLine> lines;
  for (const LineCurve& curve : curves) lines.push_back({&curve});
  const std::vector<std::optional<CurveCrossings>> answers = crossings(occluders, lines);
  in_parallel(pairs.size(), 1, [&](std::size_t i) {
    reports[i].length = curves[i].length();
    if (answers[i]) reports[i].blocker = answers[i]->first;
    reports[i].nearest = nearest_point(occluders, curves[i]);
  });
}

}  // namespace

void put_report(const LineReport& report, PartWriter& writer) {
  writer.put(report.length);
  writer.put(std::uint8_t{report.blocker.has_value()});
  if (report.blocker) {
    writer.put(report.blocker->point_id);
    put_position(report.blocker->position, writer);
    writer.put(report.blocker->distance);
  }
  put_point(report.nearest, writer);
}

LineReport take_report(PartReader& reader, std::uint64_t point_count) {
  LineReport report;
  report.length = reader.take<double>();
  if (reader.take<std::uint8_t>() != 0) {
    Blocker& blocker = report.blocker.emplace();
    blocker.point_id = take_blocker_id(reader, point_count);
    blocker.position = take_position(reader);
    blocker.distance = reader.take<double>();
  }
  report.nearest = take_point(reader, point_count);
  return report;
}

void check_line_report(const LineReportOptions& options, int transparency) {
  const LineOptions& line = options.line;
  check_that(line.end_margin >= 0.0 && std::isfinite(line.end_margin),
             "invalid margin at the ends of lines of sight", "at least 0 metres",
             std::to_string(line.end_margin));
  check_that(line.earth_radius > 0.0, "invalid Earth radius", "a positive number",
             std::to_string(line.earth_radius));
  check_that(!std::isfinite(line.earth_radius) || transparency <= 1, "transparency requires straight lines",
             "transparency 1, or a flat Earth");
}

std::vector<LineReport> report_lines(const Occluders& occluders, std::span<const LinePair> pairs,
                                     const LineReportOptions& options, const Progress& progress,
                                     PartCheckpoint* parts) {
  check_line_report(options, occluders.options().transparency);
  std::vector<LineMeasure::Measure> measures;
  for (const auto& measure : options.measures)
    measures.push_back(measure->begin(occluders, options.line, pairs.size()));
  std::vector<LineReport> reports(pairs.size());
  const std::size_t at_once = measures.empty() ? k_pairs_at_once : k_measured_at_once;
  const auto part_of = [at_once](auto all, std::uint64_t part) {
    const std::size_t first = part * at_once;
    return all.subspan(first, std::min(at_once, all.size() - first));
  };
  std::uint64_t done = 0;
  report(progress, 0, pairs.size());
  run_parts(
      parts, (pairs.size() + at_once - 1) / at_once,
      [&](std::uint64_t part, PartWriter& writer) {
        const std::span<const LinePair> some = part_of(pairs, part);
        const std::span<LineReport> answers = part_of(std::span(reports), part);
        report_middles(occluders, some, options.line, answers);
        for (std::size_t i = 0; i < some.size(); ++i) {
          put_report(answers[i], writer);
          writer.put(static_cast<std::uint8_t>(measures.size()));
          for (const LineMeasure::Measure& measure : measures) measure(some[i].from, some[i].to, writer);
        }
      },
      [&](std::uint64_t part, PartReader& reader) {
        for (LineReport& answer : part_of(std::span(reports), part)) {
          answer = take_report(reader, occluders.octree().size());
          reader.require(reader.take<std::uint8_t>() == measures.size());
          for (const auto& measure : options.measures) measure->take(done, reader);
          ++done;
        }
        report(progress, done, pairs.size());
      });
  return reports;
}

}  // namespace alidade::visibility
