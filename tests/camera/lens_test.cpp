// SPDX-License-Identifier: MIT
#include "camera/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

#include "camera/camera.h"
#include "camera/projection.h"
#include "tests/camera/lens_cases.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace image;
using namespace camera;

namespace {

// The formulas once more, straight from docs/cameras.md with the C library's functions: what the lenses must
// agree with.

using Formula = std::function<glm::dvec2(double u, double v)>;

/// Film positions of random directions up to `widest` radians off the axis.
void expect_formula(const Lens& lens, const Formula& formula, double widest) {
  Random random;
  const LensMap map(lens);
  for (int i = 0; i < 2000; ++i) {
    const double theta = random.between(0.0, widest), phi = random.between(-4.0, 4.0);
    const glm::dvec3 direction(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                               std::cos(theta));
    const auto film = map.project(direction * random.between(0.1, 100.0));
    ASSERT_TRUE(film) << theta;
    const glm::dvec2 expected = formula(direction.x / direction.z, direction.y / direction.z);
    ASSERT_NEAR(film->x, expected.x, 1e-13 * (1.0 + std::fabs(expected.x)));
    ASSERT_NEAR(film->y, expected.y, 1e-13 * (1.0 + std::fabs(expected.y)));
  }
}

TEST(Lens, pinhole_is_its_formula) {
  expect_formula(
      PinholeLens{}, [](double u, double v) { return glm::dvec2(u, v); }, 1.5);
}

TEST(Lens, brown_is_opencvs_formula) {
  const double k1 = -0.28, k2 = 0.09, k3 = -0.01, k4 = 0.02, k5 = 0.03, k6 = 0.01, p1 = 0.0012, p2 = -0.0021;
  expect_formula(
      BrownLens{{.radial = {k1, k2, k3}, .denominator = {k4, k5, k6}, .p1 = p1, .p2 = p2}},
      [=](double u, double v) {
        const double r2 = u * u + v * v;
        const double f = (1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2) /
                         (1 + k4 * r2 + k5 * r2 * r2 + k6 * r2 * r2 * r2);
        return glm::dvec2(u * f + 2 * p1 * u * v + p2 * (r2 + 2 * u * u),
                          v * f + 2 * p2 * u * v + p1 * (r2 + 2 * v * v));
      },
      0.7);
}

TEST(Lens, fisheye_is_opencvs_formula) {
  const double k1 = -0.02, k2 = 0.004, k3 = -0.0006, k4 = 0.00003;
  expect_formula(
      FisheyeLens{{.radial = {k1, k2, k3, k4}}},
      [=](double u, double v) {
        const double r = std::sqrt(u * u + v * v), theta = std::atan(r), q = theta * theta;
        const double d = theta * (1 + k1 * q + k2 * q * q + k3 * q * q * q + k4 * q * q * q * q);
        return glm::dvec2(u, v) * (r > 0.0 ? d / r : 1.0);
      },
      1.5);
}

TEST(Lens, fisheye_with_thin_prism_is_colmaps_formula) {
  const double k1 = -0.02, k2 = 0.004, p1 = 0.002, p2 = -0.001, sx1 = 0.003, sy1 = -0.002;
  expect_formula(
      FisheyeLens{{.radial = {k1, k2}, .p1 = p1, .p2 = p2, .prism = {sx1, 0.0, sy1, 0.0}}},
      [=](double u, double v) {
        const double r = std::sqrt(u * u + v * v), theta = std::atan(r);
        const double a = r > 0 ? u * theta / r : u, b = r > 0 ? v * theta / r : v;
        const double q = a * a + b * b, l = k1 * q + k2 * q * q;
        return glm::dvec2(a + a * l + 2 * p1 * a * b + p2 * (q + 2 * a * a) + sx1 * q,
                          b + b * l + 2 * p2 * a * b + p1 * (q + 2 * b * b) + sy1 * q);
      },
      1.4);
}

TEST(Lens, fisheye_may_bend_after_its_radial_part) {
  const std::array<double, 6> k{0.03, -0.02, 0.01, -0.004, 0.0008, -0.00006};
  const double p0 = 0.002, p1 = -0.001, s0 = 0.003, s1 = -0.0003, s2 = -0.002, s3 = 0.0004;
  expect_formula(
      FisheyeLens{{.radial = k, .p1 = p1, .p2 = p0, .prism = {s0, s1, s2, s3}, .after_radial = true}},
      [=](double u, double v) {
        const double r = std::sqrt(u * u + v * v), theta = std::atan(r);
        const double a = r > 0 ? u * theta / r : u, b = r > 0 ? v * theta / r : v, q = a * a + b * b;
        double f = 1;
        for (int i = 0; i < 6; ++i) f += k[i] * std::pow(q, i + 1);
        const double c = a * f, d = b * f, s = c * c + d * d;
        return glm::dvec2(c + 2 * p1 * c * d + p0 * (s + 2 * c * c) + s0 * s + s1 * s * s,
                          d + 2 * p0 * c * d + p1 * (s + 2 * d * d) + s2 * s + s3 * s * s);
      },
      1.4);
}

TEST(Lens, field_of_view_is_its_formula) {
  const double omega = 0.93;
  expect_formula(
      FieldOfViewLens{omega},
      [=](double u, double v) {
        const double r = std::sqrt(u * u + v * v);
        return glm::dvec2(u, v) * (std::atan(2 * r * std::tan(omega / 2)) / (r * omega));
      },
      1.5);
}

TEST(Lens, division_is_its_formula) {
  const double k = -0.3;
  expect_formula(
      DivisionLens{k},
      [=](double u, double v) {
        return glm::dvec2(u, v) * (2 / (1 + std::sqrt(1 - 4 * k * (u * u + v * v))));
      },
      1.5);
}

TEST(Lens, unified_is_its_formula) {
  const double alpha = 0.6, beta = 1.1;
  expect_formula(
      UnifiedLens{alpha, beta},
      [=](double u, double v) {
        return glm::dvec2(u, v) / (alpha * std::sqrt(beta * (u * u + v * v) + 1) + 1 - alpha);
      },
      1.5);
}

TEST(Lens, dual_is_opensfms_formula) {
  const double l = 0.4, k1 = -0.03, k2 = 0.004;
  expect_formula(
      DualLens{l, {.radial = {k1, k2}}},
      [=](double u, double v) {
        const double r = std::sqrt(u * u + v * v), theta = std::atan(r);
        const glm::dvec2 mix = glm::dvec2(u, v) * (l + (1 - l) * theta / r);
        const double m = mix.x * mix.x + mix.y * mix.y;
        return mix * (1 + k1 * m + k2 * m * m);
      },
      1.0);
}

TEST(Lens, equirectangular_is_longitude_and_latitude) {
  Random random;
  const LensMap map(EquirectangularLens{});
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 at = random.direction() * random.between(0.1, 10.0);
    const auto film = map.project(at);
    ASSERT_TRUE(film);
    EXPECT_NEAR(film->x, std::atan2(at.x, at.z), 1e-14);
    EXPECT_NEAR(film->y, -std::atan2(-at.y, std::hypot(at.x, at.z)), 1e-14);
  }
}

