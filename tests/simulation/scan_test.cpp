// SPDX-License-Identifier: MIT
#include "simulation/scan.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <filesystem>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "cloud/read_cloud.h"
#include "simulation/courtyard.h"
#include "tests/support/random.h"

namespace alidade {

using namespace simulation;

namespace {

using glm::dvec3;

/// All batches as one cloud.
PointCloud collect(const Site& site, const ScanOptions& options) {
  PointCloud cloud = scan_header(site);
  scan(site, options, [&](const PointCloud& batch) {
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(cloud.positions, batch.positions);
    append(cloud.colors, batch.colors);
    append(cloud.intensities, batch.intensities);
    append(cloud.classifications, batch.classifications);
    append(cloud.returns, batch.returns);
    append(cloud.scan_angles, batch.scan_angles);
    append(cloud.point_source_ids, batch.point_source_ids);
    append(cloud.gps_times, batch.gps_times);
  });
  return cloud;
}

TEST(Scan, GivesExactlyAsManyPointsAsAskedFor) {
  const Site site = courtyard();
  for (const std::uint64_t count : {0, 1, 2, 7, 100, 1000, 12345, 100003})
    EXPECT_EQ(collect(site, courtyard_scan(count, 1)).size(), count);
}

TEST(Scan, EveryStationAndLineTakesPart) {
  const Site site = courtyard();
  const ScanOptions options = courtyard_scan(20000, 1);
  const PointCloud cloud = collect(site, options);
  const std::size_t sources = options.stations.size() + options.flight_lines.size();
  std::vector<int> counts(sources + 1);
  std::size_t terrestrial = 0;
  for (const std::uint16_t source : cloud.point_source_ids) {
    ASSERT_TRUE(source >= 1 && source <= sources);
    ++counts[source];
    terrestrial += source <= options.stations.size() ? 1 : 0;
  }
  for (std::size_t source = 1; source <= sources; ++source) EXPECT_GT(counts[source], 300) << source;
  EXPECT_NEAR(static_cast<double>(terrestrial) / 20000.0, options.terrestrial_share, 0.03);
}

TEST(Scan, IsTheSameOnOneAndOnTwoThreads) {
  const Site site = courtyard();
  std::array<PointCloud, 2> clouds;
  for (std::size_t threads = 1; threads <= 2; ++threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    clouds[threads - 1] = collect(site, courtyard_scan(300000, 5));
  }
  EXPECT_EQ(clouds[0].positions, clouds[1].positions);
  EXPECT_EQ(clouds[0].colors, clouds[1].colors);
  EXPECT_EQ(clouds[0].intensities, clouds[1].intensities);
  EXPECT_EQ(clouds[0].gps_times, clouds[1].gps_times);
}

TEST(Scan, SeedsChangeTheNoiseAndOnlyTheNoise) {
  const Site site = courtyard();
  const PointCloud one = collect(site, courtyard_scan(20000, 1)),
                   two = collect(site, courtyard_scan(20000, 2));
  EXPECT_EQ(one.colors, two.colors);
  std::size_t differ = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    differ += one.positions[i] == two.positions[i] ? 0 : 1;
    ASSERT_LT(glm::length(one.world(i) - two.world(i)), 0.1);
  }
  EXPECT_GT(differ, one.size() / 3);
}

TEST(Scan, StationPointsLieOnTheFirstSurfaceOfTheirBeamWithinTheNoise) {
  const Site site = courtyard();
  const ScanOptions options = courtyard_scan(60000, 3);
  const PointCloud cloud = collect(site, options);
  // 5 standard deviations and the rounding to the lattice. A grazing beam would end too near the surface for
  // this limit.
  const double k_limit = 5.0 * options.terrestrial.range_noise + 0.001;
  std::size_t checked = 0, near = 0;
  for (std::size_t i = 0; i < cloud.size() && cloud.point_source_ids[i] <= options.stations.size(); ++i) {
    const dvec3 eye = options.stations[cloud.point_source_ids[i] - 1u].position;
    const dvec3 to_point = cloud.world(i) - eye;
    const double range = glm::length(to_point);
    const auto hit = site.closest(make_ray(eye, to_point, 0.0));
    ++checked;
    // Rounding turns the beam by up to a millimetre at the point, so next to an edge it may meet something
    // else.
    if (!hit || std::fabs(hit->t - range) > k_limit + 0.02) continue;
    ++near;
    if (glm::dot(hit->normal, -glm::normalize(to_point)) < 0.5) continue;
    ASSERT_LE(std::fabs(hit->t - range), k_limit + 0.001);
  }
  EXPECT_GT(checked, 30000u);
  EXPECT_GT(static_cast<double>(near), 0.985 * static_cast<double>(checked));
}

/// A level field with a wall before a part of it: everything about its scan can be worked out.
Site field_with_wall() {
  shapes::Ground ground;
  ground.half_size = {100, 100};
  ground.core = {100, 100};
  return Site({{ground, {.material = SiteMaterial::terrain}},
               {shapes::Box{{0, 10, 2}, glm::dmat3(1.0), {5, 0.1, 2}},
                {.material = SiteMaterial::plaster, .tint = dvec3(0.8)}}},
              {690000.0, 5325000.0, 600.0});
}

ScanOptions field_options(const Site& site, std::uint64_t count) {
  ScanOptions options;
  options.point_count = count;
  options.stations = {{site.origin() + dvec3(0, 0, 1.7)}};
  options.flight_lines = {{site.origin() + dvec3(-40, 60, 60), site.origin() + dvec3(40, 60, 60)}};
  return options;
}

TEST(Scan, LeavesAShadowBehindTheWall) {
  const Site site = field_with_wall();
  const ScanOptions options = field_options(site, 200000);
  const PointCloud cloud = collect(site, options);
  int before = 0, wall = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.point_source_ids[i] != 1) continue;
    const dvec3 position = cloud.world(i) - site.origin();
    // The wall's shadow on the ground: behind it within the angle it covers, for the wall is higher than the
    // scanner.
    ASSERT_FALSE(position.y > 10.2 && std::fabs(position.x) < 0.49 * position.y && position.z < 3.0)
        << position.x << ' ' << position.y;
    before += position.y > 1.0 && position.y < 9.0 && std::fabs(position.x) < 0.49 * position.y ? 1 : 0;
    wall += std::fabs(position.y - 9.9) < 0.02 && position.z > 0.1 ? 1 : 0;
  }
  EXPECT_GT(before, 1000);
  EXPECT_GT(wall, 1000);
}

