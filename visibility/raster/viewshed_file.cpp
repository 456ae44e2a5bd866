// SPDX-License-Identifier: MIT
#include "visibility/raster/viewshed_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace alidade::visibility {
namespace {

constexpr image::Rgb8 k_seen{255, 205, 70}, k_hidden{96, 106, 132}, k_beyond{214, 214, 210};

bool has_value(float value) {
  return value != k_out_of_range && !std::isnan(value);
}

/// The largest byte that has no other meaning.
std::uint8_t free_byte(const SeenValues& values) {
  for (int byte = 255;; --byte) {
    if (byte != values.visible && byte != values.invisible && byte != values.out_of_range)
      return static_cast<std::uint8_t>(byte);
  }
}

/// Each value as `number_of` has it.
template <class Number, class NumberOf>
std::vector<Number> converted(const Viewshed& viewshed, const NumberOf& number_of) {
  std::vector<Number> numbers(viewshed.values.values.size());
  std::ranges::transform(viewshed.values.values, numbers.begin(), number_of);
  return numbers;
}

template <class Number>
std::vector<Number> numbers_of(const Viewshed& viewshed, double no_data) {
  return converted<Number>(viewshed, [&](float value) {
    return has_value(value) ? static_cast<Number>(value) : static_cast<Number>(no_data);
  });
}

const char* description_of(ViewshedMode mode, bool of_objects) {
  switch (mode) {
    case ViewshedMode::visible:
      return of_objects ? "any part of an object is visible" : "visible from an observer";
    case ViewshedMode::count:
      return of_objects ? "number of objects that are visible" : "number of observers that see the cell";
    case ViewshedMode::height:
      return "lowest visible height above the ground";
    case ViewshedMode::size:
      return "visible size of the objects";
    case ViewshedMode::angle:
      return "solid angle of the visible parts of the objects";
    case ViewshedMode::fraction:
      break;
  }
  return of_objects ? "visible share of the objects" : "share of free lines of sight";
}

std::string title_of(ViewshedMode mode, std::size_t observers) {
  const std::string who = observers == 1 ? "one observer" : fmt::format("{} observers", observers);
  switch (mode) {
    case ViewshedMode::visible:
      return "Seen by " + (observers == 1 ? who : "any of " + who);
    case ViewshedMode::count:
      return "How many of " + who + " see it";
    case ViewshedMode::height:
      return "Height from which " + who + (observers == 1 ? " sees it" : " see it");
    default:
      return "Share of sight lines of " + who + " that are free";
  }
}

std::string title_of_objects(ViewshedMode mode, std::size_t objects) {
  const std::string what = objects == 1 ? "one object" : fmt::format("{} objects", objects);
  switch (mode) {
    case ViewshedMode::visible:
      return "Where " + (objects == 1 ? what : "any of " + what) + " is visible";
    case ViewshedMode::count:
      return "How many of " + what + " are visible";
    case ViewshedMode::size:
      return "How much of " + what + " is visible";
    case ViewshedMode::angle:
      return "Solid angle of " + what;
    default:
      return "Visible share of " + what;
  }
}

/// Unit of the values; empty: none, or unknown.
std::string unit_of(const ViewshedOptions& options, const std::string& length_unit) {
  if (options.mode == ViewshedMode::angle) return "sr";
  if (options.mode == ViewshedMode::height) return length_unit;
  if (options.mode != ViewshedMode::size || length_unit.empty()) return "";
  return options.pieces.front().width > 0.0 ? length_unit + "2" : length_unit;
}

}  // namespace

geo::RasterBand ViewshedBand::band() const {
  geo::RasterBand result{.values = {}, .no_data = no_data, .description = description, .unit = unit};
  std::visit(
      [&](const auto& all) {
        result.values = std::span<const typename std::decay_t<decltype(all)>::value_type>(all);
      },
      values);
  return result;
}

