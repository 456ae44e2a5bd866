// SPDX-License-Identifier: MIT
// visibility_truth: which points of scans of the courtyard five observers see, by lines of sight through the points, against
// lines of sight through the exact surfaces. Prints a table in Markdown.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <vector>

#include "base/parallel.h"
#include "octree/build.h"
#include "simulation/courtyard.h"
#include "simulation/scan.h"
#include "visibility/points/point_visibility.h"

namespace alidade {

using namespace visibility;

namespace {

const simulation::Site& site() {
  static const simulation::Site site = simulation::courtyard();
  return site;
}

PointCloud scan_of(std::uint64_t points) {
  PointCloud cloud = simulation::scan_header(site());
  simulation::scan(site(), simulation::courtyard_scan(points, 1), [&](const PointCloud& batch) {
    cloud.positions.insert(cloud.positions.end(), batch.positions.begin(), batch.positions.end());
    cloud.classifications.insert(cloud.classifications.end(), batch.classifications.begin(),
                                 batch.classifications.end());
  });
  return cloud;
}

/// Whether the eye sees the surface that a point was measured on: the first one in its direction is not before it, or
/// passes within the noise of the point.
bool is_seen_in_truth(const glm::dvec3& eye, const glm::dvec3& point) {
  constexpr double k_noise = 0.02;  // metres across the surface
  const glm::dvec3 way = point - eye;
  const auto hit = site().closest(make_ray(eye, way, 1e-6, glm::length(way)));
  return !hit || std::fabs(glm::dot(point - hit->position, hit->normal)) < k_noise;
}

struct Counts {
  std::size_t right = 0, falsely_seen = 0, falsely_hidden = 0;

  std::string text() const {
    const auto percent = [](std::size_t part, std::size_t rest) {
      return 100.0 * static_cast<double>(part) / static_cast<double>(part + rest);
    };
    return fmt::format("{:.1f} / {:.1f} / {:.1f}", percent(right, falsely_seen),
                       percent(right, falsely_hidden), percent(right, falsely_seen + falsely_hidden));
  }
};

void print_rows(std::uint64_t points) {
  constexpr int k_low_vegetation = 3, k_high_vegetation = 5;
  const PointCloud cloud = scan_of(points);
  const Occluders occluders(build(cloud), {});
  for (const glm::dvec3& position :
       {glm::dvec3(5, -10, 1.7), {23, -15.2, 6.8}, {9, -9, 1.7}, {45, -45, 40}, {-20, 2, 1.7}}) {
    Observer observer;
    observer.position = site().origin() + position;
    std::vector<std::uint8_t> truth(cloud.size());
    in_parallel(cloud.size(), 1024,
                [&](std::size_t id) { truth[id] = is_seen_in_truth(observer.position, cloud.world(id)); });
    const PointVisibility found = point_visibility(occluders, {&observer, 1}, {});
    std::array<Counts, 2> counts;  // of surfaces, of vegetation
    for (std::size_t id = 0; id < cloud.size(); ++id) {
      const int what = cloud.classifications[id];
      Counts& of_kind = counts[what >= k_low_vegetation && what <= k_high_vegetation ? 1 : 0];
      const bool seen = found.counts[id] != 0;
      of_kind.right += seen && truth[id] != 0;
      of_kind.falsely_seen += seen && truth[id] == 0;
      of_kind.falsely_hidden += !seen && truth[id] != 0;
    }
    fmt::print("| {} | {:g}, {:g}, {:g} | {} | {} |\n", points, position.x, position.y, position.z,
               counts[0].text(), counts[1].text());
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace alidade

int main() {
  fmt::print(
      "| points | observer | surfaces: precision / recall / IoU, % | crowns: precision / recall / IoU, % |\n"
      "|--:|---|--:|--:|\n");
  for (const std::uint64_t points : {100'000u, 1'000'000u, 5'000'000u}) alidade::print_rows(points);
}
