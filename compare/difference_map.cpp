// SPDX-License-Identifier: MIT
#include "compare/difference_map.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "compare/metrics/agreement.h"
#include "compare/metrics/pixel_sums.h"
#include "image/canvas.h"
#include "image/color_map.h"
#include "image/font.h"
#include "image/image_file.h"
#include "image/legend.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

constexpr float k_no_value = std::numeric_limits<float>::quiet_NaN();

/// Sets the value of every pixel, in parallel.
template <typename Value>
void fill_values(DifferenceMap& map, const Value& value) {
  map.values.resize(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
  in_parallel(map.values.size(), 65536, [&](std::size_t i) { map.values[i] = value(i); });
}

/// Sums of a map's numbers that count and are finite.
DifferenceSums<double> sums_of(const DifferenceMap& map) {
  const auto width = static_cast<std::size_t>(map.width);
  return sum_rows<DifferenceSums<double>>(static_cast<std::size_t>(map.height),
                                          [&](std::size_t y, DifferenceSums<double>& sums) {
                                            for (std::size_t i = y * width; i < (y + 1) * width; ++i)
                                              if (map.mask.at(i) && std::isfinite(map.values[i]))
                                                sums.add(static_cast<double>(map.values[i]), i);
                                          });
}

/// The magnitude that so many of a hundred do not exceed; 0 without any.
double percentile_of(const DifferenceMap& map, double percent, std::uint64_t count) {
  if (count == 0) return 0.0;
  const auto magnitude_at = [&](std::size_t i) {
    return map.mask.at(i) && std::isfinite(map.values[i]) ? std::abs(map.values[i]) : -1.0f;
  };
  const auto rank = static_cast<std::uint64_t>(percent / 100.0 * static_cast<double>(count - 1));
  const std::size_t size = map.values.size();
  return static_cast<double>(value_of_rank(size, magnitude_at, count_upper_halves(size, magnitude_at), rank));
}

void add_notes(DifferenceMap& map, const DifferenceSums<double>& sums, const std::string& unit) {
  if (sums.values == 0) {
    map.notes.push_back("no pixels to compare");
    return;
  }
  const auto width = static_cast<std::size_t>(map.width);
  map.notes.push_back(fmt::format("mean {}{:.4g}{}",
                                  map.colors == DifferenceColors::balance ? "magnitude " : "",
                                  sums.mean(sums.sum_abs), unit));
  const double largest = sums.most > 0.0 ? static_cast<double>(map.values[sums.most_at]) : 0.0;
  map.notes.push_back(
      fmt::format("largest {:.4g}{} at ({}, {})", largest, unit, sums.most_at % width, sums.most_at / width));
}

DifferenceMap empty_map(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  require_same_size(reference, test);
  DifferenceMap map;
  map.width = reference.width;
  map.height = reference.height;
  map.mask = mask;
  return map;
}

float display_value(const ComparedImage& image, const image::CurveTable& curve, std::size_t value) {
  const float stored = image.color[value];
  return image.encoding == ColorEncoding::display ? stored : curve.at(stored);
}

using image::k_panel_bar_height, image::k_panel_bar_width, image::k_panel_font_size, image::k_panel_line;
using image::k_panel_note, image::k_panel_note_size, image::k_panel_row, image::k_panel_text;
constexpr image::Rgb8 k_paper{255, 255, 255};
constexpr int k_margin = 24, k_title_size = 24, k_most_ticks = 7;

/// Kinds of pixels without a number: indices into swatches_of(), before the map's categories.
enum Absence : std::size_t { k_ignored, k_nothing, k_only_reference, k_only_test, k_absences };

std::vector<MapCategory> swatches_of(const DifferenceMap& map) {
  std::vector<MapCategory> swatches = {{k_excluded_color, "excluded"},
                                       {{96, 96, 104}, "nothing to compare"},
                                       {{150, 60, 190}, "only in the reference"},
                                       {{40, 150, 70}, "only in the test"}};
  swatches.insert(swatches.end(), map.categories.begin(), map.categories.end());
  return swatches;
}

/// Dark blue, blue, light grey, red, dark red; linear between them.
glm::dvec3 balance_color(double position) {
  constexpr std::array<std::array<double, 3>, 5> k_stops = {
      {{0.03, 0.17, 0.42}, {0.25, 0.55, 0.80}, {0.95, 0.95, 0.94}, {0.86, 0.40, 0.28}, {0.45, 0.02, 0.10}}};
  const double along = std::clamp(position, 0.0, 1.0) * (k_stops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(along), k_stops.size() - 2);
  const double share = along - static_cast<double>(low);
  glm::dvec3 color{};
  for (int channel = 0; channel < 3; ++channel) {
    const auto i = static_cast<std::size_t>(channel);
    color[channel] = k_stops[low][i] + share * (k_stops[low + 1][i] - k_stops[low][i]);
  }
  return color;
}

image::Rgb8 color_at(const DifferenceMap& map, double position) {
  return image::to_rgb8(map.colors == DifferenceColors::balance
                            ? balance_color(position)
                            : image::map_color(image::ColorMap::inferno, position));
}

/// A pixel that does not count is NaN with `is_ignored`.
struct MapPixel {
  float value = std::numeric_limits<float>::quiet_NaN();
  bool is_ignored = true;
};

MapPixel pixel_of(const DifferenceMap& map, std::size_t i) {
  return map.mask.at(i) ? MapPixel{map.values[i], false} : MapPixel{};
}

/// The one that shows more of a change.
MapPixel stronger(const MapPixel& a, const MapPixel& b) {
  if (std::isnan(b.value)) return std::isnan(a.value) && a.is_ignored ? b : a;
  return std::isnan(a.value) || std::abs(b.value) > std::abs(a.value) ? b : a;
}

/// The swatch of a pixel without a number; empty if it has one.
std::optional<std::size_t> swatch_of(const DifferenceMap& map, const MapPixel& pixel) {
  if (pixel.is_ignored) return k_ignored;
  if (std::isnan(pixel.value)) return k_nothing;
  if (std::isinf(pixel.value)) return pixel.value > 0.0f ? k_only_reference : k_only_test;
  if (!map.categories.empty()) return k_absences + static_cast<std::size_t>(pixel.value);
  return {};
}

image::Rgb8 color_of(const DifferenceMap& map, const std::vector<MapCategory>& swatches,
                     const MapPixel& pixel) {
  if (const std::optional<std::size_t> swatch = swatch_of(map, pixel)) return swatches[*swatch].color;
  return color_at(map, map.range.share(static_cast<double>(pixel.value)));
}

class DifferenceDrawer {
 public:
  DifferenceDrawer(const DifferenceMap& map, const image::Font& font, int longest_side)
      : map_(map), font_(font), swatches_(swatches_of(map)), rows_(rows()) {
    if (map.categories.empty()) ticks_ = image::round_ticks(map.range, k_most_ticks);
    const int longest = std::max(map.width, map.height);
    shrink_ = (longest + longest_side - 1) / longest_side;
    // Small images are shown larger, so that the legend does not dwarf them.
    enlarge_ = std::max(1, longest_side / 2 / longest);
    const auto pixels = [&](int count) { return (count + shrink_ - 1) / shrink_ * enlarge_; };
    const int top = k_margin + k_title_size + k_margin / 2 + 4;
    box_ = {k_margin, top, k_margin + pixels(map.width), top + pixels(map.height)};
  }

  image::Canvas draw() const {
    const int panel = box_.right + k_margin;
    const int title = k_margin + font_.measure(map_.title, k_title_size).width;
    image::Canvas canvas(std::max(panel + panel_width(), title) + k_margin,
                         std::max(box_.bottom, box_.top + panel_height()) + k_margin, k_paper);
    font_.draw(canvas, k_margin, k_margin + k_title_size, map_.title, k_title_size, k_panel_text);
    draw_pixels(canvas);
    canvas.frame({box_.left - 1, box_.top - 1, box_.right + 1, box_.bottom + 1}, k_panel_line);
    draw_legend(canvas, panel);
    return canvas;
  }

 private:
  /// Those that occur, with their shares of the image.
  std::vector<MapCategory> rows() const {
    std::vector<std::size_t> counts(swatches_.size());
    for (std::size_t i = 0; i < map_.values.size(); ++i) {
      if (const std::optional<std::size_t> swatch = swatch_of(map_, pixel_of(map_, i))) ++counts[*swatch];
    }
    std::vector<MapCategory> rows;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == 0) continue;
      rows.push_back(
          {swatches_[i].color, swatches_[i].label + image::share_label(counts[i], map_.values.size())});
    }
    // The strongest is on top, as in the bar of numbers.
    if (!map_.categories.empty()) std::ranges::reverse(rows);
    return rows;
  }

  int panel_width() const {
    int width = font_.measure(map_.label, k_panel_font_size).width;
    for (const image::RoundTick& tick : ticks_)
      width = std::max(width, k_panel_bar_width + 16 + font_.measure(tick.label, k_panel_font_size).width);
    for (const MapCategory& row : rows_)
      width = std::max(width, k_panel_row + 8 + font_.measure(row.label, k_panel_font_size).width);
    for (const std::string& note : map_.notes)
      width = std::max(width, font_.measure(note, k_panel_note_size).width);
    return width;
  }

  int panel_height() const {
    const auto rows = static_cast<int>(rows_.size()), notes = static_cast<int>(map_.notes.size());
    const int bar = map_.categories.empty() ? k_panel_bar_height + k_panel_row : 0;
    return k_panel_row + bar + k_panel_row * rows + (k_panel_row - 6) * notes;
  }

  MapPixel shown(int column, int row) const {
    MapPixel result;
    for (int y = row * shrink_; y < std::min((row + 1) * shrink_, map_.height); ++y) {
      for (int x = column * shrink_; x < std::min((column + 1) * shrink_, map_.width); ++x)
        result = stronger(result, pixel_of(map_, pixel_index(x, y, map_.width)));
    }
    return result;
  }

  void draw_pixels(image::Canvas& canvas) const {
    in_parallel(box_.height() / enlarge_, 4, [&](int row) {
      for (int column = 0; column < box_.width() / enlarge_; ++column) {
        const int left = box_.left + column * enlarge_, top = box_.top + row * enlarge_;
        canvas.fill({left, top, left + enlarge_, top + enlarge_},
                    color_of(map_, swatches_, shown(column, row)));
      }
    });
  }

  void draw_legend(image::Canvas& canvas, int left) const {
    int y = box_.top;
    font_.draw(canvas, left, y + 16, map_.label, k_panel_font_size, k_panel_text);
    y += k_panel_row + 4;
    if (map_.categories.empty()) {
      y = image::draw_color_bar(canvas, font_, left, y, map_.range, ticks_,
                                [&](double position) { return color_at(map_, position); });
    }
    for (const MapCategory& row : rows_) y = image::draw_swatch(canvas, font_, left, y, row.color, row.label);
    for (const std::string& note : map_.notes) {
      font_.draw(canvas, left, y + 14, note, k_panel_note_size, k_panel_note);
      y += k_panel_row - 6;
    }
  }

  const DifferenceMap& map_;
  const image::Font& font_;
  std::vector<MapCategory> swatches_, rows_;  ///< all possible ones; those of the legend, with shares
  std::vector<image::RoundTick> ticks_;
  int shrink_ = 1, enlarge_ = 1;
  image::PixelBox box_;
};

}  // namespace

