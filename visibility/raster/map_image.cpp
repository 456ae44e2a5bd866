// SPDX-License-Identifier: MIT
#include "visibility/raster/map_image.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "image/canvas.h"
#include "image/image_file.h"
#include "image/legend.h"

namespace alidade::visibility {

Relief::Relief(const Ground& ground, double step) : ground_(ground), step_(step) {
  constexpr int k_samples = 50;
  // Nine slopes in ten must not look steeper than this.
  constexpr double k_steep = 0.5, k_most = 8.0, k_share = 0.9;
  const geo::RasterGrid& grid = ground.heights().grid;
  const glm::dvec2 size = grid.south_east() - grid.north_west;
  std::vector<double> slopes;
  for (int y = 0; y < k_samples; ++y) {
    for (int x = 0; x < k_samples; ++x) {
      const glm::dvec2 there = slope(grid.north_west + size * ((glm::dvec2(x, y) + 0.5) / double{k_samples}));
      slopes.push_back(std::sqrt(there.x * there.x + there.y * there.y));
    }
  }
  const auto steep = slopes.begin() + static_cast<std::ptrdiff_t>(k_share * k_samples * k_samples);
  std::nth_element(slopes.begin(), steep, slopes.end());
  if (*steep > 0.0) exaggeration_ = std::clamp(k_steep / *steep, 1.0, k_most);
}

glm::dvec2 Relief::slope(const glm::dvec2& position) const {
  const auto height = [&](double x, double y) { return ground_.at(position + step_ * glm::dvec2(x, y)); };
  const auto east = height(1, 0), west = height(-1, 0), north = height(0, 1), south = height(0, -1);
  if (!east || !west || !north || !south) return glm::dvec2(0.0);
  return glm::dvec2(*east - *west, *north - *south) / (2.0 * step_);
}

double Relief::light(const glm::dvec2& position) const {
  const glm::dvec2 rise = exaggeration_ * slope(position);
  // The light comes from (-1, 1, sqrt 2) / 2; divided by its share on level ground.
  const double towards = (rise.x - rise.y) / std::sqrt(2.0) + 1.0;
  return std::max(0.0, towards) / std::sqrt(1.0 + rise.x * rise.x + rise.y * rise.y);
}

namespace {

using image::k_panel_bar_height, image::k_panel_bar_width, image::k_panel_font_size, image::k_panel_line;
using image::k_panel_note, image::k_panel_note_size, image::k_panel_row, image::k_panel_text;
constexpr image::Rgb8 k_background{255, 255, 255};
constexpr image::Rgb8 k_mark{220, 30, 40}, k_halo{255, 255, 255};
constexpr int k_margin = 24, k_map_title_size = 24, k_longest_names = 20;

image::Rgb8 shaded(const image::Rgb8& color, double light) {
  // Shade is limited, so that colours remain distinguishable.
  constexpr double k_least = 0.35;
  const double factor = (k_least + (1.0 - k_least) * light) / 255.0;
  return image::to_rgb8({factor * color[0], factor * color[1], factor * color[2]});
}

/// The parts of the image, in pixels.
struct MapLayout {
  image::PixelBox map;
  double cells_per_pixel = 1.0;
  int panel = 0;  ///< left edge of the legend
  int width = 0, height = 0;
};

class MapDrawer {
 public:
  MapDrawer(const MapImage& image, const Ground& ground, const image::Font& font, int longest_side)
      : image_(image),
        ground_(ground),
        font_(font),
        rows_(rows()),
        layout_(layout(longest_side)),
        canvas_(layout_.width, layout_.height, k_background) {}

  image::Canvas draw() {
    font_.draw(canvas_, k_margin, k_margin + k_map_title_size, image_.title, k_map_title_size, k_panel_text);
    draw_cells();
    canvas_.frame({layout_.map.left - 1, layout_.map.top - 1, layout_.map.right + 1, layout_.map.bottom + 1},
                  k_panel_line);
    for (const MapMark& mark : image_.marks) draw_mark(mark);
    draw_scale_bar();
    draw_north();
    draw_legend();
    return std::move(canvas_);
  }

 private:
  const geo::RasterGrid& grid() const { return image_.values.grid; }

