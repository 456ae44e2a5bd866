// SPDX-License-Identifier: MIT
#include "renderer/integrator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tests/renderer/tracer_scenes.h"
#include "tests/support/random.h"

// Light with answers known on paper. The derivation is a comment of each scene.

namespace alidade {

using namespace geo;
using namespace image;
using namespace renderer;

namespace {

using test::camera_at;
using test::dark_scene;
using test::expect_everywhere;
using test::expect_mean;

constexpr int k_many_bounces = 10000;

/// The camera in the middle of a diffuse ball (radius 2) beside a small lamp in its centre (radius 0.5). Of
/// the light that leaves the wall the share f = (0.5 / 2)^2 meets the lamp and is gone, 1 - f meets the wall;
/// light of the lamp spreads evenly. So the wall's radiance is L f a (1 + a (1 - f) + ...) = L f a / (1 - a
/// (1 - f)): the furnace 1 / (1 - albedo) with an exit.
Scene furnace(float albedo, int max_bounces) {
  Scene scene = dark_scene(camera_at({0, 0, 1}, {0, 0, 2}, 90.0), 512, max_bounces);
  scene.objects = {Sphere{glm::dvec3(0.0), 2.0, Lambertian{Rgb(albedo)}},
                   Sphere{glm::dvec3(0.0), 0.5, Emissive{Rgb(3.0f)}}};
  return scene;
}
constexpr double k_lamp_share = 1.0 / 16.0;

TEST(Furnace, closed_ball_with_a_lamp_has_the_radiance_of_the_whole_series) {
  for (const float albedo : {0.2f, 0.5f, 0.9f}) {
    expect_mean(render(furnace(albedo, k_many_bounces), nullptr),
                3.0 * k_lamp_share * albedo / (1.0 - albedo * (1.0 - k_lamp_share)));
  }
}

TEST(Furnace, max_bounces_ends_the_series_after_as_many_vertices_behind_the_first) {
  for (const int max_bounces : {0, 1, 2, 5}) {
    double series = 0.0, term = 3.0 * k_lamp_share * 0.8;
    for (int bounce = 0; bounce <= max_bounces; ++bounce, term *= 0.8 * (1.0 - k_lamp_share)) series += term;
    expect_mean(render(furnace(0.8f, max_bounces), nullptr), series);
  }
}

TEST(Furnace, inside_an_even_lamp_a_ball_shows_its_albedo_times_the_lamp) {
  Scene scene = dark_scene(camera_at({0, 0, 3}, {0, 0, 0}, 20.0), 64, k_many_bounces);
  scene.objects = {Sphere{glm::dvec3(0.0), 10.0, Emissive{Rgb(2.0f)}},
                   Sphere{glm::dvec3(0.0), 1.0, Lambertian{Rgb(0.6f)}}};
  expect_mean(render(scene, nullptr), 1.2);
}

TEST(Furnace, what_reflects_everything_is_invisible_under_an_even_sky) {
  for (const Material& material :
       {Material(Lambertian{Rgb(1.0f)}), Material(Metal{Rgb(1.0f), 0.0}), Material(Dielectric{1.5})}) {
    Scene scene = dark_scene(camera_at({0, 0, 3}, {0, 0, 0}, 60.0, 32), 4, k_many_bounces);
    scene.sky = ConstantSky{Rgb(0.7f)};
    scene.objects = {Sphere{glm::dvec3(0.0), 1.0, material}, Sphere{{0.5, 0.4, 1.0}, 0.3, material}};
    expect_everywhere(render(scene, nullptr), 0.7);
  }
}

TEST(Furnace, a_heap_of_white_points_is_invisible_under_an_even_sky) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 500; ++i) positions.push_back(random.in_cube());
  const LoadedCloud cloud = test::loaded(positions, 0.15);
  for (const Material& material :
       {Material(Lambertian{Rgb(1.0f)}), Material(Metal{Rgb(1.0f), 0.0}), Material(Dielectric{1.5})}) {
    Scene scene = dark_scene(camera_at({0, 3, 3}, {0, 0, 0}, 40.0), 8, k_many_bounces);
    scene.sky = ConstantSky{Rgb(0.7f)};
    scene.cloud.emplace();
    scene.cloud->material = material;
    for (const NormalMode normals : {NormalMode::sphere, NormalMode::smooth}) {
      scene.cloud->normals = normals;
      expect_everywhere(render(scene, &cloud), 0.7);
    }
  }
}

