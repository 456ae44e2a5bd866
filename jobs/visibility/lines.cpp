// SPDX-License-Identifier: MIT
#include "jobs/visibility/lines.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/huge_memory.h"
#include "geo/earth.h"
#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/row_output.h"
#include "jobs/visibility/run_fingerprint.h"
#include "octree/distance.h"
#include "visibility/lines/line_report.h"
#include "visibility/raster/curved_sight.h"
#include "visibility/raster/ground.h"

namespace alidade::jobs {
namespace {

/// For light, the default of maps.
constexpr double k_light_factor = 1.0 / visibility::k_usual_curvature;

/// Lines by their ends.
struct LineSet {
  std::vector<visibility::Observer> ends;
  std::vector<visibility::Observer> named;  ///< each once
  bool are_pairs = false;  ///< first and second end of each line in turn; otherwise every pair is a line
};

/// The position with the name of an end. Errors: no position has it.
const visibility::Observer& position_called(const std::map<std::string, const visibility::Observer*>& by_name,
                                            const visibility::GivenObserver& end) {
  const auto found = by_name.find(end.name);
  if (found != by_name.end()) return *found->second;
  throw file_error(
      end.source, fmt::format("unknown position '{}'", end.name),
      by_name.empty() ? "named positions (--places), or pairs with coordinates" : "a name of --places");
}

/// The ends of pairs with coordinates, first and second of each in turn.
ObserverRequest ends_with_coordinates(const std::vector<visibility::GivenPair>& pairs) {
  ObserverRequest ends;
  for (const visibility::GivenPair& pair : pairs) {
    // Ends without a name get the number of their pair.
    const std::size_t number = ends.positions.size() / 2 + 1;
    ends.positions.push_back(pair.from);
    if (pair.from.name.empty()) ends.positions.back().name = fmt::format("from {}", number);
    ends.positions.push_back(pair.to);
    if (pair.to.name.empty()) ends.positions.back().name = fmt::format("to {}", number);
  }
  return ends;
}

/// The ends of pairs with names, in turn. `named`: the positions of `file`.
std::vector<visibility::Observer> ends_with_names(const std::filesystem::path& file,
                                                  std::span<const visibility::Observer> named,
                                                  const std::vector<visibility::GivenPair>& pairs) {
  std::map<std::string, const visibility::Observer*> by_name;
  for (const visibility::Observer& one : named) {
    if (!by_name.emplace(one.name, &one).second)
      throw file_error(file, fmt::format("duplicate position '{}'", one.name), "unique names");
  }
  std::vector<visibility::Observer> ends;
  for (const visibility::GivenPair& pair : pairs) {
    ends.push_back(position_called(by_name, pair.from));
    ends.push_back(position_called(by_name, pair.to));
  }
  return ends;
}

/// Calls visit(first end, second end) for every line, in order.
void for_each_pair(const LineSet& lines, const std::function<void(std::size_t, std::size_t)>& visit) {
  const std::size_t count = lines.ends.size();
  if (lines.are_pairs) {
    for (std::size_t i = 0; i + 1 < count; i += 2) visit(i, i + 1);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) visit(i, j);
  }
}

void add_pairs(const Fields& fields, PairRequest& request) {
  const Fields group = fields.group("Lines");
  group.file(
      "--pairs", "FILE",
      "CSV with one pair per row: names of --places in the columns from and to, or coordinates (see below)",
      request.pairs);
  group.file("--places", "FILE",
             "CSV, GeoJSON, GeoPackage or Shapefile with positions, like observers; without --pairs all "
             "pairs are tested",
             request.places);
  group.text("--places-crs", "CRS",
             "reference system of the positions, such as EPSG:4326 (default: that of their file, for CSV the "
             "cloud's)",
             request.places_crs);
  group.number("--end-height", "LENGTH",
               "of ends above their foot (default: 0 for ends with a z, 2 for those on the ground)",
               request.defaults.height, 0.0, 1e6);
}

void add_bending(const Fields& fields, LinesRequest& request) {
  fields.group("Lines").value(
      "--earth-radius-factor", "K|off",
      "bend lines for an Earth of K times its radius, which includes refraction (default: 1.1667 if the unit "
      "of the cloud is known, --transparency is 1 and a line is longer than half a kilometre, else off)",
      [&request](const std::string& text) {
        request.earth_factor.emplace();
        if (text != "off") *request.earth_factor = parse_number(text, 1e-3, 1e3);
      });
}

/// Errors that need no cloud: no lines, --places-crs alone.
void check_pair_request(const PairRequest& request) {
  if (request.pairs.empty() && request.places.empty())
    throw input_error("missing lines of sight", "--pairs FILE or --places FILE");
  if (request.places.empty() && !request.places_crs.empty())
    throw input_error("--places-crs requires --places", "--places FILE");
}

/// Reads positions and pairs, and computes the ends of the lines over the cloud. Surfaces need not be
/// measured. Errors: those of read_pair_table() and load_observers(); names of no position, or of two;
/// coordinates beside --places; a single position.
LineSet load_lines(const PairRequest& request, const VisibilityCloud& cloud, Listener& listener) {
  std::vector<visibility::GivenPair> given;
  if (!request.pairs.empty()) given = visibility::read_pair_table(request.pairs);
  const bool has_coordinates = !given.empty() && given.front().has_positions;
  if (has_coordinates && !request.places.empty())
    throw file_error(request.pairs, "pairs given as coordinates, but --places requires names",
                     "names of positions, or no --places");
  ObserverRequest options;
  if (has_coordinates) options = ends_with_coordinates(given);
  options.file = request.places;
  options.anywhere = true;  // masts and mountains may be far away
  options.reference = request.places_crs;
  options.reference_option = "--places-crs";
  options.defaults = request.defaults;
  LineSet lines;
  lines.are_pairs = !given.empty();
  if (has_coordinates || !request.places.empty()) lines.ends = load_observers(options, cloud, listener);
  lines.named = lines.ends;
  if (lines.are_pairs) {
    if (!has_coordinates) lines.ends = ends_with_names(request.places, lines.named, given);
    return lines;
  }
  if (lines.ends.size() < 2) throw file_error(request.places, "contains a single position", "at least two");
  return lines;
}

/// The measures that fields request.
std::vector<const AddedLineMeasure*> requested_measures(const LinesRequest& request) {
  std::vector<const AddedLineMeasure*> requested;
  for (const auto& added : request.measures)
    if (added->is_requested()) requested.push_back(added.get());
  return requested;
}

/// Errors: more lines than fit into memory, with the largest results that measures can have.
void check_report_memory(const LineSet& lines, std::span<const AddedLineMeasure* const> measures) {
  std::uint64_t bytes_per_line = sizeof(visibility::LinePair) + sizeof(visibility::LineReport);
  for (const AddedLineMeasure* const added : measures) bytes_per_line += added->bytes_per_line();
  const std::uint64_t count = lines.ends.size();
  const std::uint64_t line_count = lines.are_pairs ? count / 2 : count * (count - 1) / 2;
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(line_count, bytes_per_line, &bytes))
    bytes = std::numeric_limits<std::uint64_t>::max();
  check_memory(bytes, "the reports of all lines");
}

