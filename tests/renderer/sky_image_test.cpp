// SPDX-License-Identifier: MIT
#include "renderer/sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "renderer/integrator.h"
#include "tests/renderer/tracer_scenes.h"
#include "tests/support/random.h"

namespace alidade {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

using test::camera_at;
using test::dark_scene;

SkyPixels even_pixels(int width, int height, const Rgb& value) {
  SkyPixels pixels{.width = width, .height = height};
  pixels.values.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value);
  return pixels;
}

Rgb& pixel(SkyPixels& pixels, int x, int y) {
  return pixels.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(pixels.width) +
                       static_cast<std::size_t>(x)];
}

/// A dim sky with a glow in it, some dark ground and a few spots.
SkyPixels varied_pixels(int width = 64, int height = 32) {
  SkyPixels pixels = even_pixels(width, height, Rgb(0.0f));
  test::Random random("varied sky");
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double above = 0.5 - (y + 0.5) / height;
      const double glow = std::exp(-std::pow(8.0 * (x + 0.5) / width - 5.0, 2.0) - 40.0 * above * above);
      pixel(pixels, x, y) = Rgb(above < -0.25 ? 0.0f : static_cast<float>(0.3 + 3.0 * glow));
    }
  }
  for (int i = 0; i < 5; ++i)
    pixel(pixels, static_cast<int>(random.below(64)) * width / 64,
          static_cast<int>(random.below(16)) * height / 32) = Rgb(40.0f, 30.0f, 10.0f);
  return pixels;
}

SkyImage image(SkyPixels pixels, double scale = 1.0, double rotation = 0.0) {
  return SkyImage(std::move(pixels), scale, rotation);
}

Sky sky_of(SkyPixels pixels, double scale = 1.0, double rotation = 0.0) {
  ImageSky sky{.file = "sky.exr", .image = {}};
  sky.image = std::make_shared<SkyImage>(std::move(pixels), scale, rotation);
  return sky;
}

glm::dvec3 towards(double azimuth, double elevation) {
  const double a = azimuth * k_pi / 180.0, e = elevation * k_pi / 180.0;
  return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

TEST(SkyImageTest, a_panorama_shows_the_sky_pixel_by_pixel) {
  const int width = 32, height = 16;
  SkyPixels pixels = even_pixels(width, height, Rgb(0.0f));
  test::Random random("panorama");
  for (Rgb& value : pixels.values) value = Rgb(random.unit(), random.unit(), random.unit());
  const SkyImage sky = image(pixels);
  const Camera camera = panorama_camera({5, 6, 7}, width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb seen = sky.radiance(camera_ray(camera, {x + 0.5, y + 0.5}).direction);
      EXPECT_LT(glm::length(seen - pixel(pixels, x, y)), 1e-5) << x << " " << y;
    }
  }
}

TEST(SkyImageTest, the_middle_column_looks_north_and_rotation_turns_it_clockwise) {
  SkyPixels pixels = even_pixels(360, 180, Rgb(0.0f));
  for (int y = 0; y < 180; ++y) pixel(pixels, 180, y) = Rgb(1.0f);  // azimuths 0 to 1
  EXPECT_NEAR(image(pixels).radiance(towards(0.5, 10.0)).r, 1.0, 1e-5);
  EXPECT_EQ(image(pixels).radiance(towards(90.5, 10.0)).r, 0.0f);
  EXPECT_NEAR(image(pixels, 1.0, 90.0).radiance(towards(90.5, 10.0)).r, 1.0, 1e-5);
  EXPECT_NEAR(image(pixels, 1.0, -90.0).radiance(towards(270.5, -10.0)).r, 1.0, 1e-5);
  EXPECT_NEAR(image(pixels, 3.0, 360.0).radiance(towards(0.5, 80.0)).r, 3.0, 1e-4);
}

TEST(SkyImageTest, is_seamless_at_the_back_and_even_around_the_poles) {
  SkyPixels pixels = varied_pixels();
  const SkyImage sky = image(pixels);
  for (double elevation = -89.0; elevation < 90.0; elevation += 7.0) {
    const Rgb left = sky.radiance(towards(180.0 - 1e-9, elevation)),
              right = sky.radiance(towards(180.0 + 1e-9, elevation));
    EXPECT_NEAR(left.r, right.r, 1e-4) << elevation;
  }
  EXPECT_TRUE(std::isfinite(sky.radiance({0, 0, 1}).r));
  EXPECT_TRUE(std::isfinite(sky.radiance({0, 0, -1}).r));
}

