// SPDX-License-Identifier: MIT
// visibility_accuracy: how often sight lines through points are right, beside a depth buffer and hidden point
// removal, on clouds sampled from exact surfaces. Prints a table in Markdown. The two others are given the
// parameters that suit each view best, which in practice are unknown.
#include <libqhull_r/qhull_ra.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "octree/build.h"
#include "tests/support/known_visibility.h"
#include "visibility/points/point_visibility.h"

namespace alidade {

using namespace visibility;

namespace {

using Seen = std::vector<std::uint8_t>;
using test::Agreement;
using test::KnownScene;

Seen by_sight_lines(const Occluders& occluders, const glm::dvec3& eye) {
  Observer observer;
  observer.position = eye;
  const PointVisibility found = point_visibility(occluders, {&observer, 1}, {});
  return Seen(found.counts.begin(), found.counts.end());
}

/// A point is seen if nothing in its pixel of a panorama is nearer by more than a tolerance.
Seen by_depth_buffer(const KnownScene& scene, const glm::dvec3& eye, double degrees, double tolerance) {
  const int columns = static_cast<int>(360.0 / degrees), rows = columns / 2;
  std::vector<float> nearest(static_cast<std::size_t>(columns) * rows, INFINITY);
  std::vector<std::size_t> pixels(scene.cloud.size());
  std::vector<float> distances(scene.cloud.size());
  for (std::size_t id = 0; id < scene.cloud.size(); ++id) {
    const glm::dvec3 way = scene.cloud.world(id) - eye;
    const double distance = glm::length(way);
    const double u = std::atan2(way.y, way.x) / (2.0 * std::numbers::pi) + 0.5;
    const double v = std::acos(std::clamp(way.z / distance, -1.0, 1.0)) / std::numbers::pi;
    pixels[id] = static_cast<std::size_t>(std::min(rows - 1, static_cast<int>(v * rows))) * columns +
                 std::min(columns - 1, static_cast<int>(u * columns));
    distances[id] = static_cast<float>(distance);
    nearest[pixels[id]] = std::min(nearest[pixels[id]], distances[id]);
  }
  Seen seen(scene.cloud.size());
  for (std::size_t id = 0; id < seen.size(); ++id)
    seen[id] = distances[id] <= nearest[pixels[id]] * (1.0 + tolerance) ? 1 : 0;
  return seen;
}

/// Hidden point removal: points are mirrored outward on a sphere around the eye; those on the convex hull are
/// seen. Source: Katz, Tal, Basri, Direct Visibility of Point Sets, SIGGRAPH 2007.
Seen by_hidden_point_removal(const KnownScene& scene, const glm::dvec3& eye, double exponent) {
  const std::size_t count = scene.cloud.size();
  double farthest = 0.0;
  for (std::size_t id = 0; id < count; ++id)
    farthest = std::max(farthest, glm::length(scene.cloud.world(id) - eye));
  const double radius = farthest * std::pow(10.0, exponent);
  std::vector<double> flipped(3 * (count + 1), 0.0);
  for (std::size_t id = 0; id < count; ++id) {
    const glm::dvec3 way = scene.cloud.world(id) - eye;
    const double length = glm::length(way);
    const glm::dvec3 mirrored = way + 2.0 * (radius - length) * way / length;
    for (int axis = 0; axis < 3; ++axis) flipped[3 * id + axis] = mirrored[axis];
  }
  Seen seen(count);
  qhT hull;
  qh_zero(&hull, stderr);
  char command[] = "qhull Qt";
  if (qh_new_qhull(&hull, 3, static_cast<int>(count + 1), flipped.data(), 0, command, nullptr, nullptr) ==
      0) {
    qhT* const qh = &hull;
    vertexT* vertex = nullptr;
    FORALLvertices {
      const int id = qh_pointid(qh, vertex->point);
      if (id >= 0 && static_cast<std::size_t>(id) < count) seen[static_cast<std::size_t>(id)] = 1;
    }
  }
  qh_freeqhull(&hull, qh_ALL);
  int current = 0, total = 0;
  qh_memfreeshort(&hull, &current, &total);
  return seen;
}

/// Means over the observers of a scene.
struct Sum {
  Agreement sum;
  void add(const Agreement& one) {
    sum = {sum.all + one.all, sum.clear + one.clear, sum.precision + one.precision, sum.recall + one.recall};
  }
};

void print(const KnownScene& scene, const char* method, const Sum& sum) {
  const double share = 100.0 / static_cast<double>(scene.observers.size());
  std::printf("| %s | %zu | %s | %.2f | %.2f | %.2f | %.2f |\n", scene.name.c_str(), scene.cloud.size(),
              method, share * sum.sum.all, share * sum.sum.clear, share * sum.sum.precision,
              share * sum.sum.recall);
  std::fflush(stdout);
}

/// The best of several answers, by the share that is right.
class Best {
 public:
  void offer(const Agreement& agreement) {
    if (agreement.all > best_.all) best_ = agreement;
  }
  const Agreement& agreement() const { return best_; }

 private:
  Agreement best_;
};

void compare(const KnownScene& scene) {
  const Occluders occluders(build(scene.cloud), {});
  Sum lines, buffer, removal;
  for (const glm::dvec3& eye : scene.observers) {
    const Seen truth = test::truth(scene, eye);
    const Seen near = test::near_boundary_or_edge(scene, occluders.octree(), truth, eye, 10);
    const auto agreement = [&](const Seen& seen) { return test::agreement(seen, truth, near); };
    lines.add(agreement(by_sight_lines(occluders, eye)));
    Best best_buffer, best_removal;
    for (const double degrees : {0.05, 0.1, 0.2, 0.4, 0.8, 1.6}) {
      for (const double tolerance : {0.0003, 0.001, 0.003, 0.01, 0.03, 0.1})
        best_buffer.offer(agreement(by_depth_buffer(scene, eye, degrees, tolerance)));
    }
    buffer.add(best_buffer.agreement());
    for (const double exponent : {1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0})
      best_removal.offer(agreement(by_hidden_point_removal(scene, eye, exponent)));
    removal.add(best_removal.agreement());
  }
  print(scene, "sight lines, defaults", lines);
  print(scene, "depth buffer, best of 36", buffer);
  print(scene, "hidden point removal, best of 7", removal);
}

}  // namespace
}  // namespace alidade

int main() {
  using namespace alidade::test;
  std::printf(
      "| scene | points | method | right, %% | clear of boundaries, %% | precision, %% | recall, %% |\n");
  std::printf("|---|--:|---|--:|--:|--:|--:|\n");
  for (const auto make : {thin_plate, fence, canopy, mixed_density, grazing_slope}) alidade::compare(make());
  for (const std::size_t points : {100000, 300000, 1000000}) alidade::compare(known_courtyard(points));
}
