// SPDX-License-Identifier: MIT
#include "visibility/raster/ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "base/error.h"
#include "octree/build.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

using Height = std::function<double(double x, double y)>;

double plane(double x, double y) {
  return 500.0 + 0.3 * x - 0.2 * y;
}

/// Points spread over [0, side] x [0, side], far from the origin as maps are.
constexpr double k_east = 690000.0, k_north = 5325000.0;

class Site {
 public:
  Site() { cloud_.lattice = {glm::dvec3(0.0001), {k_east, k_north, 500.0}}; }

  void add(double x, double y, double z, std::uint8_t point_class) {
    cloud_.positions.push_back(*to_lattice(cloud_.lattice, {k_east + x, k_north + y, z}));
    cloud_.classifications.push_back(point_class);
  }
  void scatter(int count, double side, const Height& height, std::uint8_t point_class) {
    for (int i = 0; i < count; ++i) {
      const double x = random_.between(0, side), y = random_.between(0, side);
      add(x, y, height(x, y), point_class);
    }
  }
  Ground ground(const GroundOptions& options = {}) const {
    return make_ground(build(cloud_), cloud_.classifications, options);
  }

 private:
  PointCloud cloud_;
  Random random_;
};

double at(const Ground& ground, double x, double y) {
  return ground.at({k_east + x, k_north + y}).value_or(std::numeric_limits<double>::quiet_NaN());
}

TEST(GroundTest, points_of_class_2_are_the_ground_if_there_are_any) {
  Site site;
  site.scatter(4000, 40, plane, 2);
  site.scatter(
      4000, 40, [](double x, double y) { return plane(x, y) + 12.0; }, 5);
  const Ground ground = site.ground();
  EXPECT_EQ(ground.source(), GroundSource::classified);
  for (double x = 3; x < 38; x += 3.7) EXPECT_NEAR(at(ground, x, 41 - x), plane(x, 41 - x), 0.01);
}

TEST(GroundTest, roads_and_water_between_points_of_class_2_are_ground_too) {
  for (const std::uint8_t point_class : {std::uint8_t{9}, std::uint8_t{11}}) {
    Site site;
    // A strip of its own class on a low dam, which a membrane would cut off.
    const auto is_road = [](double x) { return x > 15.0 && x < 25.0; };
    const auto dam = [&](double x, double y) { return plane(x, y) + (is_road(x) ? 0.5 : 0.0); };
    for (int i = 0; i < 4096; ++i) {
      const double x = 0.3 + 0.61 * (i % 64), y = 0.3 + 0.61 * (i / 64);
      site.add(x, y, dam(x, y), is_road(x) ? point_class : std::uint8_t{2});
    }
    const Ground ground = site.ground();
    EXPECT_EQ(ground.source(), GroundSource::classified);
    EXPECT_NEAR(at(ground, 20, 20), dam(20, 20), 0.01) << int{point_class};
    EXPECT_NEAR(at(ground, 10, 20), dam(10, 20), 0.01) << int{point_class};
  }
  Site site;
  site.scatter(4000, 40, plane, 11);
  EXPECT_EQ(site.ground().source(), GroundSource::lowest) << "roads alone are no classified ground";
}

TEST(GroundTest, planes_are_exact_where_cells_have_points) {
  Site site;
  site.scatter(20000, 40, plane, 2);
  const Ground ground = site.ground({.cell_size = 1.0});
  for (double x = 3; x < 38; x += 3.7) EXPECT_NEAR(at(ground, x, 41 - x), plane(x, 41 - x), 0.001);
}

TEST(GroundTest, points_whose_neighbours_are_in_no_cell_beside_theirs_count) {
  Site site;
  const auto roof = [](double x, double) { return 500.0 + 2.0 * std::fabs(x - 20.0); };
  for (int i = 0; i < 20 * 20; ++i) {
    const double x = 1.0 + 2.0 * (i % 20), y = 1.0 + 2.0 * (i / 20);
    site.add(x, y, roof(x, y), 2);
  }
  const Ground ground = site.ground({.cell_size = 0.5});
  EXPECT_EQ(ground.measured_cells(), 400u);
  for (int i = 0; i < 20; ++i) EXPECT_NEAR(at(ground, 1.0 + 2.0 * i, 21.0), roof(1.0 + 2.0 * i, 0), 1.2) << i;
}

TEST(GroundTest, lowest_points_are_the_ground_below_trees) {
  Site site;
  site.scatter(
      8000, 40, [](double x, double y) { return plane(x, y) + 12.0; }, 0);
  site.scatter(8000, 40, plane, 0);
  const Ground ground = site.ground();
  EXPECT_EQ(ground.source(), GroundSource::lowest);
  for (double x = 3; x < 38; x += 3.7) EXPECT_NEAR(at(ground, x, 41 - x), plane(x, 41 - x), 0.05);
}

