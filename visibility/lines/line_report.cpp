// SPDX-License-Identifier: MIT
#include "visibility/lines/line_report.h"

#include <tbb/parallel_for.h>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace alidade::visibility {
namespace {

constexpr std::size_t k_obstruction_bytes = 16;

void put_position(const glm::dvec3& position, PartWriter& writer) {
  for (int axis = 0; axis < 3; ++axis) writer.put(position[axis]);
}

void put_point(const std::optional<LinePoint>& point, PartWriter& writer) {
  writer.put(std::uint8_t{point.has_value()});
  if (!point) return;
  writer.put(point->point_id);
  put_position(point->position, writer);
  writer.put(point->t);
  writer.put(point->distance);
}

void put_fresnel(const FresnelClearance& zone, PartWriter& writer) {
  for (const double number :
       {zone.radius, zone.obstructed, zone.worst, zone.worst_t, zone.cut_off, zone.inner, zone.nearest_share})
    writer.put(number);
  writer.put(std::uint8_t{zone.is_clear});
  put_point(zone.nearest, writer);
  writer.put(zone.points);
  writer.put(std::uint64_t{zone.obstructions.size()});
  for (const Obstruction& one : zone.obstructions) {
    writer.put(one.point_id);
    writer.put(one.share);
  }
}

class ReportReader {
 public:
  ReportReader(PartReader& reader, std::uint64_t point_count) : reader_(reader), point_count_(point_count) {}

  bool take_flag() { return reader_.take<std::uint8_t>() != 0; }
  double take_number() { return reader_.take<double>(); }
  std::uint64_t take_id() {
    const auto id = reader_.take<std::uint64_t>();
    reader_.require(id < point_count_);
    return id;
  }
  glm::dvec3 take_position() {
    glm::dvec3 position{0.0};
    for (int axis = 0; axis < 3; ++axis) position[axis] = take_number();
    return position;
  }
  std::optional<LinePoint> take_point() {
    if (!take_flag()) return std::nullopt;
    LinePoint point;
    point.point_id = take_id();
    point.position = take_position();
    point.t = take_number();
    point.distance = take_number();
    return point;
  }
  FresnelClearance take_fresnel() {
    FresnelClearance zone;
    for (double* const number : {&zone.radius, &zone.obstructed, &zone.worst, &zone.worst_t, &zone.cut_off,
                                 &zone.inner, &zone.nearest_share})
      *number = take_number();
    zone.is_clear = take_flag();
    zone.nearest = take_point();
    zone.points = reader_.take<std::uint64_t>();
    zone.obstructions.resize(reader_.take_count(k_obstruction_bytes));
    for (Obstruction& one : zone.obstructions) {
      one.point_id = take_id();
      one.share = take_number();
    }
    return zone;
  }

 private:
  PartReader& reader_;
  std::uint64_t point_count_;
};

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
  writer.put(std::uint8_t{report.fresnel.has_value()});
  if (report.fresnel) put_fresnel(*report.fresnel, writer);
}

LineReport take_report(PartReader& reader, std::uint64_t point_count) {
  ReportReader from(reader, point_count);
  LineReport report;
  report.length = from.take_number();
  if (from.take_flag()) {
    Blocker& blocker = report.blocker.emplace();
    blocker.point_id = from.take_id();
    blocker.position = from.take_position();
    blocker.distance = from.take_number();
  }
  report.nearest = from.take_point();
  if (from.take_flag()) report.fresnel = from.take_fresnel();
  return report;
}

namespace {

/// With a Fresnel zone each takes as long as many without.
constexpr std::size_t k_pairs_at_once = 4096, k_links_at_once = 8;

/// What blocks the lines and what comes nearest to them, of pairs [begin, end).
void report_middles(const Occluders& occluders, std::span<const LinePair> pairs, const LineOptions& options,
                    std::span<LineReport> reports) {
  std::vector<LineCurve> curves;
  for (const LinePair& pair : pairs) curves.emplace_back(pair.from, pair.to, options);
  std::vector<CurveLine> lines;
  for (const LineCurve& curve : curves) lines.push_back({&curve});
  const std::vector<std::optional<CurveCrossings>> answers = crossings(occluders, lines);
  tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t i) {
    reports[i].length = curves[i].length();
    if (answers[i]) reports[i].blocker = answers[i]->first;
    reports[i].nearest = nearest_point(occluders, curves[i]);
  });
}

}  // namespace

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
