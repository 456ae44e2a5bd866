// SPDX-License-Identifier: MIT
#include "simulation/generate.h"

#include "cloud/las/write_las.h"
#include "simulation/courtyard.h"
#include "simulation/courtyard_parts.h"

namespace alidade {

ScanOptions courtyard_scan(std::uint64_t point_count, std::uint64_t seed) {
  const glm::dvec3 origin(690000.0, 5325000.0, 600.0);
  ScanOptions options;
  options.point_count = point_count;
  options.seed = seed;
  const glm::dvec2 yard[] = {{-16.5, -1.5}, {-3.2, 9.5},  {8.0, 3.0},    {19.5, 9.8},
                             {18.2, -8.4},  {5.2, -12.6}, {-11.9, -14.8}};
  const glm::dvec2 street[] = {{-5.0, -30.5}, {28.0, -38.0}, {-36.0, -36.5}};
  const shapes::Ground ground = courtyard_parts::ground();
  const auto set_up = [&](const glm::dvec2& place) {
    constexpr double k_tripod = 1.7;
    options.stations.push_back(
        {origin + glm::dvec3(place, shapes::height_at(ground, place).height + k_tripod)});
  };
  for (const glm::dvec2& place : yard) set_up(place);
  for (const glm::dvec2& place : street) set_up(place);

  constexpr double k_height = 60.0;
  // Straight down along x; then along y looking ahead, there and back, for the walls.
  for (const double y : {-26.0, 0.0, 26.0})
    options.flight_lines.push_back(
        {origin + glm::dvec3(-59.0, y, k_height), origin + glm::dvec3(59.0, y, k_height), 0.0, 46.0});
  for (const double x : {-36.0, -12.0, 12.0, 36.0}) {
    const double direction = x == -36.0 || x == 12.0 ? 1.0 : -1.0;
    options.flight_lines.push_back({origin + glm::dvec3(x, -direction * 86.0, k_height),
                                    origin + glm::dvec3(x, direction * 14.0, k_height), 30.0, 32.0});
  }
  return options;
}

void generate_courtyard(const std::filesystem::path& path, const GenerateOptions& options) {
  const Site site = courtyard();
  LasWriteOptions write_options;
  write_options.overwrite = options.overwrite;
  LasWriter writer(path, scan_header(site), scan_attributes(), write_options);
  scan(
      site, courtyard_scan(options.point_count, options.seed),
      [&](const PointCloud& batch) { writer.write(batch); }, options.progress);
  writer.finish();
}

}  // namespace alidade