DifferenceMap color_difference(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask) {
  DifferenceMap map = empty_map(reference, test, mask);
  assert(reference.color.size() == 3 * reference.pixels() && test.color.size() == 3 * test.pixels());
  const image::CurveTable& curve = image::srgb_from_linear_table();
  fill_values(map, [&](std::size_t pixel) {
    float largest = 0.0f;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      if (!std::isfinite(reference.color[i]) || !std::isfinite(test.color[i])) return k_no_value;
      largest =
          std::max(largest, std::abs(display_value(test, curve, i) - display_value(reference, curve, i)));
    }
    return largest;
  });
  map.title = "Colour difference";
  map.label = "largest channel (white = 1)";
  constexpr double k_percentile = 99.5;
  const DifferenceSums<double> sums = sums_of(map);
  map.range = {0.0, std::clamp(percentile_of(map, k_percentile, sums.values), 1.0 / 255.0, 1.0)};
  add_notes(map, sums, "");
  return map;
}

DifferenceMap flip_difference(std::vector<float> flip, int width, const ImageMask& mask) {
  DifferenceMap map;
  map.title = "FLIP";
  map.label = "FLIP (0 = equal, 1 = maximum)";
  map.width = width;
  map.height = static_cast<int>(flip.size() / static_cast<std::size_t>(width));
  map.values = std::move(flip);
  map.mask = mask;
  map.range = {0.0, 1.0};
  add_notes(map, sums_of(map), "");
  return map;
}

