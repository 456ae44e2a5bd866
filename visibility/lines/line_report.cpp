// SPDX-License-Identifier: MIT
#include "visibility/lines/line_report.h"

#include <algorithm>
#include <cmath>

#include "base/checkpoint.h"
#include "base/error.h"
#include "base/parallel.h"

namespace alidade::visibility {
namespace {

constexpr std::size_t k_obstruction_bytes = 16;

// The values of a report are written to a part and read from it one after another: pass_...() visits them
// with one of these classes, which writes or reads each.

struct Putting {
  PartWriter& writer;

  template <class Number>
  void number(Number value) {
    writer.put(value);
  }
  void flag(bool value) { writer.put(std::uint8_t{value}); }
  void id(std::uint64_t value) { writer.put(value); }
  void blocker_id(std::uint64_t value) { writer.put(value); }
  void length(const std::vector<Obstruction>& all) { writer.put(std::uint64_t{all.size()}); }
  template <class Part>
  bool has(const std::optional<Part>& part) {
    flag(part.has_value());
    return part.has_value();
  }
};

struct Taking {
  PartReader& reader;
  std::uint64_t point_count;

  template <class Number>
  void number(Number& value) {
    value = reader.take<Number>();
  }
  void flag(bool& value) { value = reader.take<std::uint8_t>() != 0; }
  void id(std::uint64_t& value) {
    number(value);
    reader.require(value < point_count);
  }
  void blocker_id(std::uint64_t& value) {
    number(value);
    reader.require(value < point_count || value == k_mesh_blocker);
  }
  void length(std::vector<Obstruction>& all) { all.resize(reader.take_count(k_obstruction_bytes)); }
  template <class Part>
  bool has(std::optional<Part>& part) {
    if (reader.take<std::uint8_t>() != 0) part.emplace();
    return part.has_value();
  }
};

void pass_position(auto& way, auto& position) {
  for (int axis = 0; axis < 3; ++axis) way.number(position[axis]);
}

void pass_point(auto& way, auto& point) {
  if (!way.has(point)) return;
  way.id(point->point_id);
  pass_position(way, point->position);
  way.number(point->t);
  way.number(point->distance);
}

void pass_fresnel(auto& way, auto& zone) {
  for (auto* const number : {&zone.radius, &zone.obstructed, &zone.worst, &zone.worst_t, &zone.cut_off,
                             &zone.inner, &zone.nearest_share})
    way.number(*number);
  way.flag(zone.is_clear);
  pass_point(way, zone.nearest);
  way.number(zone.points);
  way.length(zone.obstructions);
  for (auto& one : zone.obstructions) {
    way.blocker_id(one.point_id);
    way.number(one.share);
  }
}

void pass_report(auto& way, auto& report) {
  way.number(report.length);
  if (way.has(report.blocker)) {
    way.blocker_id(report.blocker->point_id);
    pass_position(way, report.blocker->position);
    way.number(report.blocker->distance);
  }
  pass_point(way, report.nearest);
  if (way.has(report.fresnel)) pass_fresnel(way, *report.fresnel);
}

/// A pair with a Fresnel zone takes as long as many without.
constexpr std::size_t k_pairs_at_once = 4096, k_links_at_once = 8;

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
  Putting way{writer};
  pass_report(way, report);
}

LineReport take_report(PartReader& reader, std::uint64_t point_count) {
  Taking way{reader, point_count};
  LineReport report;
  pass_report(way, report);
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
  std::optional<Occluders> opaque;
  if (options.wavelength) {
    OccluderOptions solid = occluders.options();
    solid.transparency = 1;
    opaque.emplace(occluders.octree(), solid);
  }
  std::vector<LineReport> reports(pairs.size());
  const std::size_t at_once = opaque ? k_links_at_once : k_pairs_at_once;
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
          if (opaque) {
            answers[i].fresnel =
                fresnel_clearance(*opaque, some[i].from, some[i].to, options.line, *options.wavelength);
          }
          put_report(answers[i], writer);
        }
      },
      [&](std::uint64_t part, PartReader& reader) {
        const std::span<LineReport> answers = part_of(std::span(reports), part);
        for (LineReport& answer : answers) answer = take_report(reader, occluders.octree().size());
        report(progress, done += answers.size(), pairs.size());
      });
  return reports;
}

}  // namespace alidade::visibility