TEST(Lens, round_trip_over_the_whole_image_is_below_a_billionth_of_a_pixel) {
  for (const auto& [name, camera] : lens_cases()) {
    ASSERT_NO_THROW(check_camera(camera)) << name;
    const Projection projection(camera);
    double worst = 0.0;
    for (int y = 0; y <= 480; y += 5) {
      for (int x = 0; x <= 640; x += 5) {
        // The outermost edge of a panorama is its other edge, or a pole.
        const bool edge = x == 0 || y == 0 || x == 640 || y == 480;
        const glm::dvec2 film =
            edge && name == "equirectangular" ? glm::dvec2(x + 0.5, y + 0.5) : glm::dvec2(x, y);
        if (film.x > 640.0 || film.y > 480.0) continue;
        const auto ray = projection.ray(film);
        ASSERT_TRUE(ray) << name << " " << x << " " << y;
        ASSERT_NEAR(glm::length(ray->direction), 1.0, 1e-15);
        const auto back = projection.project(ray->position(10.0));
        ASSERT_TRUE(back) << name << " " << x << " " << y;
        worst = std::max(worst, glm::length(*back - film));
      }
    }
    EXPECT_LT(worst, 1e-9) << name;
  }
}

TEST(Lens, the_way_from_the_world_comes_back_too) {
  Random random;
  for (const auto& [name, camera] : lens_cases()) {
    const Projection projection(camera);
    for (int i = 0; i < 500; ++i) {
      const glm::dvec3 world = camera.pose.position + random.direction() * random.between(1.0, 20.0);
      const auto film = projection.project(world);
      if (!film || film->x < 0 || film->y < 0 || film->x > 640 || film->y > 480) continue;
      const auto ray = projection.ray(*film);
      ASSERT_TRUE(ray) << name;
      const glm::dvec3 offset = world - ray->origin;
      ASSERT_LT(glm::length(glm::cross(offset, ray->direction)), 1e-11) << name;
      ASSERT_GT(glm::dot(offset, ray->direction), 0.0) << name;
    }
  }
}