TEST(SkyImageTest, samples_have_the_density_and_radiance_of_their_direction) {
  for (const double rotation : {0.0, 77.0}) {
    const SkyImage sky = image(varied_pixels(), 2.0, rotation);
    test::Random random;
    for (int i = 0; i < 5000; ++i) {
      const SkySample chosen = sky.sample({random.unit(), random.unit()});
      ASSERT_NEAR(glm::length(chosen.direction), 1.0, 1e-12);
      ASSERT_GT(chosen.pdf, 0.0);
      ASSERT_LT(glm::length(chosen.radiance - sky.radiance(chosen.direction)),
                1e-4f * (1.0f + chosen.radiance.r));
      ASSERT_NEAR(sky.pdf(chosen.direction), chosen.pdf, 1e-4 * (1e-3 + chosen.pdf));
    }
  }
}

TEST(SkyImageTest, density_is_in_proportion_to_luminance) {
  const SkyImage sky = image(varied_pixels());
  const auto ratio = [&](const glm::dvec3& direction) {
    const Rgb radiance = sky.radiance(direction);
    return sky.pdf(direction) / (0.2126 * radiance.r + 0.7152 * radiance.g + 0.0722 * radiance.b);
  };
  test::Random random;
  const double everywhere = ratio({0, 0, 1});
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 direction = glm::normalize(random.direction());
    if (sky.pdf(direction) == 0.0) continue;
    ASSERT_NEAR(ratio(direction), everywhere, 1e-5 * everywhere);
  }
}

TEST(SkyImageTest, density_sums_to_one_and_is_never_zero_where_light_is) {
  const SkyImage sky = image(varied_pixels());
  double sum = 0.0;
  constexpr int k_columns = 640, k_rows = 320;
  for (int y = 0; y < k_rows; ++y) {
    for (int x = 0; x < k_columns; ++x) {
      const double elevation = 90.0 - 180.0 * (y + 0.5) / k_rows;
      const glm::dvec3 direction = towards(360.0 * (x + 0.5) / k_columns, elevation);
      const double density = sky.pdf(direction);
      sum += density * (2.0 * k_pi / k_columns) * (k_pi / k_rows) * std::cos(elevation * k_pi / 180.0);
      ASSERT_TRUE(density > 0.0 || sky.radiance(direction).r == 0.0f);
    }
  }
  EXPECT_NEAR(sum, 1.0, 1e-3);
}

TEST(SkyImageTest, directions_are_chosen_as_densely_as_pdf_says) {
  // Chi-square over coarse cells of even solid angle.
  constexpr int k_columns = 16, k_rows = 8, k_samples = 200000, k_fine = 40;
  const SkyImage sky = image(varied_pixels());
  std::vector<double> expected(k_columns * k_rows), found(k_columns * k_rows);
  for (int y = 0; y < k_rows * k_fine; ++y) {
    for (int x = 0; x < k_columns * k_fine; ++x) {
      const double sine = 1.0 - 2.0 * (y + 0.5) / (k_rows * k_fine);
      const glm::dvec3 direction =
          towards(360.0 * (x + 0.5) / (k_columns * k_fine), std::asin(sine) * 180.0 / k_pi);
      expected[static_cast<std::size_t>(y / k_fine * k_columns + x / k_fine)] +=
          k_samples * sky.pdf(direction) * 4.0 * k_pi / (k_columns * k_rows * k_fine * k_fine);
    }
  }
  test::Random random;
  for (int i = 0; i < k_samples; ++i) {
    const glm::dvec3 direction = sky.sample({random.unit(), random.unit()}).direction;
    const double turn = std::atan2(direction.x, direction.y) / (2.0 * k_pi);
    const int x = std::min(static_cast<int>((turn - std::floor(turn)) * k_columns), k_columns - 1);
    const int y = std::clamp(static_cast<int>(0.5 * (1.0 - direction.z) * k_rows), 0, k_rows - 1);
    found[static_cast<std::size_t>(y * k_columns + x)] += 1.0;
  }
  double chi_square = 0.0;
  int cells = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (expected[i] < 10.0) continue;
    ++cells;
    // One percent for the coarse integral.
    const double allowed = expected[i] + 1e-4 * expected[i] * expected[i];
    chi_square += (found[i] - expected[i]) * (found[i] - expected[i]) / allowed;
  }
  EXPECT_GT(cells, 80);
  EXPECT_LT(chi_square, cells + 5.0 * std::sqrt(2.0 * cells));
}

