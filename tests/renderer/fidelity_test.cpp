// SPDX-License-Identifier: MIT
// Pictures of scans against pictures of the site that was scanned. docs/fidelity.md has the whole table.
#include "tests/support/fidelity.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "renderer/render.h"
#include "simulation/scan.h"

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
  return test::fidelity(*scene.camera, truth, test::picture_of(scene, cloud), 0.0);
}

TEST(Fidelity, of_each_surface_stays_as_good_as_it_is) {
  const image::Film truth = test::exact_picture(flat_yard());
  LoadedCloud cloud = index_cloud(test::courtyard_cloud({.points = 300'000}), simulation::scan_attributes(),
                                  CloudSettings{}, "scan");
  const Fidelity sphere = fidelity_of(PointShape::sphere, truth, cloud);
  const Fidelity disc = fidelity_of(PointShape::disc, truth, cloud);
  const Fidelity blend = fidelity_of(PointShape::blend, truth, cloud);
  // Half as much again as measured.
  EXPECT_LT(blend.depth_median, 0.005);
  EXPECT_LT(disc.depth_median, 0.0075);
  EXPECT_LT(blend.flip, disc.flip);
  EXPECT_LT(disc.flip, sphere.flip);
  EXPECT_LT(blend.grown, 0.6 * sphere.grown);
}

TEST(Fidelity, of_the_truth_to_itself_is_perfect) {
  const Scene scene = flat_yard();
  const image::Film truth = test::exact_picture(scene);
  const Fidelity same = test::fidelity(*scene.camera, truth, truth, 0.0);
  EXPECT_EQ(same.depth_p95, 0.0);
  EXPECT_EQ(same.grown, 0.0);
  EXPECT_EQ(same.holes, 0.0);
  EXPECT_EQ(same.flip, 0.0);
  EXPECT_NEAR(same.ssim, 1.0, 1e-6);
}

TEST(Model, is_met_where_the_site_is) {
  Scene scene = flat_yard();
  scene.objects.emplace_back(Model{test::exact_courtyard()});
  const World world(scene, nullptr);
  const simulation::Site& site = test::exact_courtyard()->site();
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
