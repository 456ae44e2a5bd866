// SPDX-License-Identifier: MIT
// pruning CLOUD: what each pruning mechanism of the paper saves; prints the table of docs/reports/pruning.md.
#include <cmath>
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query_targets.h"
#include "octree/tree_query.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  if (argument_count != 2) return 2;
  const Octree octree = build(read_cloud(arguments[1]));
  const Bounds& box = octree.bounds();

  // From the middle of the scan, at the height of an eye, in all directions.
  std::vector<Ray> rays;
  for (int i = 0; i < 500; ++i) {
    const double turn = i * 2.399963, down = -0.5 + 0.002 * i;
    rays.push_back(make_ray(box.center(), {std::cos(turn), std::sin(turn), down}, 0.5, 30.0));
  }
  struct NamedQuery {
    const char* name;
    RayQuery query;
  };
  const NamedQuery queries[] = {{"all within 10 cm", {.radius = 0.1}},
                                {"first by entry", {.radius = 0.1, .k = 1}},
                                {"8 nearest to the ray", {.measure = Measure::distance, .k = 8}}};
  struct Switched {
    const char* name;
    Pruning pruning;
  };
  const Switched switched[] = {{"all on", {}},
                               {"distance by spheres (eq. 3)", {.distance = DistanceBound::sphere}},
                               {"without distance", {.distance = DistanceBound::none}},
                               {"without time interval (eq. 4)", {.time_interval = false}},
                               {"without dynamic k", {.dynamic_k = false}}};

  std::printf("| nodes / points per ray |");
  for (const NamedQuery& q : queries) std::printf(" %s |", q.name);
  std::printf("\n|---|---|---|---|\n");
  for (const Switched& s : switched) {
    std::printf("| %s |", s.name);
    for (const auto& [name, query] : queries) {
      QueryStatistics sum;
      for (const Ray& ray : rays) {
        const RayTarget target(ray, query);
        Nearest nearest(target, query.k);
        sum += tree_query(OctreeTree(octree.view()), target, nearest, s.pruning);
      }
      const auto per_ray = static_cast<double>(rays.size());
      std::printf(" %.1f / %.1f |", static_cast<double>(sum.nodes_visited) / per_ray,
                  static_cast<double>(sum.points_tested) / per_ray);
    }
    std::printf("\n");
  }
}