TEST(SkyImageTest, may_be_a_single_pixel_or_row_or_column) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 5}, {7, 1}, {2, 1}}) {
    const SkyImage sky = image(even_pixels(width, height, Rgb(0.5f)), 2.0);
    test::Random random;
    for (int i = 0; i < 200; ++i) {
      const SkySample chosen = sky.sample({random.unit(), random.unit()});
      EXPECT_NEAR(chosen.radiance.r, 1.0f, 1e-6f);
      EXPECT_NEAR(chosen.pdf, 1.0 / (4.0 * k_pi), 1e-9);
      EXPECT_NEAR(sky.pdf(chosen.direction), 1.0 / (4.0 * k_pi), 1e-9);
    }
  }
}

TEST(SkyImageTest, of_black_is_black_and_never_sampled) {
  EXPECT_TRUE(image(even_pixels(8, 4, Rgb(0.0f))).is_black());
  EXPECT_TRUE(image(even_pixels(8, 4, Rgb(1.0f)), 0.0).is_black());
  EXPECT_EQ(image(even_pixels(8, 4, Rgb(0.0f))).pdf({0, 0, 1}), 0.0);
  Scene scene = dark_scene(camera_at({0, 0, 5}, {1, 2, 0}, 40.0), 4, 8);
  scene.sky = sky_of(even_pixels(8, 4, Rgb(0.0f)));
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}};
  EXPECT_EQ(test::image_mean(render(scene, nullptr)).mean, 0.0);
}

TEST(SkyImageTest, extremes_of_brightness_stay_numbers) {
  for (const float value : {1e-45f, 1e-30f, 1e9f}) {
    for (const double scale : {1e-9, 1.0, 1e9}) {
      SkyPixels pixels = even_pixels(16, 8, Rgb(0.0f));
      pixel(pixels, 3, 2) = Rgb(value);
      Scene scene = dark_scene(camera_at({0, 0, 5}, {1, 2, 0}, 40.0), 4, 8);
      scene.sky = sky_of(pixels, scale);
      scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}},
                       Sphere{{1, 2, 1}, 1.0, Metal{Rgb(0.5f), 0.2}}};
      for (const Rgb& color : render(scene, nullptr).color) ASSERT_TRUE(std::isfinite(color.r)) << value;
    }
  }
}

TEST(SkyImageLight, a_scene_whose_sky_was_not_read_is_an_error) {
  Scene scene = dark_scene(camera_at({0, 0, 5}, {1, 2, 0}, 40.0), 1, 1);
  scene.sky = ImageSky{.file = "sky.exr", .image = {}};
  EXPECT_THROW(render(scene, nullptr), Error);
  scene.sky = ConstantSky{};
  scene.sun_by_time.emplace();
  EXPECT_THROW(render(scene, nullptr), Error);
}

TEST(SkyImageLight, of_an_even_image_is_that_of_an_even_sky) {
  for (const Material& material :
       {Material(Lambertian{Rgb(1.0f)}), Material(Metal{Rgb(1.0f), 0.0}), Material(Dielectric{1.5})}) {
    Scene scene = dark_scene(camera_at({0, 0, 3}, {0, 0, 0}, 60.0, 32), 64, 1000);
    scene.sky = sky_of(even_pixels(16, 8, Rgb(0.35f)), 2.0);
    scene.objects = {Sphere{glm::dvec3(0.0), 1.0, material}, Sphere{{0.5, 0.4, 1.0}, 0.3, material}};
    EXPECT_NEAR(test::image_mean(render(scene, nullptr)).mean, 0.7, 0.7 * 0.004) << material.index();
  }
}