  /// The swatches that occur, with their shares.
  std::vector<MapSwatch> rows() const {
    std::vector<std::uint64_t> counts(image_.swatches.size(), 0);
    std::uint64_t total = 0;
    for (const float value : image_.values.values) {
      if (std::isnan(value)) continue;
      ++total;
      for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += image_.swatches[i].value == value;
    }
    std::vector<MapSwatch> rows;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == 0) continue;
      rows.push_back(image_.swatches[i]);
      rows.back().label += image::share_label(counts[i], total);
    }
    return rows;
  }

  int panel_width() const {
    int width = 0;
    const auto widen = [&](const std::string& text, int size, int indent) {
      width = std::max(width, indent + font_.measure(text, size).width);
    };
    for (const MapSwatch& row : rows_) widen(row.label, k_panel_font_size, k_panel_row + 8);
    for (const std::string& note : image_.notes) widen(note, k_panel_note_size, 0);
    if (image_.scale) {
      widen(image_.scale->label, k_panel_font_size, 0);
      for (const image::RoundTick& tick : ticks())
        widen(tick.label, k_panel_font_size, k_panel_bar_width + 16);
    }
    return width;
  }

  int panel_height() const {
    int height = 3 * k_panel_row + k_panel_row * static_cast<int>(rows_.size() + image_.notes.size());
    if (image_.scale) height += k_panel_bar_height + 3 * k_panel_row;
    return height;
  }

  std::vector<image::RoundTick> ticks() const {
    return image::round_ticks(image_.scale->range, std::max(2, image_.scale->most_ticks));
  }

  MapLayout layout(int longest_side) const {
    const int cells = std::max(grid().columns, grid().rows);
    MapLayout layout;
    if (cells <= longest_side)
      layout.cells_per_pixel = 1.0 / (longest_side / cells);
    else
      layout.cells_per_pixel = static_cast<double>(cells) / longest_side;
    const auto pixels = [&](int count) {
      return std::max(1, static_cast<int>(std::lround(count / layout.cells_per_pixel)));
    };
    const int top = k_margin + k_map_title_size + k_margin / 2 + 4;
    layout.map = {k_margin, top, k_margin + pixels(grid().columns), top + pixels(grid().rows)};
    layout.panel = layout.map.right + k_margin;
    const int title = k_margin + font_.measure(image_.title, k_map_title_size).width;
    layout.width = std::max(layout.panel + panel_width(), title) + k_margin;
    layout.height = std::max(layout.map.bottom + 3 * k_margin, top + panel_height() + k_margin);
    return layout;
  }

  double units_per_pixel() const { return layout_.cells_per_pixel * grid().cell_size; }

  image::Rgb8 color_of(float value) const {
    for (const MapSwatch& swatch : image_.swatches) {
      if (swatch.value == value) return swatch.color;
    }
    if (!image_.scale) return k_background;
    return image::to_rgb8(image::map_color(image_.scale->map, image_.scale->range.share(value)));
  }

  void draw_cells() {
    const Relief relief(ground_, std::max(units_per_pixel(), ground_.heights().grid.cell_size));
    const image::PixelBox& map = layout_.map;
    in_parallel(map.height(), 4, [&](int y) {
      const double south = (y + 0.5) * layout_.cells_per_pixel;
      const int row = std::min(static_cast<int>(south), grid().rows - 1);
      for (int x = 0; x < map.width(); ++x) {
        const double east = (x + 0.5) * layout_.cells_per_pixel;
        const int column = std::min(static_cast<int>(east), grid().columns - 1);
        const float value = image_.values.at(column, row);
        if (std::isnan(value)) continue;
        const glm::dvec2 position = grid().north_west + grid().cell_size * glm::dvec2(east, -south);
        const int left = map.left + x, top = map.top + y;
        canvas_.fill({left, top, left + 1, top + 1}, shaded(color_of(value), relief.light(position)));
      }
    });
  }

  /// A disc with soft edges.
  void dot(const glm::dvec2& middle, double radius, const image::Rgb8& color) {
    const auto reach = static_cast<int>(std::ceil(radius)) + 1;
    const auto x0 = static_cast<int>(std::floor(middle.x)), y0 = static_cast<int>(std::floor(middle.y));
    for (int y = y0 - reach; y <= y0 + reach; ++y) {
      for (int x = x0 - reach; x <= x0 + reach; ++x) {
        const glm::dvec2 way = glm::dvec2(x + 0.5, y + 0.5) - middle;
        const double inside = radius + 0.5 - std::sqrt(way.x * way.x + way.y * way.y);
        if (inside > 0.0) canvas_.blend(x, y, color, static_cast<int>(255.0 * std::min(inside, 1.0)));
      }
    }
  }