TEST(GroundTest, a_lone_echo_far_below_does_not_count) {
  Site site;
  site.scatter(8000, 40, plane, 0);
  site.add(20, 20, 480, 0);
  EXPECT_NEAR(at(site.ground(), 20, 20), plane(20, 20), 0.1);
}

TEST(GroundTest, beside_a_lone_echo_the_next_point_of_its_cell_counts) {
  // So few points that one leaf holds them all, from the bottom up: the echo comes after the raised one below.
  Site site;
  for (int i = 0; i < 9; ++i) site.add(0.5 + i % 3, 0.5 + i / 3, i == 4 ? 500.9 : 500.0, 0);
  site.add(1.5, 1.5, 504.0, 0);
  EXPECT_NEAR(at(site.ground({.source = GroundSource::highest, .cell_size = 1.0}), 1.5, 1.5), 500.9, 1e-6);
}

TEST(GroundTest, highest_points_are_roofs_and_crowns) {
  const auto roof = [](double x, double y) { return plane(x, y) + 8.0 + 0.6 * x; };
  Site site;
  site.scatter(8000, 40, plane, 2);
  Random random("roof");
  for (int i = 0; i < 16000; ++i) {
    const double x = random.between(10, 30), y = random.between(10, 30);
    site.add(x, y, roof(x, y), 6);
  }
  site.add(20, 20, 560, 0);  // a bird
  const Ground ground = site.ground({.source = GroundSource::highest});
  EXPECT_EQ(ground.source(), GroundSource::highest);
  for (double x = 12; x < 28; x += 1.7) EXPECT_NEAR(at(ground, x, 40 - x), roof(x, 40 - x), 0.05) << x;
  for (double x = 1; x < 8; x += 1.7) EXPECT_NEAR(at(ground, x, 20), plane(x, 20), 0.05) << x;
}

TEST(GroundTest, the_foot_of_a_cliff_does_count) {
  const auto cliff = [](double x, double) { return x < 20 ? 500.0 : 530.0; };
  Site site;
  site.scatter(20000, 40, cliff, 0);
  const Ground ground = site.ground();
  EXPECT_NEAR(at(ground, 17, 20), 500.0, 0.01);
  EXPECT_NEAR(at(ground, 23, 20), 530.0, 0.01);
}

TEST(GroundTest, gaps_below_roofs_are_closed_by_what_is_around) {
  const auto in_house = [](double x, double y) { return x > 10 && x < 30 && y > 10 && y < 30; };
  Site site;
  Random random;
  for (int i = 0; i < 20000; ++i) {
    const double x = random.between(0, 40), y = random.between(0, 40);
    site.add(x, y, in_house(x, y) ? 520.0 : plane(x, y), in_house(x, y) ? 6 : 2);
  }
  const Ground ground = site.ground();
  EXPECT_NEAR(at(ground, 20, 20), plane(20, 20), 0.15);
  EXPECT_NEAR(at(ground, 12, 28), plane(12, 28), 0.1);
  EXPECT_LT(ground.measured_cells(), ground.heights().grid.size());
}

TEST(GroundTest, there_is_no_ground_beyond_the_reach_of_the_cloud) {
  Site site;
  site.scatter(4000, 10, plane, 2);
  site.add(100, 100, 500, 2);
  const Ground ground = site.ground({.reach = 5.0});
  EXPECT_FALSE(std::isnan(at(ground, 14, 5)));
  EXPECT_TRUE(std::isnan(at(ground, 50, 50)));
  EXPECT_TRUE(ground.at({k_east - 4, k_north}));
  EXPECT_FALSE(ground.at({k_east - 20, k_north}));
  EXPECT_FALSE(ground.at({k_east, std::numeric_limits<double>::quiet_NaN()}));
}