DifferenceMap depth_difference(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask) {
  DifferenceMap map = empty_map(reference, test, mask);
  assert(reference.depth.size() == reference.pixels() && test.depth.size() == test.pixels());
  constexpr float k_infinite = std::numeric_limits<float>::infinity();
  fill_values(map, [&](std::size_t pixel) {
    const bool in_reference = is_depth(reference.depth[pixel]), in_test = is_depth(test.depth[pixel]);
    if (in_reference && in_test) return test.depth[pixel] - reference.depth[pixel];
    return in_reference ? k_infinite : in_test ? -k_infinite : k_no_value;
  });
  map.title = "Depth difference";
  map.label = "test - reference (m)";
  map.colors = DifferenceColors::balance;
  constexpr double k_percentile = 98.0, k_least_range = 0.001;
  const DifferenceSums<double> sums = sums_of(map);
  const double range = std::max(percentile_of(map, k_percentile, sums.values), k_least_range);
  map.range = {-range, range};
  if (sums.values > 0) map.notes.push_back(fmt::format("mean {:.4g} m", sums.mean(sums.sum)));
  add_notes(map, sums, " m");
  return map;
}

DifferenceMap depth_agreement(const ComparedImage& reference, const ComparedImage& test,
                              const ImageMask& mask) {
  DifferenceMap map = empty_map(reference, test, mask);
  map.title = "Depth agreement";
  map.label = "within three standard deviations";
  map.categories = {{{0, 0, 0}, "nothing in either"},
                    {{56, 158, 84}, "agrees"},
                    {{205, 205, 205}, "not scanned"},
                    {{214, 40, 40}, "differs"}};
  const DepthAgreement agreement(reference, test);
  // Agreement has the order of the categories.
  fill_values(map, [&](std::size_t pixel) { return static_cast<float>(agreement.at(pixel)); });
  return map;
}

image::Canvas paint_difference(const DifferenceMap& map) {
  image::Canvas canvas(map.width, map.height, k_paper);
  const std::vector<MapCategory> swatches = swatches_of(map);
  in_parallel(map.height, 4, [&](int y) {
    for (int x = 0; x < map.width; ++x) {
      canvas.fill({x, y, x + 1, y + 1}, color_of(map, swatches, pixel_of(map, pixel_index(x, y, map.width))));
    }
  });
  return canvas;
}

image::Canvas draw_difference(const DifferenceMap& map, const image::Font& font, int longest_side) {
  return DifferenceDrawer(map, font, longest_side).draw();
}

void write_difference(const DifferenceMap& map, const std::filesystem::path& file, bool overwrite) {
  const image::Font font(image::find_font());
  image::write_png(draw_difference(map, font), file, overwrite);
}

}  // namespace alidade::compare