TEST(Furnace, rough_metal_never_gives_back_more_than_it_gets) {
  for (const double roughness : {0.1, 0.4, 0.7, 1.0}) {
    Scene scene = dark_scene(camera_at({0, 0, 3}, {0, 0, 0}, 60.0, 32), 64, k_many_bounces);
    scene.sky = ConstantSky{Rgb(1.0f)};
    scene.objects = {Sphere{glm::dvec3(0.0), 1.0, Metal{Rgb(1.0f), roughness}}};
    for (const Rgb& color : render(scene, nullptr).color) {
      ASSERT_LE(color.r, 1.0f + 1e-5f);
      ASSERT_GT(color.r, 0.2f);
    }
  }
}

TEST(Furnace, a_convex_body_shows_its_albedo) {
  Scene scene = dark_scene(camera_at({0, 0, 3}, {0, 0, 0}, 20.0), 4, 8);
  scene.sky = ConstantSky{Rgb(2.0f)};
  scene.objects = {Sphere{glm::dvec3(0.0), 1.0, Lambertian{Rgb(0.3f)}}};
  expect_everywhere(render(scene, nullptr), 0.6);
}

TEST(Roulette, changes_no_mean) {
  // Dark and deep: with albedo 0.9 nearly all light of the furnace comes by paths on which roulette was
  // played.
  Scene scene = furnace(0.9f, k_many_bounces);
  scene.render.samples = 1024;
  scene.render.seed = 99;
  expect_mean(render(scene, nullptr), 3.0 * k_lamp_share * 0.9 / (1.0 - 0.9 * (1.0 - k_lamp_share)));
}

TEST(Sunlight, on_a_plane_is_irradiance_times_albedo_over_pi_times_sine_of_elevation) {
  for (const double diameter : {0.0, 0.53, 20.0}) {
    for (const double elevation : {12.0, 40.0, 90.0}) {
      Scene scene = dark_scene(camera_at({0, 0, 5}, {1, 2, 0}, 40.0), 64, 8);
      scene.sun = Sun{.elevation = elevation, .irradiance = Rgb(3.0f), .angular_diameter = diameter};
      scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}};
      expect_mean(render(scene, nullptr), 3.0 * 0.5 / k_pi * std::sin(elevation * k_pi / 180.0));
    }
  }
}

TEST(Sunlight, counts_once_beside_the_sky) {
  Scene scene = dark_scene(camera_at({0, 0, 5}, {1, 2, 0}, 40.0), 256, 8);
  scene.sky = ConstantSky{Rgb(0.4f)};
  // A wide sun, which many bounced rays run into.
  scene.sun = Sun{.elevation = 50.0, .irradiance = Rgb(3.0f), .angular_diameter = 60.0};
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}};
  expect_mean(render(scene, nullptr), 0.5 * (0.4 + 3.0 / k_pi * std::sin(50.0 * k_pi / 180.0)));
}

TEST(Sunlight, disc_seen_directly_and_in_a_mirror_has_irradiance_over_solid_angle) {
  const double solid_angle = 2.0 * k_pi * (1.0 - std::cos(2.5 * k_pi / 180.0));
  Scene scene = dark_scene(camera_at({0, 0, 0}, {0, 1, 1}, 1.0), 4, 8);
  scene.sun = Sun{.azimuth = 0, .elevation = 45.0, .irradiance = Rgb(3.0f), .angular_diameter = 5.0};
  expect_everywhere(render(scene, nullptr), 3.0 / solid_angle, 1e-3);
  scene.camera = camera_at({0, 0, 1}, {0, 1, 0}, 1.0);
  scene.objects = {GroundPlane{0.0, Metal{Rgb(1.0f), 0.0}}};
  expect_everywhere(render(scene, nullptr), 3.0 / solid_angle, 1e-3);
}