  /// Draws text with a halo, legible on any ground.
  void haloed(int x, int baseline, const std::string& text, int size) {
    for (const auto& [dx, dy] :
         {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}})
      font_.draw(canvas_, x + dx, baseline + dy, text, size, k_halo);
    font_.draw(canvas_, x, baseline, text, size, k_panel_text);
  }

  void draw_mark(const MapMark& mark) {
    if (!geo::cell_at(grid(), mark.position)) return;
    const glm::dvec2 way = mark.position - grid().north_west;
    const glm::dvec2 pixel(layout_.map.left + way.x / units_per_pixel(),
                           layout_.map.top - way.y / units_per_pixel());
    // Many observers are small dots.
    const bool few = image_.marks.size() <= k_longest_names;
    dot(pixel, few ? 7.5 : 3.5, k_halo);
    dot(pixel, few ? 5.5 : 2.5, k_mark);
    if (!few || mark.name.empty()) return;
    const image::TextExtent extent = font_.measure(mark.name, k_panel_note_size);
    const int right = static_cast<int>(pixel.x) + 11;
    const bool fits = right + extent.width <= layout_.map.right - 2;
    haloed(fits ? right : static_cast<int>(pixel.x) - 11 - extent.width,
           static_cast<int>(pixel.y) + extent.ascent / 2, mark.name, k_panel_note_size);
  }

  void draw_scale_bar() {
    // At most a third of the map: the largest round length.
    const double longest = layout_.map.width() * units_per_pixel() / 3.0;
    double length = std::pow(10.0, std::floor(std::log10(longest)));
    if (5.0 * length <= longest)
      length *= 5.0;
    else if (2.0 * length <= longest)
      length *= 2.0;
    const int pixels = std::max(1, static_cast<int>(std::lround(length / units_per_pixel())));
    const int left = layout_.map.left, top = layout_.map.bottom + k_margin / 2;
    canvas_.fill({left, top, left + pixels, top + 6}, k_panel_line);
    canvas_.fill({left + pixels / 2, top + 1, left + pixels - 1, top + 5}, k_background);
    const std::string label = fmt::format("{:g}{}{}", length, image_.unit.empty() ? "" : " ", image_.unit);
    font_.draw(canvas_, left + pixels + 10, top + 10, label, k_panel_font_size, k_panel_text);
  }

  void draw_north() {
    constexpr int k_arrow = 22;
    const int middle = layout_.map.right - 12, top = layout_.map.bottom + 8;
    for (int y = 0; y < k_arrow; ++y) {
      const int half = y / 3;
      canvas_.fill({middle - half, top + y, middle + half + 1, top + y + 1}, k_panel_line);
    }
    const image::TextExtent extent = font_.measure("N", k_panel_font_size);
    font_.draw(canvas_, middle - 14 - extent.width, top + k_arrow - 3, "N", k_panel_font_size, k_panel_text);
  }

  void draw_legend() {
    const int left = layout_.panel;
    int y = layout_.map.top;
    for (const MapSwatch& row : rows_) y = image::draw_swatch(canvas_, font_, left, y, row.color, row.label);
    if (image_.scale) y = draw_color_bar(y + k_panel_row / 2);
    for (const std::string& note : image_.notes) {
      font_.draw(canvas_, left, y + 16, note, k_panel_note_size, k_panel_note);
      y += k_panel_row - 6;
    }
  }

  int draw_color_bar(int y) {
    const MapScale& scale = *image_.scale;
    const int left = layout_.panel;
    font_.draw(canvas_, left, y + 16, scale.label, k_panel_font_size, k_panel_text);
    y += k_panel_row + 6;
    return image::draw_color_bar(canvas_, font_, left, y, scale.range, ticks(), [&](double share) {
      return image::to_rgb8(image::map_color(scale.map, share));
    });
  }

  const MapImage& image_;
  const Ground& ground_;
  const image::Font& font_;
  std::vector<MapSwatch> rows_;
  MapLayout layout_;
  image::Canvas canvas_;
};

}  // namespace

image::Canvas draw_map(const MapImage& image, const Ground& ground, const image::Font& font,
                       int longest_side) {
  return MapDrawer(image, ground, font, longest_side).draw();
}

void write_map_image(const MapImage& image, const Ground& ground, const std::filesystem::path& file,
                     bool overwrite) {
  const image::Font font(image::find_font());
  image::write_png(draw_map(image, ground, font), file, overwrite);
}

}  // namespace alidade::visibility