TEST(Scan, DensityFallsAsARasterOfEqualAnglesMust) {
  const Site site = field_with_wall();
  const PointCloud cloud = collect(site, field_options(site, 1500000));
  // A beam meets level ground at distance height / tan(depression), so a ring between distances a and b holds
  // columns * (atan(height / a) - atan(height / b)) / step points.
  const auto ring = [&](double from, double to) {
    double count = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (cloud.point_source_ids[i] != 1) continue;
      const dvec3 position = cloud.world(i) - site.origin();
      const double distance = std::sqrt(position.x * position.x + position.y * position.y);
      if (position.y < 0.0 && distance >= from && distance < to) ++count;
    }
    return count;
  };
  const auto expected = [](double from, double to) { return std::atan(1.7 / from) - std::atan(1.7 / to); };
  const double near = ring(4, 8), middle = ring(8, 16), far = ring(16, 32);
  // Within a raster row more or less.
  EXPECT_NEAR(near / middle, expected(4, 8) / expected(8, 16), 0.08);
  EXPECT_NEAR(middle / far, expected(8, 16) / expected(16, 32), 0.12);
  EXPECT_GT(near / (64.0 - 16.0), 6.0 * middle / (256.0 - 64.0));  // per area
}

TEST(Scan, NoiseHasItsStandardDeviationAndEndsAtFive) {
  const Site site = field_with_wall();
  ScanOptions options = field_options(site, 200000);
  options.drone.range_noise = 0.1;
  const PointCloud cloud = collect(site, options);
  double sum = 0.0, sum_sq = 0.0, count = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.point_source_ids[i] != 2) continue;
    const double slant = std::cos(cloud.scan_angles[i] * 3.14159265358979 / 180.0);
    const double deviation = (site.origin().z - cloud.world(i).z) / slant;
    sum += deviation;
    sum_sq += deviation * deviation;
    largest = std::max(largest, std::fabs(deviation));
    ++count;
  }
  ASSERT_GT(count, 50000.0);
  EXPECT_NEAR(sum / count, 0.0, 0.002);
  EXPECT_NEAR(std::sqrt(sum_sq / count), 0.1, 0.002);
  EXPECT_GT(largest, 0.35);
  EXPECT_LE(largest, 0.5 + 0.002);
}