TEST(Sunlight, on_metal_is_the_integral_over_the_disc) {
  // From rough metal, where the sun is sampled, to nearly a mirror, where rays must find it.
  for (const double roughness : {0.015, 0.05, 0.2, 0.5, 1.0}) {
    const Metal metal{Rgb(0.8f), roughness};
    Scene scene = dark_scene(camera_at({0, 0, 1}, {0, 0, 0}, 0.01, 8), 256, 8);
    scene.sun = Sun{.elevation = 90.0, .irradiance = Rgb(3.0f), .angular_diameter = 10.0};
    scene.objects = {GroundPlane{0.0, metal}};
    const double sine = std::sin(5.0 * k_pi / 180.0), height = 1.0 - std::cos(5.0 * k_pi / 180.0);
    double answer = 0.0;
    constexpr int k_steps = 200000;
    for (int i = 0; i < k_steps; ++i) {
      // Midpoint rule; steps grow away from the axis, where a sharp reflection has all its light.
      const double u = (i + 0.5) / k_steps, depth = height * u * u * u;
      const double step = 3.0 * height * u * u / k_steps;
      answer += 3.0 / (k_pi * sine * sine) * 2.0 * k_pi * step *
                eval(metal, Rgb(1.0f), {0, 0, 1}, {std::sqrt(depth * (2.0 - depth)), 0.0, 1.0 - depth}).r;
    }
    SCOPED_TRACE(roughness);
    expect_mean(render(scene, nullptr), answer);
  }
}

TEST(Sunlight, of_the_smallest_disc_is_a_number_in_a_mirror) {
  Scene scene = dark_scene(camera_at({0, 0, 1}, {0, 0, 0}, 40.0, 3), 4, 8);
  scene.sun = Sun{.elevation = 90.0, .angular_diameter = 1e-18};
  scene.objects = {GroundPlane{0.0, Metal{Rgb(1.0f), 0.0}}};
  for (const Rgb& color : render(scene, nullptr).color) EXPECT_EQ(color, Rgb(0.0f));
}

/// Largest value over the median.
double largest_over_median(const Film& film) {
  std::vector<float> values;
  for (const Rgb& color : film.color) values.push_back(color.r);
  std::ranges::sort(values);
  return values.back() / values[values.size() / 2];
}

TEST(Speckles, do_not_come_on_a_plane_beside_metal_or_glass) {
  // The plane under sun and lamp, with nothing of the sphere in the image. Few paths turn from the plane to
  // the sphere and on to a light; none may outshine the direct light.
  for (const Material& material :
       {Material(Metal{Rgb(0.9f), 0.015}), Material(Metal{Rgb(0.9f), 0.05}), Material(Metal{Rgb(0.9f), 0.2}),
        Material(Metal{Rgb(0.9f), 0.0}), Material(Dielectric{1.5})}) {
    Scene scene = dark_scene(camera_at({1.7, 0, 4}, {1.7, 0, 0}, 8.0, 64), 16, 8);
    scene.sun = Sun{.azimuth = 90.0, .elevation = 40.0, .irradiance = Rgb(3.0f)};
    scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}, Sphere{{0, 0, 1}, 1.0, material},
                     Sphere{{5, 0, 4}, 0.1, Emissive{Rgb(300.0f)}}};
    SCOPED_TRACE(material.index());
    EXPECT_LT(largest_over_median(render(scene, nullptr)), 2.0);
  }
}

TEST(Speckles, do_not_come_on_metal_beside_a_mirror) {
  // The side of a copper ball where a mirror shows it its own sunlit side, made small.
  Scene scene = dark_scene(camera_at({0, -13, 3.2}, {-1.45, -0.5, 1.0}, 3.0, 48), 16, 8);
  scene.sky = ConstantSky{Rgb(0.5f)};
  scene.sun = Sun{.azimuth = 230.0, .elevation = 35.0, .irradiance = Rgb(2.0f)};
  const Metal copper{Rgb(0.9f), 0.3}, mirror{Rgb(0.9f), 0.0};
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.4f)}}, Sphere{{-2.2, 0, 1}, 1.0, copper},
                   Sphere{{0, 0, 1}, 1.0, mirror}};
  EXPECT_LT(largest_over_median(render(scene, nullptr)), 4.0);
}

