// SPDX-License-Identifier: MIT
#include "renderer/render.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <glm/geometric.hpp>

#include "tests/renderer/tracer_scenes.h"

namespace alidade {
namespace {

/// A little of everything.
Scene mixed_scene() {
  Scene scene;
  scene.camera = pinhole_from_fov(70, 50, 50.0, look_at({0, -6, 3}, {0, 0, 0.5}));
  scene.render = {.samples = 5, .max_bounces = 6, .seed = 42};
  scene.sun.emplace();
  scene.cloud.emplace();
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.4f)}}, Sphere{{2, 0, 1}, 0.7, Dielectric{1.5}},
                   Sphere{{-2, 0, 1}, 0.7, Metal{Rgb(0.9f), 0.3}},
                   Sphere{{0, 1, 3}, 0.3, Emissive{Rgb(5.0f)}}};
  return scene;
}

LoadedCloud mixed_cloud() {
  test::Random random("mixed cloud");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 3000; ++i) positions.push_back(random.in_cube() + glm::dvec3(0, 0, 1));
  return test::loaded(positions, 0.06);
}

void expect_same(const Film& a, const Film& b) {
  EXPECT_EQ(a.color, b.color);
  EXPECT_EQ(a.alpha, b.alpha);
  EXPECT_EQ(a.variance, b.variance);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.albedo, b.albedo);
  EXPECT_EQ(a.id, b.id);
}

TEST(Render, film_does_not_depend_on_the_number_of_threads) {
  const LoadedCloud cloud = mixed_cloud();
  for (const NormalMode normals : {NormalMode::sphere, NormalMode::smooth}) {
    Scene scene = mixed_scene();
    scene.cloud->normals = normals;
    Film films[3];
    RenderStatistics statistics[3];
    for (int threads = 1; threads <= 3; ++threads) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      films[threads - 1] = render(scene, &cloud, {}, &statistics[threads - 1]);
    }
    expect_same(films[0], films[1]);
    expect_same(films[0], films[2]);
    EXPECT_EQ(statistics[0].ray_count, statistics[1].ray_count);
    EXPECT_GT(statistics[0].ray_count, 70u * 50 * 5);
  }
}

TEST(Render, film_does_not_depend_on_the_instruction_set) {
  test::Random random("mixed cloud");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 3000; ++i) positions.push_back(random.in_cube() + glm::dvec3(0, 0, 1));
  const PointCloud points = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)});
  LoadedCloud cloud = mixed_cloud();
  const Film best = render(mixed_scene(), &cloud);
  for (const InstructionSet set : available_instruction_sets()) {
    BuildOptions build_options;
    build_options.instruction_set = set;
    cloud.octree = build(points, build_options);
    SCOPED_TRACE(name(set));
    expect_same(render(mixed_scene(), &cloud), best);
  }
}

TEST(Render, another_seed_is_another_noise_around_the_same_picture) {
  const LoadedCloud cloud = mixed_cloud();
  Scene scene = mixed_scene();
  const Film a = render(scene, &cloud);
  scene.render.seed = 43;
  const Film b = render(scene, &cloud);
  EXPECT_NE(a.color, b.color);
  EXPECT_EQ(a.id, b.id);
  EXPECT_NEAR(test::image_mean(a).mean, test::image_mean(b).mean, 0.02 * test::image_mean(a).mean);
}

TEST(Render, layers_come_from_the_ray_through_the_pixels_centre) {
  const LoadedCloud cloud = test::loaded({{0, 0, 5}, {0, 0, 2}}, 1.0);
  Scene scene =
      test::dark_scene(pinhole_from_fov(3, 3, 90.0, look_at({0, 0, 10}, {0, 0, 0}, {0, 1, 0})), 2, 0);
  scene.cloud.emplace();
  scene.objects = {Sphere{{0, 100, 0}, 1.0}, GroundPlane{0.0, Lambertian{Rgb(0.25f)}}};
  const Film film = render(scene, &cloud);
  const std::size_t middle = film.index(1, 1), corner = film.index(0, 2);
  EXPECT_EQ(film.id[middle], 1u);
  EXPECT_NEAR(film.depth[middle], 4.0f, 1e-6f);
  EXPECT_NEAR(film.distance[middle], 4.0f, 1e-6f);
  EXPECT_NEAR(glm::length(film.normal[middle] - glm::vec3(0, 0, 1)), 0.0f, 1e-6f);
  EXPECT_NEAR(glm::length(film.position[middle] - glm::dvec3(0, 0, 6)), 0.0, 1e-9);
  EXPECT_EQ(film.albedo[middle], Rgb(0.95f));
  EXPECT_EQ(film.alpha[middle], 1.0f);
  // The corner pixel looks down at slopes of 2/3 on both axes and meets the plane; objects count down from
  // the largest id.
  EXPECT_EQ(film.id[corner], 4294967294u);
  EXPECT_NEAR(film.depth[corner], 10.0f, 1e-5f);
  EXPECT_NEAR(film.distance[corner], 10.0 * std::sqrt(1.0 + 8.0 / 9.0), 1e-5);
  EXPECT_NEAR(glm::length(film.position[corner] - glm::dvec3(-20.0 / 3, -20.0 / 3, 0)), 0.0, 1e-9);
  EXPECT_EQ(film.albedo[corner], Rgb(0.25f));
}

