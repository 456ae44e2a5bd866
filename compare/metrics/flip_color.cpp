// SPDX-License-Identifier: MIT
#include "compare/metrics/flip_color.h"

#include <cmath>

#include "base/exact_math.h"

namespace alidade {
namespace {

constexpr double k_xyz_from_rgb[3][3] = {
    {10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
    {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
    {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};
constexpr double k_rgb_from_xyz[3][3] = {{3.241003275, -1.537398934, -0.498615861},
                                         {-0.969224334, 1.875930071, 0.041554224},
                                         {0.055639423, -0.204011202, 1.057148933}};

constexpr double white(int row) {
  return k_xyz_from_rgb[row][0] + k_xyz_from_rgb[row][1] + k_xyz_from_rgb[row][2];
}

/// CIE 15: the cube root, a straight line near black.
double lab_curve(double value) {
  constexpr double k_knee = 6.0 / 29.0;
  return value > k_knee * k_knee * k_knee ? root(value, 3) : value / (3.0 * k_knee * k_knee) + 4.0 / 29.0;
}

HuntColor of_primary(int primary) {
  return hunt_color(k_xyz_from_rgb[0][primary] / white(0), k_xyz_from_rgb[1][primary] / white(1),
                    k_xyz_from_rgb[2][primary] / white(2));
}

FlipColor make_flip_color() {
  FlipColor color{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      color.xyz_from_rgb[row][column] = static_cast<float>(k_xyz_from_rgb[row][column] / white(row));
      color.rgb_from_xyz[row][column] = static_cast<float>(k_rgb_from_xyz[row][column] * white(column));
    }
  }
  // d^0.7 = (2 (d / 1024)^(1/10))^7; distances of colours are below 1024.
  const double base = 2.0 * root(color_distance(of_primary(1), of_primary(2)) / 1024.0, 10);
  const double cube = base * base * base;
  color.largest_difference = static_cast<float>(cube * cube * base);
  return color;
}

}  // namespace

HuntColor hunt_color(double x, double y, double z) {
  const double fx = lab_curve(x), fy = lab_curve(y), fz = lab_curve(z);
  const double lightness = 116.0 * fy - 16.0;
  return {lightness, 0.01 * lightness * 500.0 * (fx - fy), 0.01 * lightness * 200.0 * (fy - fz)};
}

double color_distance(const HuntColor& one, const HuntColor& other) {
  const double a = one.a - other.a, b = one.b - other.b;
  return std::fabs(one.lightness - other.lightness) + std::sqrt(a * a + b * b);
}

const FlipColor& flip_color() {
  static const FlipColor color = make_flip_color();
  return color;
}

}  // namespace alidade