/// Errors: a margin at either end that leaves nothing of a line.
void check_margin(const LineSet& lines, double margin) {
  if (margin == 0.0) return;
  for_each_pair(lines, [&](std::size_t from, std::size_t to) {
    const double length = distance(lines.ends[from].position, lines.ends[to].position);
    if (2.0 * margin < length) return;
    throw input_error(fmt::format("--end-margin exceeds the line from '{}' to '{}'", lines.ends[from].name,
                                  lines.ends[to].name),
                      fmt::format("less than half of its length {:.6g}", length),
                      fmt::format("{:.6g}", margin));
  });
}

/// The lines: the pairs of a file, or every end with every other.
std::vector<visibility::LinePair> pairs_of(const LineSet& lines, const visibility::Occluders& occluders) {
  std::vector<visibility::SightEnd> sight_ends;
  for (const visibility::Observer& end : lines.ends)
    sight_ends.push_back(visibility::end_near_surface(occluders, end.position));
  std::vector<visibility::LinePair> pairs;
  for_each_pair(lines, [&](std::size_t from, std::size_t to) {
    pairs.push_back({lines.ends[from].name, sight_ends[from], lines.ends[to].name, sight_ends[to]});
  });
  return pairs;
}

/// Metres of the cloud's unit; empty if it is not known.
std::optional<double> known_unit(const VisibilityCloud& cloud) {
  const Crs& crs = cloud.cloud.cloud.crs;
  return crs.empty() ? std::nullopt : geo::metres_per_unit(crs);
}

/// Metres of the cloud's unit, 1 without a reference system. Errors: a reference system without a linear
/// unit.
double unit_of(const VisibilityCloud& cloud, const std::filesystem::path& file) {
  if (cloud.cloud.cloud.crs.empty()) return 1.0;
  if (const std::optional<double> metres = known_unit(cloud)) return *metres;
  throw file_error(file, "wavelengths and the Earth radius require a known linear unit",
                   "a projected reference system: reproject the cloud");
}

/// Whether light bent by the Earth is off the chord of any line by more than maps allow for.
bool is_bent(const LineSet& lines, double unit) {
  const visibility::SightCurve light(visibility::k_usual_curvature, unit);
  bool is_bent = false;
  for_each_pair(lines, [&](std::size_t from, std::size_t to) {
    const double length = distance(lines.ends[from].position, lines.ends[to].position);
    is_bent = is_bent || light.chord_count(length) > 1;
  });
  return is_bent;
}

/// The factor of the Earth's radius that bends the lines; empty: the Earth is flat.
std::optional<double> earth_factor(const LinesRequest& request, const VisibilityCloud& cloud,
                                   const LineSet& lines, std::span<const AddedLineMeasure* const> measures) {
  if (request.earth_factor) return *request.earth_factor;
  if (!measures.empty()) return measures.front()->earth_factor();
  const std::optional<double> unit = known_unit(cloud);
  const bool is_opaque = request.occluders.options.transparency <= 1;
  return unit && is_opaque && is_bent(lines, *unit) ? std::optional(k_light_factor) : std::nullopt;
}