std::string error_of(const Camera& camera) {
  try {
    check_camera(camera);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

Camera with_lens(const Lens& lens, double focal_length) {
  return {.width = 640,
          .height = 480,
          .fx = focal_length,
          .fy = focal_length,
          .cx = 320,
          .cy = 240,
          .pose = {},
          .lens = lens};
}

// r (1 + k r^2) turns round at r = 1 / sqrt(-3 k), where it is 2/3 r.
TEST(Lens, a_fold_inside_the_image_is_an_error_that_names_its_radius) {
  const double k = -0.5, turning = 1.0 / std::sqrt(-3.0 * k);
  const double pixels = 500.0 * turning * 2.0 / 3.0;
  const std::string text = error_of(with_lens(BrownLens{{.radial = {k}}}, 500.0));
  EXPECT_NE(text.find("folds over at 272.166 pixels from the principal point, 39.23 degrees off the axis"),
            std::string::npos)
      << text << pixels;
  EXPECT_NEAR(pixels, 272.166, 1e-3);
  EXPECT_NEAR(std::atan(turning) * 180.0 / std::numbers::pi, 39.23, 0.005);
  // A longer lens keeps the fold outside.
  EXPECT_EQ(error_of(with_lens(BrownLens{{.radial = {k}}}, 740.0)), "no error");
  EXPECT_NE(error_of(with_lens(BrownLens{{.radial = {k}}}, 730.0)), "no error");
}

TEST(Lens, folds_of_every_kind_are_found) {
  EXPECT_NE(error_of(with_lens(BrownLens{{.denominator = {-2.0}}}, 300.0)).find("folds over"),
            std::string::npos);
  EXPECT_NE(error_of(with_lens(BrownLens{{.p1 = 0.5}}, 300.0)).find("folds over"), std::string::npos);
  EXPECT_NE(error_of(with_lens(FisheyeLens{{.radial = {-0.2}}}, 200.0)).find("folds over"),
            std::string::npos);
  EXPECT_NE(error_of(with_lens(DivisionLens{2.0}, 300.0)).find("folds over"), std::string::npos);
  EXPECT_NE(error_of(with_lens(DualLens{0.5, {.radial = {-0.5}}}, 300.0)).find("folds over"),
            std::string::npos);
}

/// The film position of docs/cameras.md, in long double.
std::array<long double, 2> distorted(const Distortion& lens, long double x, long double y) {
  const long double q = x * x + y * y;
  const auto polynomial = [q](const auto& coefficients) {
    long double value = 1.0L, power = q;
    for (const double each : coefficients) value += each * power, power *= q;
    return value;
  };
  const long double factor = polynomial(lens.radial) / polynomial(lens.denominator), c = x * factor,
                    d = y * factor;
  const long double a = lens.after_radial ? c : x, b = lens.after_radial ? d : y, s = a * a + b * b;
  return {c + 2 * lens.p1 * a * b + lens.p2 * (s + 2 * a * a) + lens.prism[0] * s + lens.prism[1] * s * s,
          d + 2 * lens.p2 * a * b + lens.p1 * (s + 2 * b * b) + lens.prism[2] * s + lens.prism[3] * s * s};
}

/// By what a small patch of the film grows, from differences of the formula.
long double growth_of_area(const Distortion& lens, long double x, long double y) {
  constexpr long double k_step = 1e-5L;
  const auto right = distorted(lens, x + k_step, y), left = distorted(lens, x - k_step, y);
  const auto below = distorted(lens, x, y + k_step), above = distorted(lens, x, y - k_step);
  return ((right[0] - left[0]) * (below[1] - above[1]) - (right[1] - left[1]) * (below[0] - above[0])) /
         (4 * k_step * k_step);
}

// Newton's method converges with wrong derivatives, too; only the right ones show where a lens folds.
TEST(Lens, the_film_ends_where_a_patch_of_it_loses_its_area) {
  Random random;
  for (int part = 0; part < 8; ++part) {
    int folded = 0, flat = 0;
    for (int i = 0; i < 4000; ++i) {
      // One coefficient alone, or all of them; the radial part itself grows.
      const auto strong = [&](int which) {
        const double most = which < 2 ? 0.5 : 2.0;
        return part == which || part >= 6 ? random.between(-most, most) : 0.0;
      };
      Distortion lens{.radial = {0.2, 0.1, 0.05}, .denominator = {0.1, 0.02}};
      lens.p1 = strong(0), lens.p2 = strong(1);
      lens.prism = {strong(2), strong(3), strong(4), strong(5)};
      lens.after_radial = part == 7;
      const double x = random.between(-1.5, 1.5), y = random.between(-1.5, 1.5);
      const long double growth = growth_of_area(lens, x, y);
      if (std::fabs(growth) < 1e-6L) continue;
      ASSERT_EQ(LensMap(BrownLens{lens}).project({x, y, 1.0}).has_value(), growth > 0)
          << part << " " << x << " " << y << " " << static_cast<double>(growth);
      ++(growth > 0 ? flat : folded);
    }
    EXPECT_GT(folded, 100) << part;
    EXPECT_GT(flat, 100) << part;
  }
}

// What lies beyond the fold would appear inside the image again.
TEST(Lens, nothing_is_projected_from_beyond_the_fold) {
  const LensMap map(BrownLens{{.radial = {-0.5}}});
  const double turning = 1.0 / std::sqrt(1.5);
  EXPECT_TRUE(map.project({0.999 * turning, 0.0, 1.0}));
  EXPECT_FALSE(map.project({1.001 * turning, 0.0, 1.0}));
  EXPECT_FALSE(map.project({0.0, 1.4, 1.0}));
}

TEST(Lens, a_circular_fisheye_has_no_view_outside_its_circle_and_that_is_no_error) {
  const Camera camera = with_lens(FisheyeLens{}, 70.0);
  EXPECT_EQ(error_of(camera), "no error");
  const Projection projection(camera);
  EXPECT_TRUE(projection.ray({320.0 + 70.0 * 3.14, 240.0}));
  EXPECT_FALSE(projection.ray({320.0 + 70.0 * 3.15, 240.0}));
  EXPECT_NEAR(projection.ray({320.0 + 70.0 * 3.14, 240.0})->direction.y, -1.0, 1e-5);  // straight back
}

TEST(Lens, nothing_is_seen_from_behind_by_lenses_of_half_a_sphere) {
  for (const Lens& lens : {Lens(PinholeLens{}), Lens(BrownLens{}), Lens(FieldOfViewLens{1.0}),
                           Lens(DivisionLens{0.1}), Lens(DualLens{}), Lens(OrthographicLens{})}) {
    EXPECT_FALSE(LensMap(lens).project({0.1, 0.2, -1.0})) << lens.index();
    EXPECT_TRUE(LensMap(lens).project({0.1, 0.2, 1.0})) << lens.index();
  }
  EXPECT_TRUE(LensMap(FisheyeLens{}).project({0.1, 0.2, -1.0}));
  EXPECT_TRUE(LensMap(EquirectangularLens{}).project({0.1, 0.2, -1.0}));
}

TEST(Lens, parallel_rays_start_in_the_cameras_plane) {
  Camera camera = with_lens(OrthographicLens{}, 10.0);
  camera.pose = look_at({0, 0, 100}, {0, 0, 0}, {0, 1, 0});
  const Ray ray = camera_ray(camera, {0.5, 0.5});
  EXPECT_NEAR(glm::length(ray.origin - glm::dvec3(-31.95, 23.95, 100.0)), 0.0, 1e-12);
  EXPECT_EQ(ray.direction, glm::dvec3(0.0, 0.0, -1.0));
  EXPECT_EQ(ray.t_min, 0.0);
}

TEST(Lens, parameters_outside_their_range_are_errors) {
  Camera camera = with_lens(PinholeLens{}, 500.0);
  const auto changed = [&](auto change) {
    Camera each = camera;
    change(each);
    return error_of(each);
  };
  EXPECT_EQ(error_of(camera), "no error");
  EXPECT_NE(changed([](Camera& c) {
              c.fx = 0.0;
            }).find("focal length out of range; expected a positive number, found 0"),
            std::string::npos);
  EXPECT_NE(changed([](Camera& c) { c.fy = -3.0; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.fx = NAN; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.cx = INFINITY; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.width = 0; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.height = 70000; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.pose.position.x = NAN; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.lens = FieldOfViewLens{3.2}; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.lens = UnifiedLens{1.1, 1.0}; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.lens = UnifiedLens{0.5, 0.0}; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.lens = BrownLens{{.p1 = NAN}}; }), "no error");
  EXPECT_NE(changed([](Camera& c) { c.lens = DualLens{1.5, {}}; }), "no error");
}

TEST(Lens, a_resized_camera_sees_the_same_in_the_same_share_of_the_image) {
  for (const auto& [name, camera] : lens_cases()) {
    const Camera large = resized(camera, 1280, 960);
    for (const glm::dvec2& film : {glm::dvec2(10.0, 20.0), glm::dvec2(600.5, 401.25)}) {
      const auto expected = Projection(camera).ray(film), found = Projection(large).ray(2.0 * film);
      ASSERT_TRUE(expected && found) << name;
      EXPECT_LT(glm::length(expected->direction - found->direction), 1e-12) << name;
      EXPECT_LT(glm::length(expected->origin - found->origin), 1e-12) << name;
    }
  }
}

}  // namespace
}  // namespace alidade::test
