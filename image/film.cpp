// SPDX-License-Identifier: MIT
#include "image/film.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "image/srgb.h"

namespace alidade::image {

std::vector<Layer> all_layers() {
  std::vector<Layer> layers;
  for (const NamedLayer& known : k_layers) layers.push_back(known.layer);
  return layers;
}

Film::Film(int film_width, int film_height) : Film(film_width, film_height, all_layers()) {}

Film::Film(int film_width, int film_height, std::span<const Layer> layers)
    : width(film_width), height(film_height) {
  constexpr float k_infinity = std::numeric_limits<float>::infinity();
  const auto requested = [&](Layer layer) { return std::ranges::find(layers, layer) != layers.end(); };
  if (requested(Layer::color)) {
    color.assign(count(), Rgb(0.0f));
    alpha.assign(count(), 0.0f);
  }
  if (requested(Layer::variance)) variance.assign(count(), Rgb(0.0f));
  if (requested(Layer::depth)) depth.assign(count(), k_infinity);
  if (requested(Layer::distance)) distance.assign(count(), k_infinity);
  if (requested(Layer::normal)) normal.assign(count(), glm::vec3(0.0f));
  if (requested(Layer::position)) position.assign(count(), glm::dvec3(0.0));
  if (requested(Layer::albedo)) albedo.assign(count(), Rgb(0.0f));
  if (requested(Layer::id)) id.assign(count(), 0);
  if (requested(Layer::depth_sigma)) depth_sigma.assign(count(), k_infinity);
  if (requested(Layer::coverage)) coverage.assign(count(), 0.0f);
  if (requested(Layer::support)) support.assign(count(), 0);
}

bool Film::holds(Layer layer) const {
  switch (layer) {
    case Layer::color:
      return !color.empty();
    case Layer::depth:
      return !depth.empty();
    case Layer::distance:
      return !distance.empty();
    case Layer::normal:
      return !normal.empty();
    case Layer::position:
      return !position.empty();
    case Layer::albedo:
      return !albedo.empty();
    case Layer::id:
      return !id.empty();
    case Layer::variance:
      return !variance.empty();
    case Layer::depth_sigma:
      return !depth_sigma.empty();
    case Layer::coverage:
      return !coverage.empty();
    case Layer::support:
      return !support.empty();
  }
  return false;
}

bool Film::holds_any() const {
  return std::ranges::any_of(k_layers, [this](const NamedLayer& known) { return holds(known.layer); });
}

bool Film::sees_anything() const {
  const auto is_finite = [](float value) { return std::isfinite(value); };
  const auto is_set = [](const auto& value) { return value != std::decay_t<decltype(value)>(0); };
  if (!holds(Layer::color) && !holds(Layer::depth) && !holds(Layer::distance) && !holds(Layer::normal) &&
      !holds(Layer::position) && !holds(Layer::id) && !holds(Layer::coverage))
    return true;
  return std::ranges::any_of(alpha, is_set) || std::ranges::any_of(depth, is_finite) ||
         std::ranges::any_of(distance, is_finite) || std::ranges::any_of(normal, is_set) ||
         std::ranges::any_of(position, is_set) || std::ranges::any_of(id, is_set) ||
         std::ranges::any_of(coverage, is_set);
}

std::array<std::uint8_t, 3> displayed(const Film& film, std::size_t pixel, const OutputSettings& output) {
  const double scale = exposure_scale(output.exposure);
  const float alpha = output.transparent ? film.alpha[pixel] : 1.0f;
  std::array<std::uint8_t, 3> codes{};
  for (int channel = 0; channel < 3 && alpha > 0.0f; ++channel) {
    double light = film.color[pixel][channel] / alpha * scale;
    if (output.background && !output.transparent)
      light =
          std::min(light, 1.0) + (1.0 - film.alpha[pixel]) * linear_from_srgb((*output.background)[channel]);
    codes[static_cast<std::size_t>(channel)] = srgb_code(light);
  }
  return codes;
}

}  // namespace alidade::image
