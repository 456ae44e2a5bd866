// SPDX-License-Identifier: MIT
// visibility_strays: how many points of scans of the courtyard are reported wrongly because of points without
// support: stray returns, birds, wires, foliage. Prints a table in Markdown.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

#include "octree/build.h"
#include "tests/bench/courtyard_truth.h"
#include "visibility/points/point_visibility.h"

namespace alidade {

using namespace visibility;

namespace {

/// A kind of things in the air that few points lie on.
struct Kind {
  const char* name;
  double radius;  ///< of what each point lies on, metres
  /// Adds the points of the next thing, in the site's own frame.
  void (*add)(std::mt19937_64& random, double spacing, std::vector<glm::dvec3>& points);
};

double uniform(std::mt19937_64& random, double from, double to) {
  return from + (to - from) * 0x1p-64 * static_cast<double>(random());
}

glm::dvec3 in_box(std::mt19937_64& random, const glm::dvec3& from, const glm::dvec3& to) {
  return {uniform(random, from.x, to.x), uniform(random, from.y, to.y), uniform(random, from.z, to.z)};
}

glm::dvec3 in_the_air(std::mt19937_64& random) {
  return in_box(random, {-55, -48, 0.5}, {55, 48, 25});
}

void add_cluster(std::mt19937_64& random, const glm::dvec3& middle, double half_width, int count,
                 std::vector<glm::dvec3>& points) {
  for (int i = 0; i < count; ++i) points.push_back(in_box(random, middle - half_width, middle + half_width));
}

constexpr Kind k_kinds[] = {
    {"stray returns", 0.0,
     [](std::mt19937_64& random, double, std::vector<glm::dvec3>& points) {
       points.push_back(in_the_air(random));
     }},
    {"birds", 0.1,
     [](std::mt19937_64& random, double, std::vector<glm::dvec3>& points) {
       add_cluster(random, in_the_air(random), 0.1, 1 + static_cast<int>(random() % 6), points);
     }},
    {"wires", 0.01,
     [](std::mt19937_64& random, double spacing, std::vector<glm::dvec3>& points) {
       const double height = uniform(random, 5.0, 14.0);
       const glm::dvec3 from = in_box(random, {-50, -45, height}, {50, 45, height});
       const double turn = uniform(random, 0.0, 6.283), length = uniform(random, 15.0, 40.0),
                    sag = 0.02 * length;
       for (double along = 0.0; along < length; along += spacing) {
         const double share = 2.0 * along / length - 1.0;
         points.push_back(
             from + glm::dvec3(along * std::cos(turn), along * std::sin(turn), sag * (share * share - 1.0)));
       }
     }},
    {"foliage", 0.03,
     [](std::mt19937_64& random, double, std::vector<glm::dvec3>& points) {
       add_cluster(random, in_box(random, {-50, -45, 0.5}, {50, 45, 4.0}), 0.5, 12, points);
     }},
};

/// A cloud of the site with so many more points of a kind behind its own.
PointCloud with_things(const PointCloud& scan, const Kind& kind, std::size_t count, double spacing) {
  std::mt19937_64 random(7);
  std::vector<glm::dvec3> points;
  while (points.size() < count) kind.add(random, spacing, points);
  points.resize(count);
  PointCloud cloud = scan;
  for (const glm::dvec3& point : points)
    cloud.positions.push_back(*to_lattice(cloud.lattice, courtyard_site().origin() + point));
  cloud.classifications.resize(cloud.size(), 1);
  return cloud;
}

/// Which of the scan's own points the things hide in truth: those behind a ball around one of them.
std::vector<std::uint32_t> seen_past(const PointCloud& cloud, const PointCloud& scan, const Kind& kind,
                                     const Observer& observer) {
  PointCloud things = simulation::scan_header(courtyard_site());
  things.positions.assign(cloud.positions.begin() + static_cast<std::ptrdiff_t>(scan.size()),
                          cloud.positions.end());
  std::vector<std::uint32_t> seen(scan.size(), 1);
  if (kind.radius == 0.0) return seen;
  const Occluders occluders(build(things), {.shape = OccluderShape::sphere, .radius = kind.radius});
  std::vector<SightLine> lines(scan.size());
  for (std::size_t id = 0; id < scan.size(); ++id)
    lines[id] = sight_line({observer.position}, {scan.world(id)});
  std::vector<std::uint8_t> hidden(scan.size());
  blocked(occluders, lines, hidden);
  std::ranges::transform(hidden, seen.begin(),
                         [](std::uint8_t is_hidden) { return is_hidden == 0 ? 1u : 0u; });
  return seen;
}

void print_rows(double density) {
  constexpr double k_area = 124.0 * 108.0;  // square metres
  const PointCloud scan = courtyard_points(static_cast<std::uint64_t>(density * k_area));
  std::vector<Observer> observers;
  std::vector<std::vector<std::uint8_t>> truth;
  std::vector<PointVisibility> before;
  const Occluders alone(build(scan), {});
  for (const glm::dvec3& eye : k_courtyard_eyes) {
    observers.emplace_back().position = courtyard_site().origin() + eye;
    truth.push_back(seen_in_truth(scan, observers.back().position));
    before.push_back(point_visibility(alone, {&observers.back(), 1}, {}));
  }
  for (const Kind& kind : k_kinds) {
    for (const double share : {1e-4, 1e-3, 5e-3}) {
      const auto count = static_cast<std::size_t>(std::ceil(share * static_cast<double>(scan.size())));
      const PointCloud cloud = with_things(scan, kind, count, 1.0 / std::sqrt(density));
      const Occluders occluders(build(cloud), {});
      std::size_t wrong = 0, corrected = 0, all = 0;
      for (std::size_t i = 0; i < observers.size(); ++i) {
        const std::vector<std::uint32_t> past = seen_past(cloud, scan, kind, observers[i]);
        const PointVisibility found = point_visibility(occluders, {&observers[i], 1}, {});
        all += scan.size();
        for (std::size_t id = 0; id < scan.size(); ++id) {
          const bool seen = truth[i][id] != 0 && past[id] != 0;
          if ((found.counts[id] != 0) == (before[i].counts[id] != 0)) continue;
          ((found.counts[id] != 0) == seen ? corrected : wrong) += 1;
        }
      }
      const auto percent = [&](std::size_t part) {
        return 100.0 * static_cast<double>(part) / static_cast<double>(all);
      };
      fmt::print("| {:g} | {} | {:g} | {} | {:.3f} | {:.3f} |\n", density, kind.name, 1000.0 * share, count,
                 percent(wrong), percent(corrected));
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace alidade

int main(int argc, char** argv) {
  fmt::print(
      "| points/m2 | what | per mille | points of it | wrong by it, % | right by it, % "
      "|\n|--:|---|--:|--:|--:|--:|\n");
  std::vector<double> densities{1.0, 4.0, 20.0, 400.0};
  if (argc > 1) densities.clear();
  for (int i = 1; i < argc; ++i) densities.push_back(std::atof(argv[i]));
  for (const double density : densities) alidade::print_rows(density);
}
