// SPDX-License-Identifier: MIT
#include "tools/visibility/line_pairs.h"

#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>

#include "base/error.h"
#include "base/huge_memory.h"
#include "geo/raster.h"
#include "octree/distance.h"
#include "tools/options.h"
#include "tools/visibility/observer_options.h"
#include "visibility/lines/line_files.h"

namespace alidade::tools {
namespace {

const visibility::Observer& place_called(const std::map<std::string, const visibility::Observer*>& places,
                                         const visibility::GivenObserver& end) {
  const auto found = places.find(end.name);
  if (found != places.end()) return *found->second;
  throw Error({.file = end.source,
               .problem = fmt::format("no place is called '{}'", end.name),
               .expected = places.empty() ? "places with names (--places), or pairs with coordinates"
                                          : "a name of --places"});
}

/// The ends of pairs with coordinates, first and second of each after each other.
ObserverOptions ends_with_places(const std::vector<visibility::GivenPair>& pairs) {
  ObserverOptions ends;
  for (const visibility::GivenPair& pair : pairs) {
    // Who has no name is called by the pair's number.
    const std::size_t number = ends.places.size() / 2 + 1;
    ends.places.push_back(pair.from);
    if (pair.from.name.empty()) ends.places.back().name = fmt::format("from {}", number);
    ends.places.push_back(pair.to);
    if (pair.to.name.empty()) ends.places.back().name = fmt::format("to {}", number);
  }
  return ends;
}

/// Those of pairs with names.
std::vector<visibility::Observer> ends_with_names(std::span<const visibility::Observer> places,
                                                  const std::vector<visibility::GivenPair>& pairs) {
  std::map<std::string, const visibility::Observer*> by_name;
  for (const visibility::Observer& place : places) {
    if (!by_name.emplace(place.name, &place).second)
      throw Error({.problem = fmt::format("two places are called '{}'", place.name)});
  }
  std::vector<visibility::Observer> ends;
  for (const visibility::GivenPair& pair : pairs) {
    ends.push_back(place_called(by_name, pair.from));
    ends.push_back(place_called(by_name, pair.to));
  }
  return ends;
}

/// Calls visit(first end, second end) for every line, in order.
void for_each_pair(const LineEnds& ends, const std::function<void(std::size_t, std::size_t)>& visit) {
  const std::size_t count = ends.places.size();
  if (ends.are_pairs) {
    for (std::size_t i = 0; i + 1 < count; i += 2) visit(i, i + 1);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) visit(i, j);
  }
}

}  // namespace

void add_pair_options(const Options& command, PairRequest& request) {
  const Options group = command.group("Lines");
  group.file("--pairs", "FILE",
             "CSV with a pair per row: names of --places in the columns from and to, or coordinates (see "
             "below)",
             request.pairs);
  group.file("--places", "FILE",
             "CSV, GeoJSON, GeoPackage or Shapefile with places, as observers elsewhere; without --pairs "
             "every one is paired with every other",
             request.places);
  group.text("--places-crs", "CRS",
             "reference system of the places, such as EPSG:4326 (default: what their file says, of CSV the "
             "cloud's)",
             request.places_crs);
  group.number("--end-height", "LENGTH",
               "of ends above their foot (default: 0 for ends with a z, 2 for those on the ground)",
               request.defaults.height, 0.0, 1e6);
}

void check_pair_request(const PairRequest& request) {
  if (request.pairs.empty() && request.places.empty())
    throw Error({.problem = "no sight lines are given", .expected = "--pairs FILE or --places FILE"});
  if (request.places.empty() && !request.places_crs.empty())
    throw Error({.problem = "--places-crs is for --places", .expected = "--places FILE"});
}

LineEnds load_line_ends(const PairRequest& request, const VisibilityCloud& cloud, Verbosity verbosity) {
  std::vector<visibility::GivenPair> given;
  if (!request.pairs.empty()) given = visibility::read_pair_table(request.pairs);
  const bool has_places = !given.empty() && given.front().has_places;
  if (has_places && !request.places.empty()) {
    throw Error({.file = request.pairs.string(),
                 .problem = "has coordinates of its own",
                 .expected = "names of --places, or no --places"});
  }
  ObserverOptions options;
  if (has_places) options = ends_with_places(given);
  options.file = request.places;
  options.reference = request.places_crs;
  options.reference_option = "--places-crs";
  options.defaults = request.defaults;
  LineEnds ends;
  ends.are_pairs = !given.empty();
  if (has_places || !request.places.empty()) ends.places = load_observers(options, cloud, verbosity);
  if (ends.are_pairs) {
    if (!has_places) ends.places = ends_with_names(ends.places, given);
    return ends;
  }
  if (ends.places.size() < 2) {
    throw Error({.file = request.places.string(),
                 .problem = "holds a single place",
                 .expected = "two or more, which are paired"});
  }
  return ends;
}

void check_report_memory(const LineEnds& ends, LineZones zones) {
  std::uint64_t bytes_per_line = sizeof(visibility::LinePair) + sizeof(visibility::LineReport);
  if (zones == LineZones::fresnel)
    bytes_per_line += visibility::k_most_obstructions * sizeof(visibility::Obstruction);
  const std::uint64_t places = ends.places.size();
  const std::uint64_t lines = ends.are_pairs ? places / 2 : places * (places - 1) / 2;
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(lines, bytes_per_line, &bytes))
    bytes = std::numeric_limits<std::uint64_t>::max();
  check_memory(bytes, "the reports on all pairs");
}

void check_margin(const LineEnds& ends, double margin) {
  if (margin == 0.0) return;
  for_each_pair(ends, [&](std::size_t from, std::size_t to) {
    const double length = distance(ends.places[from].position, ends.places[to].position);
    if (2.0 * margin < length) return;
    throw Error({.problem = fmt::format("--end-margin leaves nothing of the line from '{}' to '{}'",
                                        ends.places[from].name, ends.places[to].name),
                 .expected = fmt::format("less than half of its {:.6g}", length),
                 .found = fmt::format("{:.6g}", margin)});
  });
}

std::vector<visibility::LinePair> pairs_of(const LineEnds& ends, const visibility::Occluders& occluders) {
  std::vector<visibility::SightEnd> sight_ends;
  for (const visibility::Observer& place : ends.places)
    sight_ends.push_back(visibility::end_near_surface(occluders, place.position));
  std::vector<visibility::LinePair> pairs;
  for_each_pair(ends, [&](std::size_t from, std::size_t to) {
    pairs.push_back({ends.places[from].name, sight_ends[from], ends.places[to].name, sight_ends[to]});
  });
  return pairs;
}

}  // namespace alidade::tools
