// SPDX-License-Identifier: MIT
#include "extensions/photos/point_colors.h"

#include <algorithm>
#include <cmath>

namespace alidade::visibility {
namespace {

/// 8 bits to 16.
constexpr double k_to_16_bits = 257.0;

/// A value of one channel and its weight.
struct WeightedValue {
  double value = 0.0, weight = 0.0;
};

double weighted_mean(std::span<const WeightedValue> values) {
  double sum = 0.0, weight = 0.0;
  for (const WeightedValue& each : values) {
    sum += each.weight * each.value;
    weight += each.weight;
  }
  return sum / weight;
}

/// Where the weights below and above are equal: between two values their mean.
double weighted_median(std::span<WeightedValue> values) {
  std::ranges::sort(values, {}, &WeightedValue::value);
  double all = 0.0, below = 0.0;
  for (const WeightedValue& each : values) all += each.weight;
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    below += values[i].weight;
    if (2.0 * below == all) return 0.5 * (values[i].value + values[i + 1].value);
    if (2.0 * below > all) return values[i].value;
  }
  return values.back().value;
}

/// The weights of views in falling order, the first one limited to a share of the sum of the others.
std::vector<double> balanced_weights(std::span<const ColorView> views) {
  constexpr double k_most_of_rest = 0.9;
  std::vector<double> weights;
  double rest = 0.0;
  for (const ColorView& view : views) weights.push_back(view.weight);
  for (std::size_t i = 1; i < weights.size(); ++i) rest += weights[i];
  if (weights.size() > 2) weights[0] = std::min(weights[0], k_most_of_rest * rest);
  // If all views are edge-on, all weights are 0: they become equal.
  if (!(weights[0] > 0.0)) std::ranges::fill(weights, 1.0);
  return weights;
}

}  // namespace

std::array<std::uint8_t, 3> color_at(const image::PhotoPixels& photo, const glm::dvec2& film_position) {
  const auto [width, height] = photo.size;
  const double x = std::clamp(film_position.x - 0.5, 0.0, width - 1.0);
  const double y = std::clamp(film_position.y - 0.5, 0.0, height - 1.0);
  const auto left = static_cast<std::size_t>(x), top = static_cast<std::size_t>(y);
  const std::size_t right = std::min(left + 1, static_cast<std::size_t>(width) - 1);
  const std::size_t bottom = std::min(top + 1, static_cast<std::size_t>(height) - 1);
  const double across = x - static_cast<double>(left), down = y - static_cast<double>(top);
  const auto row = static_cast<std::size_t>(width);
  std::array<std::uint8_t, 3> color{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const auto at = [&](std::size_t column, std::size_t line) {
      return static_cast<double>(photo.values[line * row + column][channel]);
    };
    const double upper = at(left, top) + across * (at(right, top) - at(left, top));
    const double lower = at(left, bottom) + across * (at(right, bottom) - at(left, bottom));
    color[channel] = static_cast<std::uint8_t>(std::lround(upper + down * (lower - upper)));
  }
  return color;
}

void add_view(const ColorView& view, ColorViews& views) {
  std::size_t at = views.size();
  while (at > 0 && views[at - 1].weight < view.weight) --at;
  if (at == views.size()) return;
  for (std::size_t i = views.size() - 1; i > at; --i) views[i] = views[i - 1];
  views[at] = view;
}

Color16 blended(const ColorViews& views) {
  const auto count = static_cast<std::size_t>(
      std::ranges::count_if(views, [](const ColorView& view) { return view.weight >= 0.0f; }));
  const std::span<const ColorView> some = std::span(views).first(count);
  const std::vector<double> weights = balanced_weights(some);
  Color16 color(0);
  for (int channel = 0; channel < 3; ++channel) {
    std::array<WeightedValue, k_color_views> values;
    for (std::size_t i = 0; i < count; ++i)
      values[i] = {k_to_16_bits * some[i].color[static_cast<std::size_t>(channel)], weights[i]};
    const std::span<WeightedValue> used = std::span(values).first(count);
    color[channel] =
        static_cast<std::uint16_t>(std::lround(count > 2 ? weighted_median(used) : weighted_mean(used)));
  }
  return color;
}

}  // namespace alidade::visibility