TEST(Path, metal_seen_in_metal_is_as_sharp_as_without_it) {
  // A smooth sphere seen in a plane equally smooth keeps its roughness: the reflected sky has a sharp edge.
  Scene scene = dark_scene(camera_at({0, -4, 1}, {0, 0, 1}, 60.0, 32), 16, 8);
  scene.sky = GradientSky{Rgb(0.0f), Rgb(1.0f)};
  scene.objects = {GroundPlane{0.0, Metal{Rgb(0.9f), 0.02}}, Sphere{{0, 0, 1}, 1.0, Metal{Rgb(0.9f), 0.02}}};
  const Film nearly = render(scene, nullptr);
  scene.objects = {GroundPlane{0.0, Metal{Rgb(0.9f), 0.0}}, Sphere{{0, 0, 1}, 1.0, Metal{Rgb(0.9f), 0.0}}};
  const Film mirrors = render(scene, nullptr);
  double difference = 0.0;
  for (std::size_t i = 0; i < mirrors.color.size(); ++i)
    difference += std::fabs(double{nearly.color[i].r} - mirrors.color[i].r) / mirrors.color.size();
  EXPECT_LT(difference, 0.01);
}

TEST(Path, lights_behind_glass_are_as_bright_in_sharp_metal_as_in_a_mirror) {
  // Straight down on a metal plane: it shows the sun and a lamp behind a ball of index 1, which bends and
  // reflects nothing.
  for (const bool sun : {false, true}) {
    Film films[2];
    for (int sharp = 0; sharp < 2; ++sharp) {
      Scene scene = dark_scene(camera_at({0, 0, 1}, {0, 0, 0}, 1.0, 8), 64, 8);
      scene.objects = {GroundPlane{0.0, Metal{Rgb(0.8f), sharp == 1 ? 0.02 : 0.0}},
                       Sphere{{0, 0, 4}, 2.0, Dielectric{1.0}}};
      if (sun)
        scene.sun = Sun{.elevation = 90.0, .irradiance = Rgb(1.0f), .angular_diameter = 10.0};
      else
        scene.objects.push_back(Sphere{{0, 0, 20}, 2.0, Emissive{Rgb(3.0f)}});
      films[sharp] = render(scene, nullptr);
    }
    const double mirror = test::image_mean(films[0]).mean;
    EXPECT_GT(mirror, 1.0);
    EXPECT_NEAR(test::image_mean(films[1]).mean, mirror, 0.02 * mirror) << sun;
  }
}

TEST(Furnace, mirrors_and_glass_beside_diffuse_bodies_lose_no_light_of_a_lamp_all_around) {
  Scene scene = dark_scene(camera_at({0, 0, 3}, {0, 0, 0}, 60.0, 32), 16, k_many_bounces);
  scene.objects = {
      Sphere{glm::dvec3(0.0), 50.0, Emissive{Rgb(2.0f)}}, Sphere{glm::dvec3(0.0), 1.0, Lambertian{Rgb(1.0f)}},
      Sphere{{1.5, 0.0, 1.0}, 0.5, Metal{Rgb(1.0f), 0.0}}, Sphere{{-1.5, 0.0, 1.0}, 0.5, Dielectric{1.5}}};
  test::ImageMean mean = test::image_mean(render(scene, nullptr));
  EXPECT_NEAR(mean.mean, 2.0, 0.002);
}

TEST(Sunlight, a_point_throws_the_shadow_of_its_sphere) {
  const LoadedCloud cloud = test::loaded({{0, 0, 3}}, 1.0);
  Scene scene = dark_scene(camera_at({0, 0, 1.5}, {0, 0, 0}, 20.0), 4, 0);
  scene.cloud.emplace();
  scene.sun = Sun{.elevation = 90.0, .irradiance = Rgb(3.0f), .angular_diameter = 0.53};
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}};
  EXPECT_EQ(test::image_mean(render(scene, &cloud)).mean, 0.0);
  scene.camera = camera_at({1.5, 0, 1.5}, {1.5, 0, 0}, 20.0);
  expect_mean(render(scene, &cloud), 1.5 / k_pi);
}

