// SPDX-License-Identifier: MIT
// two_scans POINTS BEFORE.las AFTER.las: scans the simulated courtyard twice; in between a car drives away.
#include <glm/geometric.hpp>
#include <string>

#include "cloud/las/write_las.h"
#include "simulation/courtyard.h"

namespace {

using namespace alidade;
using namespace alidade::simulation;

void write_scan(const Site& site, std::uint64_t points, std::uint64_t seed, const std::string& file) {
  LasWriter writer(file, scan_header(site), scan_attributes(), {.overwrite = true});
  scan(site, courtyard_scan(points, seed), [&](const PointCloud& batch) { writer.write(batch); });
  writer.finish();
}

Site without_red_car(const Site& site) {
  const glm::dvec3 position(11.6, -9.0, 0.7);  // its middle, in the site's frame
  std::vector<SiteObject> objects;
  for (const SiteObject& object : site.objects()) {
    const Bounds box = shapes::bounds_of(object.shape);
    const bool is_of_car = glm::length(box.max - box.min) < 8.0 && glm::length(box.center() - position) < 2.6;
    if (!is_of_car) objects.push_back(object);
  }
  return Site(objects, site.origin());
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) return 2;
  const std::uint64_t points = std::stoull(arguments[1]);
  const Site site = courtyard();
  write_scan(site, points, 1, arguments[2]);
  write_scan(without_red_car(site), points, 2, arguments[3]);
}
