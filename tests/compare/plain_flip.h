// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "compare/compared_image.h"

// FLIP as its papers define it, in double, with whole two-dimensional filters and the C library's functions:
// an oracle for compare/metrics/flip.h that shares no code with it.

namespace alidade::test {

using namespace compare;

class PlainFlip {
 public:
  PlainFlip(int width, int height, double pixels_per_degree)
      : width_(width), height_(height), pixels_per_degree_(pixels_per_degree) {}

  /// The map of two images of linear light in 0 .. 1, three values per pixel.
  std::vector<double> map(const std::vector<double>& reference, const std::vector<double>& test) const {
    const Looks one = looks(reference), other = looks(test);
    const Color green = hunt({0, 1, 0}), blue = hunt({0, 0, 1});
    const double largest = std::pow(distance(green, blue), 0.7), knee = 0.4 * largest;
    std::vector<double> map;
    for (std::size_t i = 0; i < one.colors.size(); ++i) {
      const double difference = std::pow(distance(one.colors[i], other.colors[i]), 0.7);
      const double color =
          difference < knee ? difference * 0.95 / knee : 0.95 + (difference - knee) / (largest - knee) * 0.05;
      const double feature = std::sqrt(
          std::max(std::fabs(one.edges[i] - other.edges[i]), std::fabs(one.points[i] - other.points[i])) /
          std::numbers::sqrt2);
      map.push_back(std::pow(color, 1.0 - feature));
    }
    return map;
  }

 private:
  using Color = std::array<double, 3>;
  using Weight = std::function<double(int x, int y)>;
  struct Looks {
    std::vector<Color> colors;
    std::vector<double> edges, points;
  };

  static double distance(const Color& one, const Color& other) {
    return std::fabs(one[0] - other[0]) + std::hypot(one[1] - other[1], one[2] - other[2]);
  }

  static constexpr double k_white[3] = {0.950428545, 1.0, 1.088900371};

  static Color xyz(const Color& rgb) {
    return {(10135552.0 * rgb[0] + 8788810.0 * rgb[1] + 4435075.0 * rgb[2]) / 24577794.0,
            (2613072.0 * rgb[0] + 8788810.0 * rgb[1] + 887015.0 * rgb[2]) / 12288897.0,
            (1425312.0 * rgb[0] + 8788810.0 * rgb[1] + 70074185.0 * rgb[2]) / 73733382.0};
  }

  static Color hunt(const Color& rgb) {
    const auto curve = [](double t) {
      return t > 216.0 / 24389.0 ? std::cbrt(t) : t * 841.0 / 108.0 + 4.0 / 29.0;
    };
    const Color light = xyz(rgb);
    const double x = curve(light[0] / k_white[0]), y = curve(light[1]), z = curve(light[2] / k_white[2]);
    const double lightness = 116.0 * y - 16.0;
    return {lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)};
  }

  double filtered(const std::vector<Color>& values, std::size_t channel, int x, int y, int radius,
                  const Weight& weight) const {
    double sum = 0.0;
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; ++dx) {
        const int from_x = std::clamp(x + dx, 0, width_ - 1), from_y = std::clamp(y + dy, 0, height_ - 1);
        sum += weight(dx, dy) * values[static_cast<std::size_t>(from_y) * static_cast<std::size_t>(width_) +
                                       static_cast<std::size_t>(from_x)][channel];
      }
    }
    return sum;
  }

  /// The weights divided by their sum; or positive and negative ones each by theirs.
  static Weight normalised(const Weight& weight, int radius, bool by_sign) {
    double positive = 0.0, negative = 0.0;
    std::vector<double> table;
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) {
        table.push_back(weight(x, y));
        (table.back() > 0.0 ? positive : negative) += std::fabs(table.back());
      }
    for (double& value : table) value /= by_sign ? (value > 0.0 ? positive : negative) : positive - negative;
    return [table, radius](int x, int y) {
      return table[static_cast<std::size_t>((y + radius) * (2 * radius + 1) + x + radius)];
    };
  }

  Looks looks(const std::vector<double>& rgb) const {
    std::vector<Color> opponent;
    for (std::size_t i = 0; i < rgb.size(); i += 3) {
      const Color light = xyz({rgb[i], rgb[i + 1], rgb[i + 2]});
      const double x = light[0] / k_white[0], y = light[1], z = light[2] / k_white[2];
      opponent.push_back({116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)});
    }
    // Contrast sensitivity: a1, b1, a2, b2 of each channel.
    constexpr double k_terms[3][4] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
    constexpr double k_pi = std::numbers::pi;
    const int radius =
        static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * k_pi * k_pi)) * pixels_per_degree_));
    std::array<Weight, 3> sensitivity;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double* const k = k_terms[channel];
      sensitivity[channel] = normalised(
          [&](int x, int y) {
            const double z = (x * x + y * y) / (pixels_per_degree_ * pixels_per_degree_);
            return k[0] * std::sqrt(k_pi / k[1]) * std::exp(-k_pi * k_pi * z / k[1]) +
                   k[2] * std::sqrt(k_pi / k[3]) * std::exp(-k_pi * k_pi * z / k[3]);
          },
          radius, false);
    }
    const double deviation = 0.5 * 0.082 * pixels_per_degree_;
    const int reach = static_cast<int>(std::ceil(3.0 * deviation));
    const auto bell = [&](int x, int y) {
      return std::exp(-(x * x + y * y) / (2.0 * deviation * deviation));
    };
    const Weight edge_x = normalised([&](int x, int y) { return -x * bell(x, y); }, reach, true);
    const Weight point_x = normalised(
        [&](int x, int y) { return (x * x / (deviation * deviation) - 1.0) * bell(x, y); }, reach, true);

    Looks looks;
    std::vector<Color> luminance;
    for (const Color& value : opponent) luminance.push_back({(value[0] + 16.0) / 116.0, 0, 0});
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        Color seen;
        for (std::size_t i = 0; i < 3; ++i) seen[i] = filtered(opponent, i, x, y, radius, sensitivity[i]);
        const double ly = (seen[0] + 16.0) / 116.0, lx = ly + seen[1] / 500.0, lz = ly - seen[2] / 200.0;
        const Color light{lx * k_white[0], ly, lz * k_white[2]};
        looks.colors.push_back(hunt(
            {std::clamp(3.241003275 * light[0] - 1.537398934 * light[1] - 0.498615861 * light[2], 0.0, 1.0),
             std::clamp(-0.969224334 * light[0] + 1.875930071 * light[1] + 0.041554224 * light[2], 0.0, 1.0),
             std::clamp(0.055639423 * light[0] - 0.204011202 * light[1] + 1.057148933 * light[2], 0.0,
                        1.0)}));
        const auto feature = [&](const Weight& along_x) {
          return std::hypot(
              filtered(luminance, 0, x, y, reach, along_x),
              filtered(luminance, 0, x, y, reach, [&](int dx, int dy) { return along_x(dy, dx); }));
        };
        looks.edges.push_back(feature(edge_x));
        looks.points.push_back(feature(point_x));
      }
    }
    return looks;
  }

  const int width_, height_;
  const double pixels_per_degree_;
};

}  // namespace alidade::test
