// SPDX-License-Identifier: MIT
#include "renderer/integrator.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/renderer/tracer_scenes.h"
#include "tests/support/random.h"

namespace alidade {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

using test::camera_at;
using test::dark_scene;
using test::expect_everywhere;

constexpr RenderMode k_quick_modes[] = {RenderMode::ambient_occlusion, RenderMode::headlight,
                                        RenderMode::flat};

Scene scene_in(RenderMode mode, const Camera& camera, int samples) {
  Scene scene = dark_scene(camera, samples, 8);
  scene.render.mode = mode;
  return scene;
}

TEST(Flat, shows_the_albedo_of_everything_and_the_radiance_of_what_shines) {
  Scene scene = scene_in(RenderMode::flat, camera_at({0, 0, 5}, {0, 0, 0}, 10.0), 4);
  for (const auto& [material, color] : {std::pair{Material(Lambertian{Rgb(0.3f)}), 0.3},
                                        {Material(Metal{Rgb(0.6f), 0.1}), 0.6},
                                        {Material(Dielectric{1.5}), 1.0},
                                        {Material(Emissive{Rgb(4.0f)}), 4.0}}) {
    scene.objects = {GroundPlane{0.0, material}};
    expect_everywhere(render(scene, nullptr), color);
  }
  const LoadedCloud cloud = test::loaded({{0, 0, 0}}, 3.0);
  scene.objects.clear();
  scene.cloud.emplace();
  expect_everywhere(render(scene, &cloud), 0.95, 1e-6);  // the brightest point there is
}

TEST(Flat, is_black_and_transparent_where_nothing_is) {
  Scene scene = scene_in(RenderMode::flat, camera_at({0, 0, 5}, {0, 0, 9}, 10.0), 4);
  scene.sky = ConstantSky{Rgb(1.0f)};
  scene.sun.emplace();
  const Film film = render(scene, nullptr);
  for (const float alpha : film.alpha) EXPECT_EQ(alpha, 0.0f);
  expect_everywhere(film, 0.0);
}

TEST(Headlight, is_colour_times_cosine_between_normal_and_ray) {
  // Parallel rays 60 degrees off the normal of the plane, whatever blocks other lights.
  Camera camera = camera_at({0, -std::sqrt(3.0), 1.0}, {0, 0, 0}, 10.0);
  camera.lens = OrthographicLens{};
  camera.fx = camera.fy = 1000.0;
  Scene scene = scene_in(RenderMode::headlight, camera, 4);
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.8f)}}, Sphere{{0, 0, 50}, 40.0, Lambertian{Rgb(0.5f)}}};
  expect_everywhere(render(scene, nullptr), 0.8 * 0.5);
}

TEST(QuickModes, show_the_sky_behind_a_cloud_and_what_shines_as_it_is) {
  for (const RenderMode mode : {RenderMode::ambient_occlusion, RenderMode::headlight}) {
    Scene scene = scene_in(mode, camera_at({0, 0, 5}, {0, 0, 9}, 10.0), 4);
    scene.sky = ConstantSky{Rgb(0.6f)};
    const Film film = render(scene, nullptr);
    expect_everywhere(film, 0.6);
    for (const float alpha : film.alpha) EXPECT_EQ(alpha, 0.0f);
    scene.objects = {Sphere{{0, 0, 20}, 10.0, Emissive{Rgb(5.0f)}}};
    expect_everywhere(render(scene, nullptr), 5.0);
  }
}

/// A floor with a wall of spheres' height: a plane under one large sphere, straight below its centre. Of the
/// hemisphere over the plane, weighted by the cosine, a sphere of radius r at distance d overhead hides
/// (r / d)^2.
Scene below_a_sphere(double ao_distance) {
  Scene scene = scene_in(RenderMode::ambient_occlusion, camera_at({0, 0, 0.5}, {0, 0, 0}, 0.5, 4), 1024);
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}, Sphere{{0, 0, 3}, 1.0, Lambertian{Rgb(0.0f)}}};
  scene.render.ao_distance = ao_distance;
  return scene;
}

TEST(AmbientOcclusion, is_colour_times_the_free_share_of_the_hemisphere) {
  test::expect_mean(render(below_a_sphere(1000.0), nullptr), 0.5 * (1.0 - 1.0 / 9.0));
}

TEST(AmbientOcclusion, ends_at_its_distance) {
  // The sphere begins 2 above the plane, and its visible rim is sqrt(8) away.
  expect_everywhere(render(below_a_sphere(1.999), nullptr), 0.5);
  test::expect_mean(render(below_a_sphere(2.83), nullptr), 0.5 * (1.0 - 1.0 / 9.0));
  const double between = test::image_mean(render(below_a_sphere(2.2), nullptr)).mean;
  EXPECT_LT(between, 0.5 - 0.01);
  EXPECT_GT(between, 0.5 * (1.0 - 1.0 / 9.0) + 0.01);
}

TEST(AmbientOcclusion, by_points_ends_within_a_radius_of_its_distance) {
  const LoadedCloud cloud = test::loaded({{0, 0, 3}}, 1.0);
  Scene scene = below_a_sphere(1.99);
  scene.objects.pop_back();
  scene.cloud.emplace();
  expect_everywhere(render(scene, &cloud), 0.5);
  scene.render.ao_distance = 3.01;
  test::expect_mean(render(scene, &cloud), 0.5 * (1.0 - 1.0 / 9.0));
}