TEST(Render, a_pixel_that_sees_nothing_has_the_values_of_nothing) {
  Scene scene = test::dark_scene(test::camera_at({0, 0, 0}, {0, 1, 0}, 30.0, 2), 3, 2);
  scene.sky = ConstantSky{Rgb(0.5f)};
  const Film film = render(scene, nullptr);
  for (std::size_t pixel = 0; pixel < 4; ++pixel) {
    EXPECT_EQ(film.color[pixel], Rgb(0.5f));
    EXPECT_EQ(film.alpha[pixel], 0.0f);
    EXPECT_EQ(film.variance[pixel], Rgb(0.0f));
    EXPECT_EQ(film.depth[pixel], INFINITY);
    EXPECT_EQ(film.distance[pixel], INFINITY);
    EXPECT_EQ(film.normal[pixel], glm::vec3(0.0f));
    EXPECT_EQ(film.id[pixel], 0u);
  }
}

TEST(Render, normals_in_the_film_face_the_camera) {
  Scene scene = test::dark_scene(test::camera_at({0, 0, 0}, {0, 1, 0}, 30.0, 3), 1, 0);
  scene.objects = {Sphere{glm::dvec3(0.0), 2.0}};
  EXPECT_NEAR(render(scene, nullptr).normal[4].y, -1.0f, 1e-6f);
}

TEST(Render, variance_is_the_squared_standard_error_of_the_mean) {
  // Two renders of one pixel per seed: the spread of the means is what each claims.
  Scene scene = test::dark_scene(test::camera_at({0, 0, 0.5}, {0, 0, 0}, 10.0, 64), 1, 0);
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(1.0f)}}};
  scene.sky = GradientSky{Rgb(0.0f), Rgb(1.0f)};
  scene.render.samples = 1;
  const Film single = render(scene, nullptr);
  double mean = 0.0, squares = 0.0;
  for (const Rgb& color : single.color) mean += color.r / single.color.size();
  for (const Rgb& color : single.color) squares += (color.r - mean) * (color.r - mean) / single.color.size();
  for (const Rgb& variance : single.variance) ASSERT_EQ(variance, Rgb(0.0f));
  scene.render.samples = 16;
  double claimed = 0.0;
  for (const Rgb& variance : render(scene, nullptr).variance) claimed += variance.r / single.variance.size();
  // Samples of a pixel lie more evenly than independent ones: the estimate is a little above, never below.
  EXPECT_NEAR(claimed * 16.0, squares, 0.1 * squares);
}

TEST(Render, progress_grows_to_the_total_and_can_stop_the_work) {
  const LoadedCloud cloud = mixed_cloud();
  std::uint64_t last = 0, last_total = 0;
  RenderOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last);
    last = done;
    last_total = total;
    return true;
  };
  render(mixed_scene(), &cloud, options);
  EXPECT_EQ(last, 70u * 50 * 5);
  EXPECT_EQ(last_total, last);
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(render(mixed_scene(), &cloud, options), Cancelled);
}

TEST(Render, progress_comes_within_a_pixel_of_many_samples_too) {
  Scene scene = test::dark_scene(test::camera_at({0, 0, 1}, {0, 0, 0}, 30.0, 1), 100'000, 0);
  std::vector<std::uint64_t> reports;
  RenderOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t) {
    reports.push_back(done);
    return false;
  };
  EXPECT_THROW(render(scene, nullptr, options), Cancelled);
  ASSERT_FALSE(reports.empty());
  EXPECT_LT(reports.front(), 10'000u);
}

TEST(Render, a_scene_that_cannot_be_rendered_is_an_error) {
  Scene scene = mixed_scene();
  scene.camera.reset();
  EXPECT_THROW(render(scene, nullptr), Error);
  scene = mixed_scene();
  scene.render.samples = 0;
  EXPECT_THROW(render(scene, nullptr), Error);
}

}  // namespace
}  // namespace alidade