TEST(SkyImageLight, of_rough_metal_under_an_even_image_is_that_under_an_even_sky) {
  for (const double roughness : {0.05, 0.3, 1.0}) {
    Scene scene = dark_scene(camera_at({0, -2, 3}, {0, 0, 0}, 60.0, 24), 256, 100);
    scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.6f)}},
                     Sphere{{0, 0, 1}, 1.0, Metal{Rgb(0.9f), roughness}}};
    scene.sky = ConstantSky{Rgb(0.8f)};
    const double even = test::image_mean(render(scene, nullptr)).mean;
    scene.sky = sky_of(even_pixels(16, 8, Rgb(0.8f)));
    EXPECT_NEAR(test::image_mean(render(scene, nullptr)).mean, even, 0.004 * even) << roughness;
  }
}

TEST(SkyImageLight, of_a_painted_gradient_is_that_of_the_gradient_also_by_way_of_mirrors_and_glass) {
  // The gradient is found by rays alone, and nothing of it is left out.
  const Sky gradient = GradientSky{Rgb(3.0f), Rgb(0.3f)};
  SkyPixels pixels = even_pixels(256, 512, Rgb(0.0f));
  for (int y = 0; y < 512; ++y) {
    const glm::dvec3 direction = towards(0.0, 180.0 * (0.5 - (y + 0.5) / 512));
    for (int x = 0; x < 256; ++x) pixel(pixels, x, y) = sky_radiance(gradient, direction);
  }
  Scene scene = dark_scene(camera_at({0, -4, 1.5}, {0, 0, 0.5}, 60.0, 24), 1024, 100);
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.7f)}}, Sphere{{0.9, 0, 1}, 0.8, Metal{Rgb(1.0f), 0.0}},
                   Sphere{{-0.9, 0, 1}, 0.8, Dielectric{1.5}},
                   Sphere{{0, 1.5, 0.5}, 0.5, Metal{Rgb(0.9f), 0.3}}};
  scene.sky = gradient;
  const double found = test::image_mean(render(scene, nullptr)).mean;
  scene.sky = sky_of(pixels);
  EXPECT_NEAR(test::image_mean(render(scene, nullptr)).mean, found, 0.005 * found);
}

TEST(SkyImageLight, of_one_bright_pixel_is_that_of_a_sun_there) {
  const int width = 512, height = 256;
  for (const double rotation : {0.0, 137.0}) {
    SkyPixels pixels = even_pixels(width, height, Rgb(0.0f));
    const int x = 300, y = 70;
    pixel(pixels, x, y) = Rgb(5000.0f);
    const double top = std::cos(k_pi * y / height), bottom = std::cos(k_pi * (y + 1) / height);
    const double solid_angle = 2.0 * k_pi / width * (top - bottom);
    Scene scene = dark_scene(camera_at({0, -4, 5}, {0, 1, 0}, 50.0, 24), 64, 8);
    scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}, Sphere{{0, 0, 1}, 1.0, Lambertian{Rgb(0.7f)}}};
    scene.sky = sky_of(pixels, 1.0, rotation);
    const Film by_sky = render(scene, nullptr);
    scene.sky = ConstantSky{};
    scene.sun = Sun{.azimuth = 360.0 * ((x + 0.5) / width - 0.5) + rotation,
                    .elevation = 180.0 * (0.5 - (y + 0.5) / height),
                    .irradiance = Rgb(static_cast<float>(5000.0 * solid_angle)),
                    .angular_diameter = 0.9};
    const Film by_sun = render(scene, nullptr);
    const double mean = test::image_mean(by_sun).mean;
    EXPECT_GT(mean, 0.03);
    EXPECT_NEAR(test::image_mean(by_sky).mean, mean, 0.01 * mean) << rotation;
    // Shadows cover the same pixels.
    int different = 0;
    for (std::size_t i = 0; i < by_sun.color.size(); ++i)
      different += std::fabs(by_sun.color[i].r - by_sky.color[i].r) > 0.1 * mean ? 1 : 0;
    EXPECT_LT(different, static_cast<int>(by_sun.color.size()) / 25);
  }
}

/// The light that leaves a diffuse scene towards a ray, by chance alone: no light is sampled.
double found_by_chance(const World& world, const Sky& sky, Ray ray, test::Random& random) {
  double throughput = 1.0;
  RayOrigin ray_origin;
  for (int bounce = 0; bounce <= 8; ++bounce) {
    const auto met = world.nearest(ray, ray_origin);
    if (!met) return throughput * sky_radiance(sky, ray.direction).r;
    const Surface surface = world.surface_at(ray, *met);
    throughput *= albedo(*surface.material, surface.color).r;
    const glm::dvec3 facing =
        glm::dot(surface.normal, ray.direction) > 0.0 ? -surface.normal : surface.normal;
    ray_origin = {.from = RayOrigin::From::object, .index = met->index};
    ray = {surface.ray_origin,
           basis_around(facing).to_world(sample_cosine_hemisphere({random.unit(), random.unit()}))};
  }
  return 0.0;
}

