// SPDX-License-Identifier: MIT
// change_truth [POINTS...]: classes of change between two simulated scans of the courtyard against those of
// exact lines through both states of the site. Prints tables in Markdown.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "extensions/change/tests/changed_courtyard.h"
#include "octree/build.h"
#include "octree/query.h"

namespace alidade {

using namespace visibility;
using test::SiteState;

namespace {

constexpr double k_max_distance = 0.15, k_registration_error = 0.001;  // metres
constexpr double k_thin = 0.25;                                        // metres between beams

enum Kind { surfaces, thin, edges, crowns, k_kinds };
constexpr std::array<const char*, k_kinds> k_kind_names{"surfaces", "thinly scanned", "at edges", "crowns"};

/// Rows: what is true; columns: what was found. gone and appeared are one.
struct Confusion {
  std::array<std::array<std::size_t, 5>, 4> counts{};

  static std::size_t place_of(ChangeClass kind) {
    switch (kind) {
      case ChangeClass::same:
        return 0;
      case ChangeClass::moved:
        return 1;
      case ChangeClass::gone:
      case ChangeClass::appeared:
        return 2;
      case ChangeClass::never_seen:
        return 3;
      default:
        return 4;
    }
  }

  /// Rows of the table, those without points left out.
  void print(const char* epoch, const char* kind, const char* lost) const {
    const std::array<const char*, 4> names{"same", "moved", lost, "never seen"};
    for (std::size_t row = 0; row < 4; ++row) {
      std::size_t all = 0;
      for (const std::size_t count : counts[row]) all += count;
      if (all == 0) continue;
      std::string text = fmt::format("| {} | {} | {} | {} |", epoch, kind, names[row], all);
      for (std::size_t column = 0; column < 4; ++column)
        text += fmt::format(" {:.1f} |",
                            100.0 * static_cast<double>(counts[row][column]) / static_cast<double>(all));
      fmt::print("{}\n", text);
    }
  }
};

/// Whether one of the 32 nearest points, as many as a cylinder holds, has another true class.
std::vector<std::uint8_t> at_edges(const Octree& octree, const PointCloud& cloud,
                                   const std::vector<ChangeClass>& truth) {
  std::vector<glm::dvec3> positions(cloud.size());
  for (std::size_t id = 0; id < cloud.size(); ++id) positions[id] = cloud.world(id);
  const Answers<PointHit> nearest = find(octree, positions, PointQuery{.k = 33});
  std::vector<std::uint8_t> edges(cloud.size());
  for (std::size_t id = 0; id < cloud.size(); ++id)
    edges[id] = std::ranges::any_of(nearest[id],
                                    [&](const PointHit& hit) { return truth[hit.point_id] != truth[id]; });
  return edges;
}

/// Prints the rows of one epoch; returns the errors of distances, metres.
std::vector<double> print_epoch(const char* name, const SiteState& own, const PointCloud& cloud,
                                const Octree& octree, const SiteState& other, std::size_t other_points,
                                const PointChanges& found, ChangeClass lost, int sign) {
  // Angle between beams of the other epoch: a raster of 150 by 360 degrees, 0.7 of whose beams have an echo.
  const double step = std::sqrt(0.7 * 2.618 * 6.283 * static_cast<double>(other.stations.size()) /
                                static_cast<double>(other_points));
  const test::TrueChanges truth = test::true_changes(own, cloud, other, k_max_distance, lost);
  const std::vector<std::uint8_t> edges = at_edges(octree, cloud, truth.classes);
  std::array<Confusion, k_kinds> confusions;
  std::vector<double> errors;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    if (truth.classes[id] == ChangeClass::ignored) continue;
    const int what = cloud.classifications[id];
    const bool is_thin = truth.densities[id] > 0.0 && step / truth.densities[id] > k_thin;
    const Kind kind = what == 3 || what == 5 ? crowns
                      : is_thin              ? thin
                      : edges[id] != 0       ? Kind::edges
                                             : surfaces;
    ++confusions[kind].counts[Confusion::place_of(truth.classes[id])][Confusion::place_of(found.classes[id])];
    if (kind == surfaces && truth.classes[id] == ChangeClass::moved &&
        found.classes[id] == ChangeClass::moved)
      errors.push_back(std::fabs(sign * truth.distances[id] - static_cast<double>(found.distances[id])));
  }
  for (std::size_t kind = 0; kind < k_kinds; ++kind)
    confusions[kind].print(name, k_kind_names[kind], name_of(lost));
  return errors;
}

void print_tables(std::uint64_t points) {
  const test::ChangedCourtyard site = test::changed_courtyard();
  const PointCloud before = test::scan_of(site.before, points, 1),
                   after = test::scan_of(site.after, points, 2);
  const Occluders old_occluders(build(before), {}), new_occluders(build(after), {});
  const auto start = std::chrono::steady_clock::now();
  const Changes changes =
      find_changes({old_occluders, site.before.stations}, {new_occluders, site.after.stations},
                   {.registration_error = k_registration_error, .max_distance = k_max_distance});
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("\n{} and {} points, compared in {:.1f} s:\n\n", before.size(), after.size(), seconds);
  fmt::print(
      "| epoch | where | truth | points | same, % | moved, % | gone or new, % | never seen, % |\n"
      "|---|---|---|--:|--:|--:|--:|--:|\n");
  std::vector<double> errors = print_epoch("BEFORE", site.before, before, old_occluders.octree(), site.after,
                                           after.size(), changes.before, ChangeClass::gone, 1);
  const std::vector<double> more =
      print_epoch("AFTER", site.after, after, new_occluders.octree(), site.before, before.size(),
                  changes.after, ChangeClass::appeared, -1);
  errors.insert(errors.end(), more.begin(), more.end());
  std::ranges::sort(errors);
  fmt::print("\nerror of the distance of {} moved points: median {:.2f} mm, 95 % {:.2f} mm\n", errors.size(),
             1e3 * errors[errors.size() / 2], 1e3 * errors[errors.size() * 95 / 100]);
  std::fflush(stdout);
}

}  // namespace
}  // namespace alidade

int main(int count, char** words) {
  if (count < 2) alidade::print_tables(1'000'000);
  for (int i = 1; i < count; ++i) alidade::print_tables(std::strtoull(words[i], nullptr, 10));
}
