// SPDX-License-Identifier: MIT
// A car drove away between two scans: what a comparison of two renders from one camera makes of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>

#include "camera/camera.h"
#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "compare/change_regions.h"
#include "compare/difference_map.h"
#include "renderer/render.h"
#include "simulation/courtyard.h"

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;
using namespace compare;
using namespace simulation;

namespace {

constexpr std::uint8_t k_car_class = 64;
/// The middle of the car that drives away, in the site's frame. The car is about 4.4 m long.
constexpr glm::dvec3 k_car_position(11.6, -9.0, 0.7);

/// The courtyard without that car.
Site without_car(const Site& full) {
  std::vector<SiteObject> objects;
  for (const SiteObject& object : full.objects()) {
    const Bounds box = shapes::bounds_of(object.shape);
    const bool is_small = glm::length(box.max - box.min) < 8.0;
    if (!(is_small && glm::length(box.center() - k_car_position) < 2.6)) objects.push_back(object);
  }
  return Site(std::move(objects), full.origin());
}

std::filesystem::path scanned(const Site& site, const std::string& name, std::uint64_t seed) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / name;
  LasWriteOptions options;
  options.overwrite = true;
  LasWriter writer(file, scan_header(site), scan_attributes(), options);
  scan(site, courtyard_scan(600000, seed), [&](const PointCloud& batch) { writer.write(batch); });
  writer.finish();
  return file;
}

ComparedImage seen(const std::filesystem::path& cloud) {
  Scene scene;
  scene.cloud.emplace();
  scene.cloud->files = {cloud};
  scene.sky = ConstantSky{Rgb(1.0f)};
  scene.render.samples = 4;
  scene.render.max_bounces = 1;
  const glm::dvec3 eye(690023.0, 5324984.8, 606.8), target(689995.0, 5325002.5, 601.2);
  scene.camera = pinhole_from_fov(360, 240, 56.0, look_at(eye, target));
  const LoadedCloud loaded = load_cloud(*scene.cloud);
  const Film film = render(scene, &loaded);
  ComparedImage image;
  image.file = cloud;
  image.width = film.width;
  image.height = film.height;
  image.encoding = ColorEncoding::linear;
  image.color_channels = 3;
  for (const auto& color : film.color) image.color.insert(image.color.end(), {color[0], color[1], color[2]});
  image.depth = film.depth;
  image.ids = film.id;
  return image;
}

/// Both scans and their images from one camera. The noise of the second scan has its own seed.
struct TwoScans {
  Site site = courtyard();
  std::filesystem::path before = scanned(site, "with_car.las", 1),
                        after = scanned(without_car(site), "without_car.las", 2);
  ComparedImage reference = seen(before), test = seen(after);
};

const TwoScans& two_scans() {
  static const TwoScans scans;
  return scans;
}

/// Share of the points that are bodywork and wheels of a car.
double share_of_car(const PointCloud& points) {
  const auto count = std::ranges::count(points.classifications, k_car_class);
  return static_cast<double>(count) / static_cast<double>(points.size());
}

void expect_the_car(const ChangeRegions& changes) {
  ASSERT_EQ(changes.regions.size(), 1u);
  const ChangeRegion& region = changes.regions[0];
  EXPECT_GT(region.pixels, 1500u);
  EXPECT_LT(region.pixels, 3000u);
  // The region contains the pixel at which the camera saw the car.
  EXPECT_LT(region.left, 165);
  EXPECT_GT(region.right, 165);
  EXPECT_LT(region.top, 190);
  EXPECT_GT(region.bottom, 190);

  const TwoScans& scans = two_scans();
  const PointCloud before = read_cloud(scans.before), after = read_cloud(scans.after);
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "car.las";
  const std::vector<RegionPoint> points = region_points(scans.reference.ids, changes, before.size());
  write_las(file, points_of_regions(before, points), {.overwrite = true});
  const PointCloud car = read_cloud(file);
  EXPECT_GT(car.size(), 350u);
  EXPECT_GT(share_of_car(car), 0.75);
  const glm::dvec3 position = scans.site.origin() + k_car_position;
  // The rest are its lamps and mirrors, and what is seen beside it within a pixel.
  for (std::size_t i = 0; i < car.size(); ++i) ASSERT_LT(glm::length(car.world(i) - position), 4.5);
  // The points there now are those of what was below and behind it.
  const PointCloud now = points_of_regions(after, region_points(scans.test.ids, changes, after.size()));
  EXPECT_GT(now.size(), 100u);
  EXPECT_EQ(share_of_car(now), 0.0);
}

TEST(RemovedCar, is_found_in_the_colours_as_one_region_with_its_points) {
  const DifferenceMap map = color_difference(two_scans().reference, two_scans().test, {});
  expect_the_car(change_regions(map.values, map.width, {}, {.threshold = 0.2, .least_pixels = 50}));
}

TEST(RemovedCar, is_found_in_the_depth_as_one_region_with_its_points) {
  const DifferenceMap map = depth_difference(two_scans().reference, two_scans().test, {});
  const ChangeRegions changes =
      change_regions(map.values, map.width, {}, {.threshold = 0.3, .least_pixels = 50});
  expect_the_car(changes);
  EXPECT_GT(changes.regions[0].mean, 0.5);
}

TEST(RemovedCar, of_two_scans_that_both_have_it_there_is_no_region) {
  const TwoScans& scans = two_scans();
  const ComparedImage again = seen(scanned(scans.site, "with_car_again.las", 3));
  const DifferenceMap color = color_difference(scans.reference, again, {}),
                      depth = depth_difference(scans.reference, again, {});
  EXPECT_TRUE(
      change_regions(color.values, color.width, {}, {.threshold = 0.2, .least_pixels = 50}).regions.empty());
  EXPECT_TRUE(
      change_regions(depth.values, depth.width, {}, {.threshold = 0.3, .least_pixels = 50}).regions.empty());
}

}  // namespace
}  // namespace alidade::test