Scene diffuse_yard(SkyPixels pixels) {
  Scene scene = dark_scene(camera_at({0, -6, 5}, {0, 0, 0.5}, 40.0, 16), 256, 7);
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}, Sphere{{0, 0, 1}, 1.0, Lambertian{Rgb(0.8f)}},
                   Sphere{{1.5, 0.5, 0.7}, 0.7, Lambertian{Rgb(0.3f)}}};
  scene.sky = sky_of(std::move(pixels));
  return scene;
}

TEST(SkyImageLight, is_what_rays_alone_would_find) {
  const Scene scene = diffuse_yard(varied_pixels());
  const Film film = render(scene, nullptr);
  const World world(scene, nullptr);
  test::Random random;
  double sum = 0.0, squares = 0.0;
  constexpr int k_paths = 400000;
  for (int i = 0; i < k_paths; ++i) {
    const Ray ray = camera_ray(*scene.camera, {16.0 * random.unit(), 16.0 * random.unit()});
    const double light = found_by_chance(world, scene.sky, ray, random);
    sum += light;
    squares += light * light;
  }
  const double mean = sum / k_paths, error = std::sqrt((squares / k_paths - mean * mean) / k_paths);
  EXPECT_LT(error, 0.01 * mean);
  EXPECT_NEAR(test::image_mean(film).mean, mean, 4.0 * error + 4.0 * test::image_mean(film).standard_error);
}

TEST(SkyImageLight, has_far_less_noise_than_rays_alone_would_bring) {
  SkyPixels pixels = varied_pixels(128, 64);
  pixel(pixels, 40, 14) = Rgb(3000.0f);
  Scene scene = dark_scene(camera_at({0, 0, 5}, {0.1, 0.1, 0}, 10.0, 8), 256, 0);
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}};
  scene.sky = sky_of(pixels);
  const Film film = render(scene, nullptr);
  double sampled = 0.0;  // variance of one path
  for (const Rgb& variance : film.variance)
    sampled += 256.0 * variance.r / static_cast<double>(film.variance.size());
  // By chance a path brings albedo times the radiance of a direction spread as the cosine: its variance by
  // the midpoint rule.
  double mean = 0.0, squares = 0.0;
  constexpr int k_side = 1024;
  for (int i = 0; i < k_side * k_side; ++i) {
    const double u = (i % k_side + 0.5) / k_side, v = (i / k_side + 0.5) / k_side, sine = std::sqrt(u);
    const double light = 0.5 * sky_radiance(scene.sky, {sine * std::cos(2.0 * k_pi * v),
                                                        sine * std::sin(2.0 * k_pi * v), std::sqrt(1.0 - u)})
                                   .r;
    mean += light / (k_side * k_side);
    squares += light * light / (k_side * k_side);
  }
  EXPECT_NEAR(test::image_mean(film).mean, mean, 0.01 * mean);
  EXPECT_LT(sampled, 0.02 * (squares - mean * mean));
}

TEST(SkyImageLight, leaves_no_speckles_beside_mirrors_and_glass) {
  SkyPixels pixels = even_pixels(512, 256, Rgb(0.2f));
  pixel(pixels, 384, 71) = Rgb(20000.0f);  // east, 40 degrees high
  for (const Material& material :
       {Material(Metal{Rgb(0.9f), 0.05}), Material(Metal{Rgb(0.9f), 0.0}), Material(Dielectric{1.5})}) {
    Scene scene = dark_scene(camera_at({1.7, 0, 4}, {1.7, 0, 0}, 8.0, 64), 16, 8);
    scene.sky = sky_of(pixels);
    scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.5f)}}, Sphere{{0, 0, 1}, 1.0, material}};
    const Film film = render(scene, nullptr);
    float largest = 0.0f;
    for (const Rgb& color : film.color) largest = std::max(largest, color.r);
    EXPECT_LT(largest, 3.0 * test::image_mean(film).mean) << material.index();
  }
}

}  // namespace
}  // namespace alidade
