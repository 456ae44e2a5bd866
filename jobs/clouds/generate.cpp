// SPDX-License-Identifier: MIT
#include "jobs/clouds/generate.h"

#include <cstdint>
#include <utility>

#include "cloud/rows.h"
#include "jobs/outputs.h"
#include "simulation/courtyard.h"

namespace alidade::jobs {

void add_generate_fields(const Fields& fields, GenerateRequest& request) {
  // The index cannot number more (octree/build.h).
  constexpr std::uint64_t k_most_points = 4'294'967'295;
  fields.required().value(
      "site", "courtyard",
      "the site: a courtyard with houses, trees, lamp posts and a car, scanned from the ground and "
      "from the air",
      [](const std::string& text) {
        if (text != "courtyard") throw UsageError("invalid value; expected courtyard, found '" + text + "'");
      });
  fields.required().file("-o,--output", "FILE.las|FILE.laz",
                         "output: LAS 1.4, or LAZ by the extension; metres, UTM zone 32N", request.output);
  fields.count("--points", "N", "exact number of points, such as 2e6 (default 2e6; up to 4294967295)",
               request.point_count, 1, k_most_points);
  fields.count("--seed", "N",
               "seed of the range noise; the same seed and count give the same bytes (default 1)",
               request.seed, 0, UINT64_MAX);
  fields.flag("--overwrite", "replace an existing output", request.overwrite);
}

GeneratePlan plan(const GenerateRequest& request) {
  if (request.output.has_extension()) check_extension(request.output, {".las", ".laz"});
  if (!request.output.empty()) check_writable(request.output, request.overwrite);
  return GeneratePlan(request, {.writes = {request.output}});
}

PointCloud run(const GeneratePlan& plan, Listener& listener) {
  const GenerateRequest& request = plan.request();
  return in_stage(listener, "scanning", "points", [&](const Progress& progress) {
    PointCloud cloud;
    if (!request.output.empty()) {
      simulation::generate_courtyard(request.output, {.point_count = request.point_count,
                                                      .seed = request.seed,
                                                      .overwrite = request.overwrite,
                                                      .progress = progress});
      return cloud;
    }
    const simulation::Site site = simulation::courtyard();
    cloud = simulation::scan_header(site);
    simulation::scan(
        site, simulation::courtyard_scan(request.point_count, request.seed),
        [&cloud](PointCloud batch) { append_cloud(cloud, std::move(batch)); }, progress);
    return cloud;
  });
}

}  // namespace alidade::jobs
