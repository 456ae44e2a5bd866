// SPDX-License-Identifier: MIT
#include "visibility/lines/line_report.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "visibility/lines/line_report_bytes.h"

namespace alidade {
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
  if (!(line.end_margin >= 0.0 && std::isfinite(line.end_margin))) {
    throw Error({.problem = "bad margin at the ends of sight lines",
                 .expected = "0 or more metres",
                 .found = std::to_string(line.end_margin)});
  }
  if (!(line.earth_radius > 0.0)) {
    throw Error({.problem = "bad radius of the Earth",
                 .expected = "a number above 0",
                 .found = std::to_string(line.earth_radius)});
  }
  if (std::isfinite(line.earth_radius) && transparency > 1) {
    throw Error({.problem = "a transparency counts crossings of straight lines",
                 .expected = "a transparency of 1, or no curvature of the Earth"});
  }
}

std::vector<LineReport> report_lines(const Occluders& occluders, std::span<const LinePair> pairs,
                                     const LineReportOptions& options, const Progress& progress,
                                     FinishedParts* parts) {
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

}  // namespace alidade
