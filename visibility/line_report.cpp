// SPDX-License-Identifier: MIT
#include "visibility/line_report.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "octree/error.h"

namespace alidade {
namespace {

constexpr std::size_t k_pairs_at_once = 4096;

void check_options(const Occluders& occluders, const LineReportOptions& options) {
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
  if (std::isfinite(line.earth_radius) && occluders.options().transparency > 1) {
    throw Error({.problem = "a transparency counts crossings of straight lines",
                 .expected = "a transparency of 1, or no curvature of the Earth"});
  }
}

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

std::vector<LinePair> all_pairs(std::span<const std::string> names, std::span<const SightEnd> ends) {
  std::vector<LinePair> pairs;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    for (std::size_t j = i + 1; j < ends.size(); ++j) pairs.push_back({names[i], ends[i], names[j], ends[j]});
  }
  return pairs;
}

std::vector<LineReport> report_lines(const Occluders& occluders, std::span<const LinePair> pairs,
                                     const LineReportOptions& options, const Progress& progress) {
  check_options(occluders, options);
  std::optional<Occluders> opaque;
  if (options.wavelength) {
    OccluderOptions solid = occluders.options();
    solid.transparency = 1;
    opaque.emplace(occluders.octree(), solid);
  }
  std::vector<LineReport> reports(pairs.size());
  const std::size_t at_once = opaque ? 1 : k_pairs_at_once;
  for (std::size_t begin = 0; begin < pairs.size(); begin += at_once) {
    report(progress, begin, pairs.size());
    const std::size_t count = std::min(at_once, pairs.size() - begin);
    report_middles(occluders, pairs.subspan(begin, count), options.line,
                   std::span(reports).subspan(begin, count));
    if (!opaque) continue;
    const LinePair& pair = pairs[begin];
    reports[begin].fresnel =
        fresnel_clearance(*opaque, pair.from, pair.to, options.line, *options.wavelength);
  }
  report(progress, pairs.size(), pairs.size());
  return reports;
}

}  // namespace alidade
