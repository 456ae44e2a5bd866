// SPDX-License-Identifier: MIT
#include "renderer/material.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "renderer/sampling.h"
#include "tests/support/random.h"

namespace alidade {

using namespace renderer;

namespace {

const Rgb k_color(0.2f, 0.5f, 0.8f);

struct Case {
  const char* name;
  Material material;
};

/// Materials whose directions have a density.
std::vector<Case> spread_materials() {
  return {{"lambertian", Lambertian{Rgb(1.0f)}},
          {"lambertian with the point's colour", Lambertian{}},
          {"rough metal", Metal{Rgb(1.0f), 1.0}},
          {"metal", Metal{Rgb(1.0f), 0.5}},
          {"smooth metal", Metal{Rgb(0.9f, 0.6f, 0.3f), 0.25}},
          {"metal with the point's colour", Metal{std::nullopt, 0.6}}};
}

/// Above, grazing, and below the surface.
std::vector<glm::dvec3> outgoing_directions() {
  std::vector<glm::dvec3> directions;
  for (const double z : {1.0, 0.8, 0.3, 0.1, -0.1, -0.6, -1.0}) {
    const double sine = std::sqrt(1.0 - z * z);
    directions.push_back({sine * 0.6, sine * 0.8, z});
  }
  return directions;
}

glm::dvec3 direction(double z, double turns) {
  const double sine = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {sine * std::cos(2 * std::numbers::pi * turns), sine * std::sin(2 * std::numbers::pi * turns), z};
}

/// Visits all directions, `refinement` x 5 `refinement` of them in each cell of even z and azimuth;
/// `function` gets the cell's index and the solid angle. Steps are even in the angle, so that narrow lobes
/// around the poles are met.
template <class Function>
void over_sphere(int rows, int columns, int refinement, const Function& function) {
  const int around = 5 * refinement;  // grazing lobes are narrow in azimuth
  const double turn_step = 1.0 / (columns * around);
  for (int i = 0; i < rows * refinement; ++i) {
    const int row = i / refinement;
    const double from = std::acos(-1.0 + 2.0 * row / rows), to = std::acos(-1.0 + 2.0 * (row + 1) / rows);
    const double step = (to - from) / refinement;
    const double angle = from + (i % refinement + 0.5) * step;
    const double solid_angle = std::abs(std::cos(angle - 0.5 * step) - std::cos(angle + 0.5 * step)) *
                               turn_step * 2.0 * std::numbers::pi;
    for (int j = 0; j < columns * around; ++j) {
      function(row * columns + j / around, direction(std::cos(angle), (j + 0.5) * turn_step), solid_angle);
    }
  }
}

TEST(Material, sample_follows_pdf_by_chi_square) {
  constexpr int k_rows = 20, k_columns = 16, k_count = 100000;
  for (const Case& test_case : spread_materials()) {
    for (const glm::dvec3& wo : outgoing_directions()) {
      std::vector<double> expected(k_rows * k_columns + 1), found(k_rows * k_columns + 1);
      over_sphere(k_rows, k_columns, 24, [&](int cell, const glm::dvec3& wi, double solid_angle) {
        expected[cell] += k_count * solid_angle * pdf(test_case.material, wo, wi);
      });
      double sum = 0.0;
      for (const double value : expected) sum += value;
      ASSERT_LT(sum, k_count * 1.001) << test_case.name << " density above 1, wo z " << wo.z;
      expected.back() = std::max(0.0, k_count - sum);  // absorbed
      test::Random random(test_case.name);
      for (int i = 0; i < k_count; ++i) {
        const auto chosen =
            sample(test_case.material, k_color, wo, {random.unit(), random.unit()}, random.unit());
        if (!chosen) {
          ++found.back();
          continue;
        }
        const glm::dvec3& v = chosen->wi;
        const double turns = std::atan2(v.y, v.x) / (2.0 * std::numbers::pi);
        const int row = std::min(k_rows - 1, static_cast<int>((v.z + 1.0) * 0.5 * k_rows));
        const int column =
            std::min(k_columns - 1, static_cast<int>((turns < 0.0 ? turns + 1.0 : turns) * k_columns));
        ++found[row * k_columns + column];
      }
      double chi_square = 0.0, pooled_expected = 0.0, pooled_found = 0.0;
      int degrees = -1;
      for (std::size_t cell = 0; cell < expected.size(); ++cell) {
        // Cells of few samples count together; the absorbed share inherits the quadrature's error and is
        // pooled as well.
        if (expected[cell] < 10.0 || cell + 1 == expected.size()) {
          pooled_expected += expected[cell];
          pooled_found += found[cell];
          continue;
        }
        chi_square += (found[cell] - expected[cell]) * (found[cell] - expected[cell]) / expected[cell];
        ++degrees;
      }
      EXPECT_NEAR(pooled_found, pooled_expected, 5.0 * std::sqrt(pooled_expected) + 0.001 * k_count)
          << test_case.name << " wo z " << wo.z;
      // Wilson and Hilferty: the cube root of chi square over its degrees of freedom is nearly normal.
      const double spread = 2.0 / (9.0 * degrees);
      const double score = (std::cbrt(chi_square / degrees) - (1.0 - spread)) / std::sqrt(spread);
      EXPECT_LT(score, 4.0) << test_case.name << " wo z " << wo.z << " chi square " << chi_square << " of "
                            << degrees;
    }
  }
}

TEST(Material, sample_weight_is_eval_over_pdf) {
  test::Random random;
  for (const Case& test_case : spread_materials()) {
    for (const glm::dvec3& wo : outgoing_directions()) {
      for (int i = 0; i < 500; ++i) {
        const auto chosen =
            sample(test_case.material, k_color, wo, {random.unit(), random.unit()}, random.unit());
        if (!chosen) continue;
        ASSERT_FALSE(chosen->specular);
        ASSERT_NEAR(glm::length(chosen->wi), 1.0, 1e-12);
        ASSERT_NEAR(pdf(test_case.material, wo, chosen->wi) / chosen->pdf, 1.0, 1e-6) << test_case.name;
        const Rgb value = eval(test_case.material, k_color, wo, chosen->wi);
        for (int channel = 0; channel < 3; ++channel) {
          ASSERT_NEAR(value[channel] / chosen->pdf, chosen->weight[channel], 1e-4) << test_case.name;
        }
      }
    }
  }
}

TEST(Material, scatters_no_more_light_than_arrives) {
  for (const Case& test_case : spread_materials()) {
    for (const glm::dvec3& wo : outgoing_directions()) {
      glm::dvec3 share(0.0);
      over_sphere(1, 1, 500, [&](int, const glm::dvec3& wi, double solid_angle) {
        share += solid_angle * glm::dvec3(eval(test_case.material, k_color, wo, wi));
      });
      for (int channel = 0; channel < 3; ++channel) {
        EXPECT_LE(share[channel], 1.001) << test_case.name << " wo z " << wo.z;
        EXPECT_GT(share[channel], 0.05) << test_case.name << " wo z " << wo.z;
      }
    }
  }
}

TEST(Material, is_reciprocal) {
  test::Random random;
  for (const Case& test_case : spread_materials()) {
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec3 a = glm::normalize(random.direction()), b = glm::normalize(random.direction());
      const Rgb there = eval(test_case.material, k_color, a, b),
                back = eval(test_case.material, k_color, b, a);
      for (int channel = 0; channel < 3; ++channel) {
        const double f = there[channel] / std::abs(b.z), g = back[channel] / std::abs(a.z);
        ASSERT_NEAR(f, g, 1e-5 * std::max(f, g)) << test_case.name;
      }
    }
  }
}

TEST(Material, opaque_materials_let_no_light_through) {
  for (const Case& test_case : spread_materials()) {
    EXPECT_EQ(eval(test_case.material, k_color, {0, 0, 1}, {0, 0, -1}), Rgb(0.0f));
    EXPECT_EQ(pdf(test_case.material, {0, 0.6, -0.8}, {0, 0.6, 0.8}), 0.0);
  }
}

TEST(Material, mirror_reflects_in_one_direction_and_returns_all_light_of_a_white_mirror) {
  const Material mirror = Metal{Rgb(1.0f), 0.0};
  const auto chosen = sample(mirror, k_color, {0.6, 0.0, 0.8}, {0.3, 0.7}, 0.5);
  ASSERT_TRUE(chosen);
  EXPECT_TRUE(chosen->specular);
  EXPECT_EQ(chosen->wi, glm::dvec3(-0.6, 0.0, 0.8));
  EXPECT_EQ(chosen->weight, Rgb(1.0f));
  EXPECT_EQ(eval(mirror, k_color, {0.6, 0.0, 0.8}, {-0.6, 0.0, 0.8}), Rgb(0.0f));
  EXPECT_EQ(sample(Metal{std::nullopt, 0.0}, k_color, {0, 0, 1}, {0.3, 0.7}, 0.5)->weight, k_color);
}

TEST(Material, metal_reflects_by_the_fifth_power_of_schlick) {
  // A white metal of the same roughness has the rest of the formula alone.
  for (const double cosine : {0.9, 0.5, 0.2}) {
    const double sine = std::sqrt(1.0 - cosine * cosine);
    const glm::dvec3 wo{sine, 0.0, cosine}, wi{-sine, 0.0, cosine};
    const double dark = eval(Metal{Rgb(0.2f), 0.5}, k_color, wo, wi).r,
                 white = eval(Metal{Rgb(1.0f), 0.5}, k_color, wo, wi).r;
    EXPECT_NEAR(dark / white, 0.2 + 0.8 * std::pow(1.0 - cosine, 5.0), 1e-6) << cosine;
  }
}

TEST(Material, fresnel_reflectance_has_its_known_limits) {
  EXPECT_NEAR(fresnel_reflectance(1.0, 1.5), 0.04, 1e-15);        // ((n - 1) / (n + 1))^2
  EXPECT_NEAR(fresnel_reflectance(1.0, 1.0 / 1.5), 0.04, 1e-15);  // the same from inside
  EXPECT_NEAR(fresnel_reflectance(1e-9, 1.5), 1.0, 1e-7);         // grazing
  EXPECT_NEAR(fresnel_reflectance(0.3, 1.0), 0.0, 1e-30);         // no boundary
  // Beyond the critical angle everything is reflected: sin = 1 / 1.5.
  const double critical_cosine = std::sqrt(1.0 - 1.0 / 2.25);
  EXPECT_EQ(fresnel_reflectance(critical_cosine - 1e-9, 1.0 / 1.5), 1.0);
  EXPECT_LT(fresnel_reflectance(critical_cosine + 1e-3, 1.0 / 1.5), 0.9);
  // Brewster's angle tan = n: parallel light is not reflected, so half of the rest is ((n^2 - 1) / (n^2 +
  // 1))^2 / 2.
  const double brewster = 1.0 / std::sqrt(1.0 + 2.25);
  EXPECT_NEAR(fresnel_reflectance(brewster, 1.5), 0.5 * std::pow(1.25 / 3.25, 2), 1e-15);
}

TEST(Material, glass_obeys_snells_law_and_conserves_light) {
  test::Random random;
  const Material glass = Dielectric{1.5};
  for (int i = 0; i < 5000; ++i) {
    const glm::dvec3 wo = glm::normalize(random.direction());
    const auto chosen = sample(glass, k_color, wo, {random.unit(), random.unit()}, random.unit());
    ASSERT_TRUE(chosen && chosen->specular);
    ASSERT_EQ(chosen->weight, Rgb(1.0f));
    if (chosen->wi.z * wo.z > 0.0) {
      ASSERT_EQ(chosen->wi, glm::dvec3(-wo.x, -wo.y, wo.z));
    } else {
      const double index = wo.z > 0.0 ? 1.5 : 1.0 / 1.5;
      ASSERT_NEAR(chosen->wi.x * index, -wo.x, 1e-12);
      ASSERT_NEAR(chosen->wi.y * index, -wo.y, 1e-12);
    }
  }
}

TEST(Material, glass_reflects_as_often_as_fresnel_says) {
  const glm::dvec3 wo = direction(0.2, 0.1);
  const double share = fresnel_reflectance(0.2, 1.5);
  EXPECT_GT(sample(Material(Dielectric{1.5}), k_color, wo, {0, 0}, share - 1e-9)->wi.z, 0.0);
  EXPECT_LT(sample(Material(Dielectric{1.5}), k_color, wo, {0, 0}, share + 1e-9)->wi.z, 0.0);
}

TEST(Material, emissive_reflects_nothing) {
  const Material lamp = Emissive{};
  EXPECT_FALSE(sample(lamp, k_color, {0, 0, 1}, {0.5, 0.5}, 0.5));
  EXPECT_EQ(eval(lamp, k_color, {0, 0, 1}, {0, 0, 1}), Rgb(0.0f));
  EXPECT_EQ(albedo(lamp, k_color), Rgb(0.0f));
}

}  // namespace
}  // namespace alidade