/// A lamp of radius 1 and radiance 2, its centre 3 above the plane: straight below it the irradiance is pi L
/// (r / d)^2 (the view factor of a sphere that stands wholly above the horizon is (r / d)^2 cos), so the
/// plane shows albedo * L / 9.
Scene lamp_over_plane(const Material& material) {
  Scene scene = dark_scene(camera_at({0, 0, 0.5}, {0, 0, 0}, 0.5, 4), 1024, 0);
  scene.objects = {GroundPlane{0.0, material}, Sphere{{0, 0, 3}, 1.0, Emissive{Rgb(2.0f)}}};
  return scene;
}

TEST(Lamplight, of_a_sphere_on_a_plane_is_its_view_factor) {
  expect_mean(render(lamp_over_plane(Lambertian{Rgb(0.5f)}), nullptr), 0.5 * 2.0 / 9.0);
}

TEST(Lamplight, of_a_slanted_sphere_goes_with_the_cosine) {
  Scene scene = lamp_over_plane(Lambertian{Rgb(0.5f)});
  std::get<Sphere>(scene.objects[1]).center = {4.0, 0.0, 3.0};
  expect_mean(render(scene, nullptr), 0.5 * 2.0 * (1.0 / 25.0) * 0.6);
}

TEST(Lamplight, of_several_spheres_adds_up) {
  Scene scene = lamp_over_plane(Lambertian{Rgb(0.5f)});
  scene.objects.push_back(Sphere{{4.0, 0.0, 3.0}, 1.0, Emissive{Rgb(20.0f)}});
  scene.render.samples = 4096;
  expect_mean(render(scene, nullptr), 0.5 * 2.0 / 9.0 + 0.5 * 20.0 / 25.0 * 0.6);
}

TEST(Lamplight, on_rough_metal_is_the_integral_over_the_lamp) {
  for (const double roughness : {0.3, 0.6, 1.0}) {
    const Metal metal{Rgb(0.8f), roughness};
    // Midpoint rule over the cone the lamp fills as seen from the plane, from straight above.
    const double cosine = std::sqrt(8.0) / 3.0;
    double answer = 0.0;
    constexpr int k_steps = 200000;
    for (int i = 0; i < k_steps; ++i) {
      const double z = 1.0 - (1.0 - cosine) * (i + 0.5) / k_steps;
      answer += 2.0 * eval(metal, Rgb(1.0f), {0, 0, 1}, {std::sqrt(1.0 - z * z), 0.0, z}).r * (2.0 * k_pi) *
                (1.0 - cosine) / k_steps;
    }
    expect_mean(render(lamp_over_plane(metal), nullptr), answer);
  }
}

TEST(Lamplight, is_blocked_by_points_and_spheres) {
  Scene scene = lamp_over_plane(Lambertian{Rgb(0.5f)});
  scene.objects.push_back(Sphere{{0, 0, 1.5}, 0.9, Lambertian{Rgb(0.0f)}});
  EXPECT_EQ(test::image_mean(render(scene, nullptr)).mean, 0.0);
  scene.objects.pop_back();
  const LoadedCloud cloud = test::loaded({{0, 0, 1.5}}, 0.9);
  scene.cloud.emplace();
  EXPECT_EQ(test::image_mean(render(scene, &cloud)).mean, 0.0);
}

TEST(Lamplight, lamp_seen_directly_has_its_radiance) {
  Scene scene = lamp_over_plane(Lambertian{Rgb(0.5f)});
  scene.camera = camera_at({0, 0, 0.5}, {0, 0, 3}, 5.0);
  expect_everywhere(render(scene, nullptr), 2.0);
}

/// A floor of points that are not quite level, seen from above.
Scene smooth_floor() {
  Scene scene = dark_scene(camera_at({0, 0, 2}, {0, 0, 0}, 30.0), 16, 8);
  scene.cloud.emplace();
  scene.cloud->material = Lambertian{Rgb(0.5f)};
  scene.cloud->normals = NormalMode::smooth;
  return scene;
}

LoadedCloud rough_floor(double roughness) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 40000; ++i) {
    positions.push_back(
        {random.between(-3, 3), random.between(-3, 3), random.between(-roughness, roughness)});
  }
  return test::loaded(positions, 0.08);
}

