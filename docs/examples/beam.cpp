// SPDX-License-Identifier: MIT
// beam CLOUD: what does a laser beam that widens by 1 mm per metre touch first?
#include <cmath>
#include <cstdio>

#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/query.h"

int main(int argument_count, char** arguments) {
  using namespace alidade;
  if (argument_count != 2) return 2;
  const Octree octree = build(read_cloud(arguments[1]));
  const glm::dvec3 middle = octree.bounds().center();

  std::vector<Cone> beams;
  for (int degree = 0; degree < 360; degree += 10) {
    const double angle = degree * std::acos(-1.0) / 180.0;
    beams.push_back(make_cone(middle, {std::cos(angle), std::sin(angle), -0.2}, 0.001, 0.005));
  }
  const Answers<Hit> answers = find(octree, beams, {.measure = Measure::t, .k = 1});
  for (std::size_t i = 0; i < answers.size(); ++i) {
    for (const Hit& hit : answers[i]) std::printf("beam %zu: %.2f m\n", i, hit.t);
  }
}
