// SPDX-License-Identifier: MIT
#include "extensions/placement/coverage_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "image/canvas.h"
#include "image/image_file.h"
#include "image/legend.h"

namespace alidade::visibility {
namespace {

constexpr int k_width = 900, k_height = 560, k_text_size = 20, k_tick_length = 6;
constexpr image::PixelBox k_plot{90, 60, 870, 470};
constexpr image::Rgb8 k_white{255, 255, 255}, k_words{30, 30, 30}, k_axis{95, 95, 95}, k_grid{225, 225, 225};
constexpr image::Rgb8 k_before{166, 199, 224}, k_gain{31, 98, 152}, k_bound{176, 60, 40};

/// Draws on one canvas with one font.
struct Plot {
  image::Canvas& canvas;
  const image::Font& font;
  double most;  ///< percent at the top

  int row_of(double percent) const {
    return k_plot.bottom - static_cast<int>(std::lround(percent / most * k_plot.height()));
  }
  /// Ends of bar i of `count`.
  static int column_of(std::size_t i, std::size_t count) {
    return k_plot.left + static_cast<int>(static_cast<std::uint64_t>(k_plot.width()) * i / count);
  }
  /// `align`: 0 starts at x, 1 ends there, 0.5 has its middle there.
  void text(int x, int baseline, const std::string& words, double align) const {
    const int width = font.measure(words, k_text_size).width;
    font.draw(canvas, x - static_cast<int>(std::lround(align * width)), baseline, words, k_text_size,
              k_words);
  }
};

void draw_percent_axis(const Plot& plot) {
  for (const image::RoundTick& tick : image::round_ticks({0.0, plot.most}, 9)) {
    const int y = plot.row_of(tick.value);
    plot.canvas.fill({k_plot.left, y, k_plot.right, y + 1}, k_grid);
    plot.canvas.fill({k_plot.left - k_tick_length, y, k_plot.left, y + 1}, k_axis);
    plot.text(k_plot.left - 2 * k_tick_length, y + k_text_size / 3, tick.label, 1.0);
  }
}

void draw_bars(const Plot& plot, const Placement& placement) {
  const std::size_t count = placement.positions.size();
  for (std::size_t i = 0; i < count; ++i) {
    const ChosenPosition& chosen = placement.positions[i];
    const int left = Plot::column_of(i, count), right = Plot::column_of(i + 1, count);
    // A gap between bars if there is room.
    const int gap = right - left > 4 ? (right - left) / 5 : 0;
    const image::PixelBox bar{left + gap, plot.row_of(100.0 * chosen.covered / placement.total), right - gap,
                              k_plot.bottom};
    const int seam = plot.row_of(100.0 * (chosen.covered - chosen.gain) / placement.total);
    plot.canvas.fill(bar, k_before);
    plot.canvas.fill({bar.left, bar.top, bar.right, seam}, k_gain);
  }
}

/// Draws the numbers of some bars, from 1, below their middles.
void draw_numbers(const Plot& plot, std::size_t count) {
  constexpr int k_most_numbers = 12;
  const double last = static_cast<double>(count);
  for (const image::RoundTick& tick : image::round_ticks({1.0, std::max(last, 2.0)}, k_most_numbers)) {
    if (tick.value != std::floor(tick.value) || tick.value > last) continue;
    const auto i = static_cast<std::size_t>(tick.value) - 1;
    const int middle = (Plot::column_of(i, count) + Plot::column_of(i + 1, count)) / 2;
    plot.canvas.fill({middle, k_plot.bottom, middle + 1, k_plot.bottom + k_tick_length}, k_axis);
    plot.text(middle, k_plot.bottom + k_tick_length + k_text_size, std::to_string(i + 1), 0.5);
  }
  plot.text((k_plot.left + k_plot.right) / 2, k_height - k_text_size, "positions, in order of selection",
            0.5);
}

void draw_bound(const Plot& plot, double percent) {
  constexpr int k_dash = 8;
  const int y = plot.row_of(percent);
  for (int x = k_plot.left; x < k_plot.right; x += 2 * k_dash)
    plot.canvas.fill({x, y - 1, std::min(x + k_dash, k_plot.right), y + 1}, k_bound);
}

}  // namespace

image::Canvas draw_coverage(const Placement& placement, const image::Font& font) {
  const double covered = 100.0 * placement.positions.back().covered / placement.total;
  const double bound = 100.0 * placement.best_possible / placement.total;
  image::Canvas canvas(k_width, k_height, k_white);
  const Plot plot{canvas, font, bound > 0.0 ? bound * 1.05 : 1.0};
  draw_percent_axis(plot);
  draw_bars(plot, placement);
  draw_bound(plot, bound);
  canvas.fill({k_plot.left, k_plot.bottom, k_plot.right, k_plot.bottom + 1}, k_axis);
  canvas.fill({k_plot.left - 1, k_plot.top, k_plot.left, k_plot.bottom + 1}, k_axis);
  const std::size_t count = placement.positions.size();
  draw_numbers(plot, count);
  plot.text(k_text_size, k_plot.top - k_text_size,
            fmt::format("Seen by {}: {:.1f} % of the targets; no other {} see more than {:.1f} % (dashed)",
                        count, covered, count, bound),
            0.0);
  return canvas;
}

void write_coverage_image(const Placement& placement, const std::filesystem::path& file, bool overwrite) {
  const image::Font font(image::find_font());
  image::write_png(draw_coverage(placement, font), file, overwrite);
}

}  // namespace alidade::visibility