TEST(SmoothFloor, of_points_is_lit_like_a_plane) {
  // Level but for a little noise: as Sunlight.on_a_plane, and albedo times radiance under an even sky.
  const LoadedCloud cloud = rough_floor(0.004);
  for (const double elevation : {15.0, 40.0, 90.0}) {
    Scene scene = smooth_floor();
    scene.sun = Sun{.elevation = elevation, .irradiance = Rgb(3.0f)};
    const double answer = 3.0 * 0.5 / k_pi * std::sin(elevation * k_pi / 180.0);
    EXPECT_NEAR(test::image_mean(render(scene, &cloud)).mean, answer, 0.005 * answer) << elevation;
  }
  Scene scene = smooth_floor();
  scene.sky = ConstantSky{Rgb(0.8f)};
  EXPECT_NEAR(test::image_mean(render(scene, &cloud)).mean, 0.4, 0.002);
}

TEST(SmoothFloor, exact_spheres_shade_each_other_where_the_smooth_surface_does_not) {
  const LoadedCloud cloud = rough_floor(0.004);
  Scene scene = smooth_floor();
  scene.sky = ConstantSky{Rgb(0.8f)};
  scene.cloud->normals = NormalMode::sphere;
  scene.render.max_bounces = 0;
  EXPECT_LT(test::image_mean(render(scene, &cloud)).mean, 0.39);
}

TEST(SmoothFloor, keeps_what_stands_on_it_in_shadow) {
  LoadedCloud cloud = rough_floor(0.004);
  Scene scene = smooth_floor();
  scene.sun = Sun{.elevation = 90.0, .irradiance = Rgb(3.0f)};
  scene.objects = {Sphere{{0, 0, 3.5}, 1.0, Lambertian{Rgb(0.0f)}}};
  EXPECT_EQ(test::image_mean(render(scene, &cloud)).mean, 0.0);
}

TEST(Path, a_glass_point_looks_like_a_glass_sphere) {
  const LoadedCloud cloud = test::loaded({{0, 0, 0}}, 1.0);
  Scene scene = dark_scene(camera_at({0, 3, 0.5}, {0, 0, 0}, 50.0, 32), 16, 20);
  scene.sky = GradientSky{Rgb(1.0f), Rgb(0.0f)};
  Scene with_point = scene;
  with_point.cloud.emplace();
  with_point.cloud->material = Dielectric{1.5};
  scene.objects = {Sphere{glm::dvec3(0.0), 1.0, Dielectric{1.5}}};
  const Film sphere = render(scene, nullptr), point = render(with_point, &cloud);
  for (std::size_t pixel = 0; pixel < sphere.color.size(); ++pixel) {
    ASSERT_NEAR(sphere.color[pixel].r, point.color[pixel].r, 1e-4f);
  }
}

TEST(Path, brings_back_the_same_alone_and_among_others) {
  test::Random random;
  std::vector<glm::dvec3> heap;
  for (int i = 0; i < 3000; ++i) heap.push_back(random.in_cube());
  const LoadedCloud cloud = test::loaded(heap, 0.05);
  Scene scene = dark_scene(camera_at({0, 0, 6}, {0, 0, 0}, 40.0), 1, 8);
  scene.sky = ConstantSky{Rgb(0.2f)};
  scene.sun = Sun{};
  scene.objects = {Sphere{{2, 0, 0}, 0.5, Emissive{Rgb(3.0f)}},
                   Sphere{{-2, 0, 0}, 0.5, Metal{Rgb(0.9f), 0.2}}, Sphere{{0, 2, 0}, 0.5, Dielectric{1.5}},
                   GroundPlane{-1.0, Lambertian{Rgb(0.5f)}}};
  const World world(scene, &cloud);
  const Lights lights(scene);
  std::vector<CameraPath> paths;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const glm::dvec3 target = 2.0 * random.in_cube();
    paths.push_back({make_ray({0, 0, 6}, target - glm::dvec3(0, 0, 6), 0.0), Sampler(1, i, 0, 0)});
  }
  std::vector<PathResult> together(paths.size());
  trace_paths(world, lights, paths, 8, together);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    PathResult alone;
    trace_paths(world, lights, {&paths[i], 1}, 8, {&alone, 1});
    EXPECT_EQ(alone.radiance, together[i].radiance) << i;
    EXPECT_EQ(alone.met_surface, together[i].met_surface) << i;
    EXPECT_EQ(alone.ray_count, together[i].ray_count) << i;
  }
}

}  // namespace
}  // namespace alidade