TEST(GroundTest, gaps_and_what_lies_beyond_the_points_were_not_scanned) {
  // Ground with a pond of 6 x 6 that gave no echo, and a house of 6 x 6.
  Site site;
  Random random;
  for (int i = 0; i < 40000; ++i) {
    const double x = random.between(0, 30), y = random.between(0, 30);
    const bool is_pond = x > 5 && x < 11 && y > 5 && y<11, is_house = x> 18 && x < 24 && y > 18 && y < 24;
    if (!is_pond) site.add(x, y, is_house ? 520.0 : plane(x, y), is_house ? 6 : 2);
  }
  const auto scanned = [](const Ground& ground, double x, double y) {
    return ground.is_scanned({k_east + x, k_north + y});
  };
  const Ground ground = site.ground();
  EXPECT_FALSE(std::isnan(at(ground, 8, 8))) << "observers find the ground in the gap";
  EXPECT_FALSE(scanned(ground, 8, 8));
  EXPECT_TRUE(scanned(ground, 21, 21)) << "below the roof";
  EXPECT_FALSE(scanned(ground, -3, 15));
  EXPECT_FALSE(scanned(ground, std::numeric_limits<double>::quiet_NaN(), 15));
  for (double x = 0.1; x < 30.0; x += 0.7) {
    EXPECT_TRUE(scanned(ground, x, 2.0)) << x;
    EXPECT_TRUE(scanned(ground, x, 28.0)) << x;
  }
  const glm::dvec2 corner(k_east, k_north);
  EXPECT_NEAR(unscanned_length(ground, corner + glm::dvec2(1, 8), corner + glm::dvec2(29, 8)), 4.0, 0.8)
      << "the pond without its rim";
  EXPECT_EQ(unscanned_length(ground, corner + glm::dvec2(1, 2), corner + glm::dvec2(29, 2)), 0.0);
  EXPECT_NEAR(unscanned_length(ground, corner + glm::dvec2(29, 2), corner + glm::dvec2(129, 2)), 99.0, 2.0);
  EXPECT_EQ(unscanned_length(ground, corner, corner), 0.0);
  EXPECT_TRUE(scanned(site.ground({.scanned_reach = 4.0}), 8, 8));
  EXPECT_FALSE(scanned(site.ground({.reach = 0.0}), 5.6, 8)) << "not beyond the reach";
  EXPECT_THROW(site.ground({.scanned_reach = -1.0}), Error);
}

TEST(GroundTest, of_a_raster_was_scanned_where_its_cells_have_heights) {
  Raster<float> heights({{0.0, 4.0}, 1.0, 4, 4}, 7.0f);
  heights.at(1, 1) = std::numeric_limits<float>::quiet_NaN();
  auto terrain = std::make_shared<const Ground>(TerrainSurface(heights));
  EXPECT_TRUE(terrain->at({1.9, 2.5})) << "from the cell beside";
  EXPECT_FALSE(terrain->is_scanned({1.9, 2.5}));
  EXPECT_TRUE(terrain->is_scanned({2.1, 2.5}));
  EXPECT_TRUE(terrain->is_scanned({0.0, 0.0}));
  EXPECT_FALSE(terrain->is_scanned({-0.1, 0.0}));
  Site site;
  site.scatter(100, 1, plane, 2);
  Ground points = site.ground();
  points.raise_to(terrain);
  EXPECT_TRUE(points.is_scanned({2.1, 2.5}));
  EXPECT_TRUE(points.is_scanned({k_east + 0.5, k_north + 0.5}));
  EXPECT_FALSE(points.is_scanned({1.9, 2.5}));
}

TEST(GroundTest, bad_wishes_are_errors) {
  Site site;
  EXPECT_THROW(site.ground(), Error);
  site.scatter(100, 10, plane, 0);
  EXPECT_THROW(site.ground({.source = GroundSource::classified}), Error);
  EXPECT_THROW(site.ground({.cell_size = 0.0}), Error);
  EXPECT_THROW(site.ground({.cell_size = 1e-6}), Error);
  EXPECT_THROW(site.ground({.reach = -1.0}), Error);
  EXPECT_THROW(site.ground({.progress = [](std::uint64_t, std::uint64_t) { return false; }}), Cancelled);
}

TEST(GroundTest, one_line_of_points_has_ground) {
  Site site;
  for (int i = 0; i < 100; ++i) site.add(i, 0, 500, 0);
  EXPECT_NEAR(at(site.ground(), 50, 0), 500, 1e-9);
}

TEST(FillGapsTest, a_gap_in_a_harmonic_surface_is_closed_by_it) {
  // x^2 - y^2 is harmonic, and so is its five-point difference.
  Raster<double> raster({{0, 0}, 1.0, 200, 150}, 0.0);
  Raster<double> truth = raster;
  for (int row = 0; row < 150; ++row) {
    for (int column = 0; column < 200; ++column) {
      const double x = (column - 90) / 50.0, y = (row - 70) / 50.0;
      truth.at(column, row) = x * x - y * y + x;
      const bool gap = column > 40 && column < 160 && row > 30 && row < 120;
      raster.at(column, row) = gap ? std::numeric_limits<double>::quiet_NaN() : truth.at(column, row);
    }
  }
  fill_gaps(raster);
  double largest = 0.0;
  for (std::size_t i = 0; i < truth.values.size(); ++i)
    largest = std::max(largest, std::fabs(raster.values[i] - truth.values[i]));
  EXPECT_LT(largest, 0.02);
}

TEST(FillGapsTest, values_stay_and_nothing_comes_from_nothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Raster<double> raster({{0, 0}, 1.0, 3, 1}, nan);
  fill_gaps(raster);
  EXPECT_TRUE(std::isnan(raster.values[1]));
  raster.values[2] = 5.0;
  fill_gaps(raster);
  EXPECT_EQ(raster.values, (HugeVector<double>{5.0, 5.0, 5.0}));
}

}  // namespace
}  // namespace alidade::test
