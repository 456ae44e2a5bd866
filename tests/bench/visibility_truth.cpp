// SPDX-License-Identifier: MIT
// visibility_truth: which points of scans of the courtyard five observers see, by lines of sight through the
// points, against lines of sight through the exact surfaces. Prints a table in Markdown.
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <vector>

#include "octree/build.h"
#include "tests/bench/courtyard_truth.h"
#include "visibility/points/point_visibility.h"

namespace alidade {

using namespace visibility;

namespace {

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
  const PointCloud cloud = courtyard_points(points);
  const Occluders occluders(build(cloud), {});
  for (const glm::dvec3& position : k_courtyard_eyes) {
    Observer observer;
    observer.position = courtyard_site().origin() + position;
    const std::vector<std::uint8_t> truth = seen_in_truth(cloud, observer.position);
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
