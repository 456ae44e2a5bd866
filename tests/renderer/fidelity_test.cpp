// SPDX-License-Identifier: MIT
// Images of scans against images of the site that was scanned. docs/reports/fidelity.md has the whole
// table.
#include "tests/support/fidelity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "renderer/render.h"
#include "renderer/world.h"
#include "simulation/scan.h"
#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace renderer;

namespace {

using test::Fidelity;

Scene flat_yard() {
  Scene scene = test::courtyard_light();
  scene.camera = test::fidelity_views(300)[0].camera;
  scene.render.mode = RenderMode::flat;
  scene.render.samples = 2;
  return scene;
}

Fidelity fidelity_of(PointShape shape, const image::Film& truth, LoadedCloud& cloud) {
  Scene scene = flat_yard();
  scene.cloud.emplace().shape = shape;
  choose_radius(*scene.cloud, cloud);
  return test::fidelity(*scene.camera, truth, test::image_of(scene, cloud), 0.0);
}

TEST(Fidelity, of_each_surface_stays_as_good_as_it_is) {
  const image::Film truth = test::exact_image(flat_yard());
  LoadedCloud cloud = index_cloud(test::courtyard_cloud({.points = 300'000}), simulation::scan_attributes(),
                                  CloudSettings{}, "scan");
  // A little worse than measured, so that any loss of quality is seen.
  struct Row {
    const char* name;
    PointShape shape;
    double depth_median, interior_p95, grown, holes, normal_median, flip, ssim;
  };
  for (const Row& most :
       {Row{"sphere", PointShape::sphere, 0.93, 2.46, 0.69, 0.001, 10.0, 0.245, 0.365},
        Row{"disc", PointShape::disc, 0.0034, 0.027, 0.083, 0.0165, 0.14, 0.151, 0.535},
        Row{"blend", PointShape::blend, 0.0022, 0.015, 0.080, 0.0170, 0.14, 0.126, 0.640}}) {
    SCOPED_TRACE(most.name);
    const Fidelity measured = fidelity_of(most.shape, truth, cloud);
    EXPECT_LT(measured.depth_median, most.depth_median);
    EXPECT_LT(measured.interior_p95, most.interior_p95);
    EXPECT_LT(measured.grown, most.grown);
    EXPECT_LT(measured.holes, most.holes);
    EXPECT_LT(measured.normal_median, most.normal_median);
    EXPECT_LT(measured.flip, most.flip);
    EXPECT_GT(measured.ssim, most.ssim);
  }
}

TEST(Fidelity, fewer_than_one_depth_in_a_hundred_is_wrong_by_more_than_three_sigma) {
  Scene scene = flat_yard();
  CloudSettings blend;
  blend.shape = PointShape::blend;
  scene.cloud = blend;
  scene.render.samples = 1;
  const std::vector<test::FidelityView> views = test::fidelity_views(180);
  std::vector<image::Film> truths;
  for (const test::FidelityView& view : views) {
    scene.camera = view.camera;
    truths.push_back(test::exact_image(scene));
  }
  for (const std::uint64_t points : {100'000u, 500'000u}) {
    const LoadedCloud cloud =
        index_cloud(test::courtyard_cloud({.points = points}), simulation::scan_attributes(), blend, "scan");
    for (std::size_t i = 0; i < views.size(); ++i) {
      scene.camera = views[i].camera;
      const Fidelity measured = test::fidelity(views[i].camera, truths[i], test::image_of(scene, cloud), 0.0);
      EXPECT_LT(measured.surprises, 0.0125) << views[i].name << " " << points;
      // Not by being unsure of everything.
      if (points == 500'000u) {
        EXPECT_LT(measured.sigma_median, 0.04) << views[i].name;
      }
    }
  }
}

TEST(Layers, of_a_scan_tell_how_sure_they_are) {
  // A floor that ends at x = 1, one point far above it, and a ball beside it.
  std::vector<glm::dvec3> points;
  for (int x = -20; x <= 20; ++x)
    for (int y = -20; y <= 20; ++y) points.emplace_back(0.05 * x, 0.05 * y, 0.0);
  const double focal = 10.0 / std::tan(glm::radians(30.0)), bird_x = -3.5 * 9.0 / focal,
               bird_y = 0.5 * 9.0 / focal;
  points.emplace_back(bird_x, bird_y, 1.0);  // in the middle of a pixel
  LoadedCloud cloud = test::loaded(points, 0.1, {glm::dvec3(1e-4), glm::dvec3(0)});
  Scene scene;
  scene.cloud.emplace().shape = PointShape::blend;
  choose_radius(*scene.cloud, cloud);
  scene.objects.emplace_back(Sphere{.center = {3.0, 0.0, 0.0}, .radius = 0.5});
  scene.camera = camera::pinhole_from_fov(80, 20, 60.0, camera::look_at({0.0, 0.0, 10.0}, {0.0, 0.001, 0.0}));
  scene.render.samples = 1;
  const image::Film film = render(scene, &cloud);
  const auto pixel_at = [&](double x, double y, double z) {
    const double scale = scene.camera->fx / (10.0 - z);
    return film.index(static_cast<int>(40.0 + scale * x), static_cast<int>(10.0 - scale * y));
  };
  const std::size_t floor = pixel_at(0.4, 0.0, 0.0), ball = pixel_at(3.0, 0.0, 0.5),
                    air = pixel_at(-4.0, 0.0, 0.0), rim = pixel_at(1.0, 0.0, 0.0),
                    bird = pixel_at(bird_x, bird_y, 1.0);
  EXPECT_LT(film.depth_sigma[floor], 0.005f);
  EXPECT_EQ(film.coverage[floor], 1.0f);
  EXPECT_GT(film.support[floor], 3u);
  EXPECT_EQ(film.depth_sigma[ball], 0.0f);
  EXPECT_EQ(film.coverage[ball], 0.0f);
  EXPECT_EQ(film.support[ball], 0u);
  EXPECT_TRUE(std::isinf(film.depth_sigma[air]));
  EXPECT_EQ(film.coverage[air] + static_cast<float>(film.support[air]), 0.0f);
  EXPECT_GT(film.coverage[rim], 0.0f);
  EXPECT_LT(film.coverage[rim], 1.0f);
  EXPECT_EQ(film.support[bird], 1u);
  EXPECT_GT(film.depth_sigma[bird], 0.5f) << "the floor may be seen past it";
}

TEST(Layers, coverage_is_the_share_of_16_rays_through_a_pixel_that_meet_the_cloud) {
  constexpr double k_x = 0.3, k_y = 0.1;
  const LoadedCloud cloud = test::loaded({{k_x, k_y, 0.0}}, 1.0);
  Scene scene;
  scene.cloud.emplace().shape = PointShape::sphere;
  scene.camera = camera::orthophoto_camera({{-2.0, -2.0, 0.0}, {2.0, 2.0, 2.0}}, 1.0);
  scene.render.samples = 1;
  const image::Film film = render(scene, &cloud);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      int met = 0;
      for (int i = 0; i < 16; ++i) {
        const double east = -2.0 + x + (i % 4 + 0.5) / 4.0 - k_x, north = 2.0 - y - (i / 4 + 0.5) / 4.0 - k_y;
        met += east * east + north * north < 1.0 ? 1 : 0;
      }
      EXPECT_EQ(film.coverage[film.index(x, y)], static_cast<float>(met) / 16.0f) << x << " " << y;
    }
  }
}

TEST(Layers, depths_just_beside_a_sheet_know_that_it_may_reach_there) {
  // A floor that ends at x = 1, and another one two metres below it.
  std::vector<glm::dvec3> points;
  for (int x = -40; x <= 40; ++x)
    for (int y = -20; y <= 20; ++y)
      for (const double z : {0.0, -2.0})
        if (z < 0.0 || x <= 20) points.emplace_back(0.05 * x, 0.05 * y, z);
  LoadedCloud cloud = test::loaded(points, 0.1, {glm::dvec3(1e-4), glm::dvec3(0)});
  Scene scene;
  scene.cloud.emplace().shape = PointShape::blend;
  choose_radius(*scene.cloud, cloud);
  scene.camera = camera::orthophoto_camera({{0.5, 0.0, -2.0}, {1.5, 0.01, 1.0}}, 0.01);
  scene.render.samples = 1;
  const image::Film film = render(scene, &cloud);
  int x = 0;
  while (x < 100 && film.depth[film.index(x, 0)] < 2.0f) ++x;
  ASSERT_GT(x, 45);
  ASSERT_LT(x, 60);
  EXPECT_GT(film.depth_sigma[film.index(x, 0)], 1.0f) << "the upper floor may be met";
  EXPECT_LT(film.depth_sigma[film.index(95, 0)], 0.05f);
}

TEST(Layers, nothing_nearer_than_the_near_distance_is_seen_of_any_surface) {
  // A floor, and another one two metres above it.
  std::vector<glm::dvec3> points;
  for (int x = -20; x <= 20; ++x)
    for (int y = -20; y <= 20; ++y)
      for (const double z : {0.0, 2.0}) points.emplace_back(0.05 * x, 0.05 * y, z);
  for (const PointShape shape : {PointShape::sphere, PointShape::disc, PointShape::blend}) {
    LoadedCloud cloud = test::loaded(points, 0.1, {glm::dvec3(1e-4), glm::dvec3(0)});
    Scene scene;
    scene.cloud.emplace().shape = shape;
    choose_radius(*scene.cloud, cloud);
    scene.camera = camera::pinhole_from_fov(3, 3, 10.0, camera::look_at({0.0, 0.0, 5.0}, {0.0, 0.001, 0.0}));
    scene.render.samples = 1;
    for (const double near : {0.0, 4.0}) {
      scene.camera->near = near;
      const image::Film film = render(scene, &cloud);
      EXPECT_NEAR(film.depth[film.index(1, 1)], near > 0.0 ? 5.0 : 3.0, 0.15) << static_cast<int>(shape);
    }
  }
}

TEST(Layers, depth_and_its_sigma_are_along_the_axis_of_the_camera) {
  // The middle of the right pixel looks along (0.6, 0.8, 0) at a sphere 5 away, whose sigma is its radius.
  const LoadedCloud cloud = test::loaded({{3.0, 4.0, 0.0}}, 0.1);
  Scene scene;
  scene.cloud.emplace().shape = PointShape::sphere;
  scene.camera = camera::Camera{
      .width = 3, .height = 1, .fx = 4.0 / 3.0, .fy = 4.0 / 3.0, .cx = 1.5, .cy = 0.5, .pose = {}};
  scene.render.samples = 1;
  const image::Film film = render(scene, &cloud);
  EXPECT_NEAR(film.distance[2], 4.9, 1e-6);
  EXPECT_NEAR(film.depth[2], 4.9 * 0.8, 1e-6);
  EXPECT_NEAR(film.depth_sigma[2], 0.1 * 0.8, 1e-7);
  // A panorama has no axis. A pixel looks 36 degrees and a bit from the one in the middle.
  const double angle = std::atan2(3.0, 4.0);
  scene.camera->lens = camera::EquirectangularLens{};
  scene.camera->fx = scene.camera->fy = 1.0 / angle;
  const image::Film around = render(scene, &cloud);
  EXPECT_NEAR(around.depth[2], 4.9, 1e-6);
  EXPECT_NEAR(around.depth_sigma[2], 0.1, 1e-7);
}

TEST(Fidelity, of_the_truth_to_itself_is_perfect) {
  const Scene scene = flat_yard();
  const image::Film truth = test::exact_image(scene);
  const Fidelity same = test::fidelity(*scene.camera, truth, truth, 0.0);
  EXPECT_EQ(same.depth_p95, 0.0);
  EXPECT_EQ(same.grown, 0.0);
  EXPECT_EQ(same.holes, 0.0);
  EXPECT_EQ(same.flip, 0.0);
  EXPECT_NEAR(same.ssim, 1.0, 1e-6);
}

TEST(Model, is_met_where_the_site_is) {
  Scene scene = flat_yard();
  scene.objects.emplace_back(Model{test::exact_courtyard(), "courtyard"});
  const World world(scene, nullptr);
  const simulation::Site& site = *test::exact_courtyard();
  for (int i = 0; i < 1000; ++i) {
    const double x = (i % 40 - 20) * 0.9, y = (i / 40 - 12) * 0.9;
    const Ray ray = make_ray(site.origin() + glm::dvec3(x, y, 40.0), {0.1, -0.05, -1.0}, 0.0);
    const auto met = world.nearest(ray, {});
    const auto expected = site.closest(ray);
    ASSERT_TRUE(met && expected);
    ASSERT_EQ(met->t, expected->t);
    const Surface surface = world.surface_at(ray, *met);
    ASSERT_EQ(surface.normal, expected->normal);
    // A ray that leaves it does not meet it again at once.
    const auto next = world.nearest(make_ray(surface.ray_origin, expected->normal, 0.0), met->leaving(false));
    ASSERT_TRUE(!next || next->t > 1e-5);
  }
}

}  // namespace
}  // namespace alidade