TEST(AmbientOcclusion, is_open_on_a_lone_sphere_and_a_lone_point) {
  Scene scene = scene_in(RenderMode::ambient_occlusion, camera_at({0, 0, 5}, {0, 0, 0}, 10.0), 16);
  scene.objects = {Sphere{{0, 0, 0}, 3.0, Lambertian{Rgb(0.5f)}}};
  expect_everywhere(render(scene, nullptr), 0.5);
  scene.objects.clear();
  const LoadedCloud cloud = test::loaded({{0, 0, 0}}, 3.0);
  scene.cloud.emplace();
  for (const NormalMode normals : {NormalMode::sphere, NormalMode::smooth}) {
    scene.cloud->normals = normals;
    expect_everywhere(render(scene, &cloud), 0.95);
  }
}

TEST(AmbientOcclusion, is_closed_inside_a_ball) {
  Scene scene = scene_in(RenderMode::ambient_occlusion, camera_at({0, 0, 0}, {0, 0, 1}, 40.0), 16);
  scene.objects = {Sphere{{0, 0, 0}, 2.0, Lambertian{Rgb(0.5f)}}};
  scene.render.ao_distance = 10.0;
  expect_everywhere(render(scene, nullptr), 0.0);
  // Rays from the wall to the wall are at most a diameter long; none is shorter than 0.
  scene.render.ao_distance = 1e-6;
  EXPECT_GT(test::image_mean(render(scene, nullptr)).mean, 0.499);
}

TEST(AmbientOcclusion, distance_is_a_twentieth_of_the_cloud_by_default) {
  RenderSettings settings{.mode = RenderMode::ambient_occlusion, .ao_distance = {}};
  EXPECT_TRUE(std::isinf(ambient_occlusion_distance(settings, nullptr)));
  const LoadedCloud cloud = test::loaded({{0, 0, 0}, {30, 40, 0}}, 1e-3);
  EXPECT_NEAR(ambient_occlusion_distance(settings, &cloud), 2.5, 0.01);
  settings.ao_distance = 7.0;
  EXPECT_EQ(ambient_occlusion_distance(settings, &cloud), 7.0);
}

TEST(QuickModes, film_does_not_depend_on_the_number_of_threads_and_layers_are_those_of_paths) {
  test::Random random;
  std::vector<glm::dvec3> heap;
  for (int i = 0; i < 3000; ++i) heap.push_back(random.in_cube());
  const LoadedCloud cloud = test::loaded(heap, 0.06);
  for (const RenderMode mode : k_quick_modes) {
    Scene scene = scene_in(mode, pinhole_from_fov(50, 40, 50.0, look_at({0, -6, 3}, {0, 0, 0})), 5);
    scene.sky = GradientSky{};
    scene.cloud.emplace();
    scene.objects = {GroundPlane{-1.0, Lambertian{Rgb(0.4f)}}};
    Film films[2];
    RenderStatistics statistics[2];
    for (const int threads : {1, 3}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(threads));
      films[threads / 2] = render(scene, &cloud, {}, &statistics[threads / 2]);
    }
    EXPECT_EQ(films[0].color, films[1].color);
    EXPECT_EQ(films[0].variance, films[1].variance);
    EXPECT_EQ(films[0].alpha, films[1].alpha);
    EXPECT_EQ(statistics[0].ray_count, statistics[1].ray_count);
    const std::uint64_t camera_rays = 50 * 40 * 5 + 50 * 40;
    EXPECT_GE(statistics[0].ray_count, camera_rays);
    EXPECT_LE(statistics[0].ray_count, 2 * camera_rays);
    scene.render.mode = RenderMode::path;
    const Film paths = render(scene, &cloud);
    EXPECT_EQ(films[0].id, paths.id);
    EXPECT_EQ(films[0].depth, paths.depth);
    EXPECT_EQ(films[0].normal, paths.normal);
    EXPECT_EQ(films[0].albedo, paths.albedo);
    EXPECT_EQ(films[0].alpha, paths.alpha);
    EXPECT_NE(films[0].color, paths.color);
  }
}

TEST(World, blocks_within_reach_only) {
  const LoadedCloud cloud = test::loaded({{0, 0, 10}}, 1.0);
  Scene scene;
  scene.cloud.emplace();
  scene.objects = {Sphere{{5, 0, 10}, 1.0, Lambertian{Rgb(0.5f)}}};
  const World world(scene, &cloud);
  const std::vector<Ray> rays{make_ray({0, 0, 0}, {0, 0, 1}, 0.0), make_ray({5, 0, 0}, {0, 0, 1}, 0.0),
                              make_ray({9, 0, 0}, {0, 0, 1}, 0.0)};
  const std::vector<RayOrigin> ray_origins(rays.size());
  const auto blocked = [&](double reach) {
    std::vector<std::uint8_t> answers(rays.size());
    world.blocked(rays, ray_origins, answers, reach);
    return answers;
  };
  EXPECT_EQ(blocked(8.9), (std::vector<std::uint8_t>{0, 0, 0}));
  EXPECT_EQ(blocked(9.1), (std::vector<std::uint8_t>{0, 1, 0}));
  EXPECT_EQ(blocked(10.1), (std::vector<std::uint8_t>{1, 1, 0}));
  std::vector<std::uint8_t> anywhere(rays.size());
  world.blocked(rays, ray_origins, anywhere);
  EXPECT_EQ(anywhere, (std::vector<std::uint8_t>{1, 1, 0}));
}

}  // namespace
}  // namespace alidade