visibility::LineReportOptions report_options(const LinesRequest& request, const VisibilityCloud& cloud,
                                             const LineSet& lines,
                                             std::span<const AddedLineMeasure* const> measures) {
  visibility::LineReportOptions options;
  options.line.end_margin = request.end_margin;
  const std::optional<double> factor = earth_factor(request, cloud, lines, measures);
  if (measures.empty() && !factor) return options;
  const double unit = unit_of(cloud, request.files.first_name());
  if (factor) options.line.earth_radius = *factor * geo::k_earth_radius / unit;
  for (const AddedLineMeasure* const added : measures) options.measures.push_back(added->measure(unit));
  return options;
}

/// How many of the lines are free, and what measures remark.
std::string result_text(const visibility::LineTable& table) {
  const auto visible =
      std::ranges::count_if(table.reports, [](const visibility::LineReport& line) { return !line.blocker; });
  std::string text = fmt::format("{} of {} lines are free", visible, table.reports.size());
  for (const auto& measure : table.measures) text += measure->remark();
  return text;
}

Fingerprint fingerprint_of(const CheckpointRequest& request, const VisibilityCloud& cloud,
                           std::span<const visibility::LinePair> pairs) {
  Fingerprint fingerprint = run_fingerprint(request, cloud);
  std::vector<double> numbers;
  for (const visibility::LinePair& pair : pairs) {
    for (const glm::dvec3& end : {pair.from.position, pair.to.position})
      numbers.insert(numbers.end(), {end.x, end.y, end.z});
  }
  fingerprint.push_back({"number of lines", std::to_string(pairs.size())});
  add_to_fingerprint("ends of the lines", numbers, fingerprint);
  return fingerprint;
}

/// unscanned_length() of every pair.
std::vector<double> unscanned_lengths(const VisibilityCloud& cloud,
                                      std::span<const visibility::LinePair> pairs, Listener& listener) {
  SilentListener quiet(listener);
  const visibility::Ground ground = find_ground(cloud, {}, quiet);
  std::vector<double> lengths;
  for (const visibility::LinePair& pair : pairs)
    lengths.push_back(
        visibility::unscanned_length(ground, glm::dvec2(pair.from.position), glm::dvec2(pair.to.position)));
  return lengths;
}

}  // namespace

void add_lines_fields(const Fields& fields, LinesRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_pairs(fields, request.pairs);
  fields.group("Lines").number("--end-margin", "LENGTH",
                               "excluded length at either end, for scanned masts and tripods (default: 0)",
                               request.end_margin, 0.0, 1e9);
  add_bending(fields, request);
  for (const auto& added : request.measures) added->add_fields(fields);
  add_occluder_fields(fields, request.occluders);
  fields.required().file("-o,--output", "FILE", "output file: .csv, .json or .geojson", request.output);
  fields.flag("--overwrite", "replace an existing file", request.overwrite);
  add_checkpoint_fields(fields.group("Long runs"), request.checkpoint);
  add_scratch_memory(fields, request.memory);
  add_partial(fields, request.partial);
}

LinesPlan plan(const LinesRequest& request) {
  if (!request.output.empty()) load_row_writer(request.output);
  check_pair_request(request.pairs);
  PlannedWork work = request.work({request.pairs.pairs, request.pairs.places});
  check_outputs(work, request.overwrite);
  check_checkpoint(request.checkpoint, request.overwrite, work);
  return LinesPlan(request, std::move(work));
}

LinesResult run(const LinesPlan& plan, Listener& listener) {
  const LinesRequest& request = plan.request();
  auto cloud = load_cloud_alone(request, {}, AcceptedInput::points_or_raster, listener);
  const LineSet lines = load_lines(request.pairs, *cloud, listener);
  const std::vector<const AddedLineMeasure*> measures = requested_measures(request);
  check_report_memory(lines, measures);
  const visibility::LineReportOptions options = report_options(request, *cloud, lines, measures);
  visibility::check_line_report(options, request.occluders.options.transparency);
  check_margin(lines, request.end_margin);
  measure_occluders(*cloud, request.occluders, listener);
  say_observer_remarks(lines.named, *cloud, listener);
  visibility::LineTable table;
  table.pairs = pairs_of(lines, *cloud->occluders);
  table.classifications = cloud->columns.classifications;
  table.measures = options.measures;
  LongRun long_run(
      request.checkpoint, [&] { return fingerprint_of(request.checkpoint, *cloud, table.pairs); }, listener);
  table.reports =
      long_run.work("testing lines of sight", "lines", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::report_lines(*cloud->occluders, table.pairs, options, progress, parts);
      });
  table.unscanned = unscanned_lengths(*cloud, table.pairs, listener);
  write_rows(
      request, cloud->cloud.cloud, [&](const auto&... to) { return visibility::write_lines(table, to...); },
      listener);
  long_run.finish();
  if (listener.is_listening()) listener.note(result_text(table));
  cloud->occluders.reset();  // they would need the listener
  return {std::move(cloud), std::move(table)};
}

}  // namespace alidade::jobs