ViewshedBand viewshed_band(const Viewshed& viewshed, const ViewshedOptions& options,
                           const SeenValues& seen_values, std::size_t observer_count,
                           const std::string& length_unit) {
  constexpr double k_no_float = -9999.0;
  const ViewshedMode mode = options.mode;
  ViewshedBand result{.values = {},
                      .description = description_of(mode, !options.pieces.empty()),
                      .unit = unit_of(options, length_unit)};
  if (mode == ViewshedMode::visible) {
    const std::uint8_t none = free_byte(seen_values);
    result.no_data = none;
    result.values = converted<std::uint8_t>(viewshed, [&](float value) {
      if (std::isnan(value)) return none;
      if (value == k_out_of_range) return seen_values.out_of_range.value_or(none);
      return value > 0.0f ? seen_values.visible : seen_values.invisible;
    });
  } else if (mode == ViewshedMode::count) {
    constexpr double k_short = std::numeric_limits<std::uint16_t>::max();
    constexpr double k_long = std::numeric_limits<std::uint32_t>::max();
    const bool fits = static_cast<double>(observer_count) < k_short;
    result.no_data = fits ? k_short : k_long;
    if (fits)
      result.values = numbers_of<std::uint16_t>(viewshed, k_short);
    else
      result.values = numbers_of<std::uint32_t>(viewshed, k_long);
  } else {
    result.no_data = k_no_float;
    result.values = numbers_of<float>(viewshed, k_no_float);
  }
  return result;
}

MapImage viewshed_image(const Viewshed& viewshed, const ViewshedOptions& options,
                        std::span<const Observer> observers, const std::string& length_unit) {
  const ViewshedMode mode = options.mode;
  const double lowest = options.target_height, highest = options.highest;
  const bool of_objects = !options.pieces.empty();
  MapImage image{
      .title = of_objects ? title_of_objects(mode, observers.size()) : title_of(mode, observers.size()),
      .values = viewshed.values};
  image.unit = length_unit;
  for (const Observer& observer : observers)
    image.marks.push_back({glm::dvec2(observer.position), observer.name});
  const MapSwatch beyond{k_out_of_range, k_beyond, "out of range"};
  const std::string unit_text = length_unit.empty() ? "" : " " + length_unit;
  float largest = 0.0f;
  for (const float value : viewshed.values.values) {
    if (has_value(value) && (mode != ViewshedMode::height || value < highest))
      largest = std::max(largest, value);
  }
  switch (mode) {
    case ViewshedMode::visible:
      image.swatches = {{1.0f, k_seen, "seen"}, {0.0f, k_hidden, "not visible"}, beyond};
      break;
    case ViewshedMode::count:
      image.swatches = {{0.0f, k_hidden, "not visible"}, beyond};
      image.scale = {image::ColorMap::viridis,
                     {1.0, std::max(1.0, static_cast<double>(largest))},
                     of_objects ? "objects" : "observers",
                     std::clamp(static_cast<int>(largest), 2, 7)};
      break;
    case ViewshedMode::height:
      image.swatches = {
          {static_cast<float>(lowest), k_seen,
           lowest > 0.0 ? fmt::format("visible at {:g}{}", lowest, unit_text) : "visible on the ground"},
          {static_cast<float>(highest), k_hidden, fmt::format("not up to {:g}{}", highest, unit_text)},
          beyond};
      image.scale = {image::ColorMap::viridis,
                     {lowest, std::max(lowest + 0.01, static_cast<double>(largest))},
                     length_unit.empty() ? "height" : "height, " + length_unit};
      break;
    case ViewshedMode::fraction:
      image.swatches = {{0.0f, k_hidden, "not visible"}, beyond};
      image.scale = {image::ColorMap::viridis, {0.0, 1.0}, "share"};
      break;
    case ViewshedMode::size:
    case ViewshedMode::angle:
      image.swatches = {{0.0f, k_hidden, "not visible"}, beyond};
      image.scale = {image::ColorMap::viridis,
                     {0.0, largest > 0.0f ? static_cast<double>(largest) : 1.0},
                     unit_of(options, length_unit)};
      break;
  }
  return image;
}

SeenShare seen_share(const Viewshed& viewshed, const ViewshedOptions& options) {
  const auto lowest = static_cast<float>(options.target_height);
  std::uint64_t seen = 0, looked_at = 0;
  for (const float value : viewshed.values.values) {
    if (!has_value(value)) continue;
    ++looked_at;
    seen += options.mode == ViewshedMode::height ? value == lowest : value > 0.0f;
  }
  return {looked_at == 0 ? 0.0 : 100.0 * static_cast<double>(seen) / static_cast<double>(looked_at),
          viewshed.values.values.size() - looked_at};
}

}  // namespace alidade::visibility