TEST(Scan, BeamsThatMissAreMadeUpFor) {
  // A small plate under a long flight: most beams pass by it.
  const Site site({{shapes::Box{{0, 0, 0}, glm::dmat3(1.0), {3, 3, 0.1}}, {}}}, {690000.0, 5325000.0, 600.0});
  ScanOptions options;
  options.point_count = 5000;
  options.flight_lines = {{site.origin() + dvec3(-40, 0, 60), site.origin() + dvec3(40, 0, 60)}};
  EXPECT_EQ(collect(site, options).size(), 5000u);
}

TEST(Scan, ErrorsWhenNothingCanBeMeasured) {
  const Site site = field_with_wall();
  ScanOptions options = field_options(site, 1000);
  options.flight_lines.clear();
  EXPECT_THROW(collect(site, options), Error);
  options = field_options(site, 1000);
  options.flight_lines[0].start.x += 1000.0, options.flight_lines[0].end.x += 1000.0;
  options.stations.clear();
  EXPECT_THROW(collect(site, options), Error);
  options = field_options(site, 1000);
  options.terrestrial_share = 1.5;
  EXPECT_THROW(collect(site, options), Error);
}

TEST(Scan, StopsWhenAskedTo) {
  const Site site = courtyard();
  EXPECT_THROW(scan(
                   site, courtyard_scan(1000000, 1), [](const PointCloud&) {},
                   [](std::uint64_t, std::uint64_t) { return false; }),
               Cancelled);
}

TEST(Scan, ErrorsOfTheSinkReachTheCaller) {
  const Site site = courtyard();
  int batches = 0;
  const auto failing = [&](const PointCloud&) {
    if (++batches == 3) throw Error({.problem = "no space"});
  };
  EXPECT_THROW(scan(site, courtyard_scan(1000000, 1), failing), Error);
  EXPECT_EQ(batches, 3);
}

TEST(Scan, ErrorsWhenAPointIsBeyondTheLattice) {
  // 3000 km away: more than 2^31 millimetres.
  const Site site({{shapes::Disc{{3e6, 0, 0}, {0, 0, 1}, 100.0, 0.0}, {}}}, {690000.0, 5325000.0, 600.0});
  ScanOptions options;
  options.point_count = 1000;
  options.flight_lines = {
      {site.origin() + dvec3(3e6 - 10.0, 0, 60), site.origin() + dvec3(3e6 + 10.0, 0, 60)}};
  EXPECT_THROW(collect(site, options), Error);
}

TEST(Scan, ColumnsAreFilledAsDocumented) {
  const Site site = courtyard();
  const PointCloud cloud = collect(site, courtyard_scan(50000, 1));
  EXPECT_EQ(cloud.attributes(), scan_attributes());
  EXPECT_EQ(cloud.lattice.scale, dvec3(0.001));
  EXPECT_EQ(cloud.lattice.offset, dvec3(690000.0, 5325000.0, 600.0));
  const Bounds bounds = cloud.bounds();
  EXPECT_GT(bounds.min.x, 690000.0 - 63.0);
  EXPECT_LT(bounds.max.x, 690000.0 + 63.0);
  EXPECT_GT(bounds.min.y, 5325000.0 - 55.0);
  EXPECT_LT(bounds.max.y, 5325000.0 + 55.0);
  EXPECT_GT(bounds.min.z, 600.0 - 3.0);
  EXPECT_LT(bounds.max.z, 600.0 + 16.0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ASSERT_EQ(cloud.returns[i], (ReturnNumbers{1, 1}));
    ASSERT_LE(std::fabs(cloud.scan_angles[i]), 180.0f);
  }
  for (std::size_t i = 1; i < cloud.size(); ++i) ASSERT_GT(cloud.gps_times[i], cloud.gps_times[i - 1]);
}

TEST(GenerateCourtyard, WritesWhatTheScanGives) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / "alidade_simulation_courtyard.las";
  GenerateOptions options;
  options.point_count = 40000;
  options.overwrite = true;
  generate_courtyard(path, options);
  const PointCloud read = read_cloud(path);
  const PointCloud scanned = collect(courtyard(), courtyard_scan(40000, 1));
  EXPECT_EQ(read.positions, scanned.positions);
  EXPECT_EQ(read.colors, scanned.colors);
  EXPECT_EQ(read.gps_times, scanned.gps_times);
  EXPECT_EQ(read.classifications, scanned.classifications);
  EXPECT_EQ(read.crs.wkt, scanned.crs.wkt);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace alidade
