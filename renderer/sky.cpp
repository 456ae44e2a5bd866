// SPDX-License-Identifier: MIT
#include "renderer/sky.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/exact_math.h"
#include "renderer/sampling.h"

namespace alidade::renderer {
namespace {

double luminance(const Rgb& color) {
  return 0.2126 * double{color.r} + 0.7152 * double{color.g} + 0.0722 * double{color.b};
}

/// The first step whose sum lies above `target`, and how far into it the target lies, [0, 1).
struct Chosen {
  int index = 0;
  double inside = 0.0;
};

Chosen choose(const double* sums, int count, double u) {
  const double target = u * sums[count - 1];
  // Rounding may lift the target to the last sum.
  const int index =
      std::min(static_cast<int>(std::upper_bound(sums, sums + count, target) - sums), count - 1);
  const double before = index > 0 ? sums[index - 1] : 0.0, step = sums[index] - before;
  const double inside = step > 0.0 ? (target - before) / step : 0.0;
  return {index, std::clamp(inside, 0.0, 1.0 - 0x1p-32)};
}

/// A number in [0, 1] whose density goes in a straight line from one value to the other.
double sample_line(double u, double from, double to) {
  const double end = from + std::sqrt(from * from + u * (to * to - from * from));
  return end > 0.0 ? std::fmin(u * (from + to) / end, 1.0) : u;
}

double between(double from, double to, double share) {
  return from + share * (to - from);
}

}  // namespace

SkyImage::SkyImage(image::SkyPixels pixels, double scale, double rotation)
    : pixels_(std::move(pixels)), turns_(rotation / 360.0) {
  const int width = pixels_.width, height = pixels_.height;
  assert(width > 0 && height > 0);
  assert(pixels_.values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (Rgb& each : pixels_.values) each *= static_cast<float>(scale);

  sines_.push_back(1.0);
  for (int row = 0; row < height; ++row)
    sines_.push_back(sine_cosine_of_turns(0.25 - 0.5 * (row + 0.5) / height).sine);
  sines_.push_back(-1.0);
  const double turn = 2.0 * k_pi / width;
  columns_.reserve(static_cast<std::size_t>(width) * (static_cast<std::size_t>(height) + 1));
  for (int row = 0; row <= height; ++row) {
    double sum = 0.0;
    for (int column = 0; column < width; ++column) {
      sum += 0.25 * (luminance(value(column, row - 1)) + luminance(value(column + 1, row - 1)) +
                     luminance(value(column, row)) + luminance(value(column + 1, row)));
      columns_.push_back(sum);
    }
    const auto index = static_cast<std::size_t>(row);
    total_ += sum * turn * (sines_[index] - sines_[index + 1]);
    rows_.push_back(total_);
  }
}

const Rgb& SkyImage::value(int column, int row) const {
  const int there = column < pixels_.width ? column : 0;
  const int inside = std::clamp(row, 0, pixels_.height - 1);
  return pixels_.values[static_cast<std::size_t>(inside) * static_cast<std::size_t>(pixels_.width) +
                        static_cast<std::size_t>(there)];
}

SkyImage::Position SkyImage::position_of(const glm::dvec3& direction) const {
  const double azimuth = angle_of(direction.x, direction.y) / (2.0 * k_pi);
  const double level = std::sqrt(direction.x * direction.x + direction.y * direction.y);
  const double elevation = angle_of(direction.z, level);
  // In pixels, from the middle of the first column and half a pixel above the image.
  const double turn = azimuth - turns_ + 0.5 - 0.5 / pixels_.width;
  const double x = (turn - std::floor(turn)) * pixels_.width;
  const double y = (0.5 - elevation / k_pi) * pixels_.height + 0.5;
  Position position;
  position.column = std::min(static_cast<int>(x), pixels_.width - 1);
  position.row = std::clamp(static_cast<int>(y), 0, pixels_.height);
  position.x = std::fmin(x - position.column, 1.0);
  const double top = sines_[static_cast<std::size_t>(position.row)],
               bottom = sines_[static_cast<std::size_t>(position.row) + 1];
  position.y = std::clamp((top - direction.z) / (top - bottom), 0.0, 1.0);
  return position;
}

Rgb SkyImage::interpolated(const Position& position) const {
  const auto x = static_cast<float>(position.x), y = static_cast<float>(position.y);
  const auto along = [&](int row) {
    return value(position.column, row) * (1.0f - x) + value(position.column + 1, row) * x;
  };
  return along(position.row - 1) * (1.0f - y) + along(position.row) * y;
}

double SkyImage::pdf_of(const Rgb& radiance) const {
  return is_black() ? 0.0 : luminance(radiance) / total_;
}

SkySample SkyImage::sample(const glm::dvec2& u) const {
  const Chosen row = choose(rows_.data(), pixels_.height + 1, u.y);
  const std::size_t first = static_cast<std::size_t>(row.index) * static_cast<std::size_t>(pixels_.width);
  const Chosen column = choose(&columns_[first], pixels_.width, u.x);
  const double top_left = luminance(value(column.index, row.index - 1)),
               top_right = luminance(value(column.index + 1, row.index - 1)),
               bottom_left = luminance(value(column.index, row.index)),
               bottom_right = luminance(value(column.index + 1, row.index));
  Position position{.column = column.index, .row = row.index};
  position.y = sample_line(row.inside, top_left + top_right, bottom_left + bottom_right);
  position.x = sample_line(column.inside, between(top_left, bottom_left, position.y),
                           between(top_right, bottom_right, position.y));

  const double sine = between(sines_[static_cast<std::size_t>(row.index)],
                              sines_[static_cast<std::size_t>(row.index) + 1], position.y);
  const double level = std::sqrt(std::fmax(0.0, 1.0 - sine * sine));
  const SineCosine azimuth =
      sine_cosine_of_turns((column.index + position.x + 0.5) / pixels_.width - 0.5 + turns_);
  const Rgb radiance_there = interpolated(position);
  return {{azimuth.sine * level, azimuth.cosine * level, sine}, radiance_there, pdf_of(radiance_there)};
}

}  // namespace alidade::renderer
