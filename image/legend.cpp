// SPDX-License-Identifier: MIT
#include "image/legend.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/error.h"
#include "image/image_file.h"

namespace alidade::image {
namespace {

/// mantissa * 10^exponent, both whole.
struct Step {
  int mantissa = 1;
  int exponent = 0;

  /// `count` of them. Dividing by a power of ten gives the double nearest to the decimal, multiplying by a
  /// negative one would not.
  double times(double count) const {
    const double power = std::pow(10.0, std::abs(exponent));
    return exponent < 0 ? count * mantissa / power : count * mantissa * power;
  }
  Step next() const {
    if (mantissa == 1) return {2, exponent};
    return mantissa == 2 ? Step{5, exponent} : Step{1, exponent + 1};
  }
};

std::string label_of(double value, const Step& step) {
  constexpr int k_most_decimals = 6, k_most_digits = 17;
  constexpr double k_longest = 1e12;
  const double plain_value = value + 0.0;  // no negative zero
  if (-step.exponent <= k_most_decimals && std::fabs(value) < k_longest)
    return fmt::format("{:.{}f}", plain_value, std::max(0, -step.exponent));
  const int first_digit = value == 0.0 ? 0 : static_cast<int>(std::floor(std::log10(std::fabs(value))));
  return fmt::format("{:.{}g}", plain_value, std::clamp(first_digit - step.exponent + 1, 1, k_most_digits));
}

/// "1 234 567".
std::string grouped(std::uint64_t count) {
  std::string text = std::to_string(count);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ' ');
  return text;
}

std::string share_text(std::uint64_t count, std::uint64_t total) {
  const double percent = 100.0 * static_cast<double>(count) / static_cast<double>(total);
  return percent > 0.0 && percent < 0.1 ? "< 0.1 %" : fmt::format("{:.1f} %", percent);
}

std::vector<Swatch> rows_of(const ColorKey& key) {
  std::vector<Swatch> rows = key.swatches;
  if (key.missing_count > 0)
    rows.push_back({.color = k_no_value_color, .label = "no value", .count = key.missing_count});
  return rows;
}

std::vector<std::string> notes_of(const ColorKey& key) {
  std::vector<std::string> notes;
  if (!key.scale) return notes;
  const ColorScale& scale = *key.scale;
  if (!scale.origin_text.empty()) notes.push_back(scale.origin_text);
  if (scale.range == scale.extent) return notes;
  if (scale.percentiles)
    notes.push_back(fmt::format("percentiles {:g} to {:g}", scale.percentiles->low, scale.percentiles->high));
  notes.push_back("all: " + range_text(scale.extent, scale.origin));
  return notes;
}

/// Lays out the parts of a legend, one below the other.
class Layouter {
 public:
  Layouter(const Font& font, int font_size)
      : font_(font),
        em_(font_size),
        margin_(font_size),
        y_(margin_),
        digit_height_(font.measure("0", font_size).ascent) {
    layout_.font_size = font_size;
  }

  void add_title(const std::string& title) {
    const int size = em_ * 6 / 5;
    const int baseline = y_ + font_.measure("H", size).ascent;
    add_text(title, margin_, baseline, size);
    y_ = baseline + em_;
  }

  void add_bar(const ColorScale& scale, int height) {
    const int top = y_ + digit_height_ / 2, most = std::clamp(height / (em_ * 8 / 5), 2, 11);
    layout_.bar = {margin_, top, margin_ + em_ * 3 / 2, top + height};
    const ValueRange shown{scale.range.low - scale.origin, scale.range.high - scale.origin};
    const std::vector<RoundTick> ticks = round_ticks(shown, most);
    int widest = 0;
    for (const RoundTick& tick : ticks) widest = std::max(widest, width_of(tick.label));
    const int label_end = layout_.bar.right + em_ * 7 / 10 + widest;
    for (const RoundTick& tick : ticks) {
      const double below_top =
          shown.high > shown.low ? (shown.high - tick.value) / (shown.high - shown.low) : 0.5;
      const int y = top + static_cast<int>(std::lround(below_top * (height - 1)));
      layout_.ticks.push_back({tick.value + scale.origin, y});
      add_right_aligned(tick.label, label_end, y);
    }
    y_ = layout_.bar.bottom + digit_height_ / 2 + em_;
  }

  void add_rows(const std::vector<Swatch>& rows, std::uint64_t total) {
    const int side = em_ * 6 / 5;
    int number_width = 0, label_end = 0, count_width = 0, share_width = 0;
    for (const Swatch& row : rows) number_width = std::max(number_width, width_of(row.number));
    const int number_end = margin_ + side + em_ / 2 + number_width;
    const int label_x = number_width > 0 ? number_end + em_ / 2 : number_end;
    for (const Swatch& row : rows) {
      label_end = std::max(label_end, label_x + width_of(row.label));
      if (!row.count) continue;
      count_width = std::max(count_width, width_of(grouped(*row.count)));
      share_width = std::max(share_width, width_of(share_text(*row.count, total)));
    }
    const int count_end = label_end + em_ * 3 / 2 + count_width, share_end = count_end + em_ + share_width;
    for (const Swatch& row : rows) {
      layout_.swatches.push_back({{margin_, y_, margin_ + side, y_ + side}, row.color});
      const int middle = y_ + side / 2;
      add_right_aligned(row.number, number_end, middle);
      add_text(row.label, label_x, middle + digit_height_ / 2, em_);
      if (row.count) {
        add_right_aligned(grouped(*row.count), count_end, middle);
        add_right_aligned(share_text(*row.count, total), share_end, middle);
      }
      y_ += em_ * 8 / 5;
    }
    if (!rows.empty()) y_ += em_ * 2 / 5;
  }

  void add_notes(const std::vector<std::string>& notes) {
    const int size = std::max(em_ * 4 / 5, 1);
    for (const std::string& note : notes) {
      add_text(note, margin_, y_ + font_.measure("0", size).ascent, size);
      layout_.texts.back().is_note = true;
      y_ += size * 7 / 5;
    }
    if (!notes.empty()) y_ += em_ / 2;
  }

  LegendLayout finish() {
    layout_.width = right_ + margin_;
    layout_.height = y_ - em_ + margin_;
    return layout_;
  }

 private:
  int width_of(const std::string& text) const { return font_.measure(text, em_).width; }

  void add_text(const std::string& text, int x, int baseline, int size) {
    if (text.empty()) return;
    layout_.texts.push_back({text, x, baseline, size});
    right_ = std::max(right_, x + font_.measure(text, size).width);
  }

  /// Adds a text that ends at x, with its digits around the row y.
  void add_right_aligned(const std::string& text, int x, int y) {
    add_text(text, x - width_of(text), y + digit_height_ / 2, em_);
  }

  const Font& font_;
  const int em_, margin_;
  int y_, right_ = 0;
  const int digit_height_;
  LegendLayout layout_;
};

LegendLayout lay_out(const ColorKey& key, const Font& font, int font_size, int bar_height) {
  Layouter layouter(font, font_size);
  layouter.add_title(title_text(key));
  if (key.scale) layouter.add_bar(*key.scale, bar_height);
  layouter.add_rows(rows_of(key), key.point_count);
  layouter.add_notes(notes_of(key));
  return layouter.finish();
}

bool fits(const LegendLayout& layout, const glm::ivec2& size) {
  return layout.width <= size.x && layout.height <= size.y;
}

constexpr Rgb8 k_background{255, 255, 255}, k_text{30, 30, 30}, k_note{95, 95, 95}, k_line{95, 95, 95};

Rgb8 to_rgb8(const Color16& color) {
  constexpr int k_step = 257;
  const auto channel = [](int value) { return static_cast<std::uint8_t>((value + k_step / 2) / k_step); };
  return {channel(color.r), channel(color.g), channel(color.b)};
}

/// One pixel around the box.
PixelBox around(const PixelBox& box) {
  return {box.left - 1, box.top - 1, box.right + 1, box.bottom + 1};
}

void draw_bar(const ColorScale& scale, const LegendLayout& layout, Canvas& canvas) {
  const PixelBox& bar = layout.bar;
  const bool constant = !(scale.range.high > scale.range.low);
  for (int y = bar.top; y < bar.bottom; ++y) {
    const double position = constant ? 0.5 : static_cast<double>(bar.bottom - 1 - y) / (bar.height() - 1);
    canvas.fill({bar.left, y, bar.right, y + 1}, to_rgb8(to_color16(map_color(scale.map, position))));
  }
  canvas.frame(around(bar), k_line);
  const int length = std::max(layout.font_size / 3, 2);
  for (const LegendTick& tick : layout.ticks)
    canvas.fill({bar.right + 1, tick.y, bar.right + 1 + length, tick.y + 1}, k_line);
}

}  // namespace

std::vector<RoundTick> round_ticks(const ValueRange& range, int most) {
  assert(range.low <= range.high && most >= 2);
  const double extent = range.high - range.low;
  const double largest = std::max(std::fabs(range.low), std::fabs(range.high));
  constexpr double k_narrowest = 1e-12, k_smallest = 1e-290;
  std::vector<RoundTick> ticks;
  if (extent <= std::max(k_narrowest * largest, k_smallest)) {
    ticks.push_back({range.low, fmt::format("{:g}", range.low)});
    if (extent > 0.0) ticks.push_back({range.high, fmt::format("{:g}", range.high)});
    return ticks;
  }
  // A little room for the rounding of ends that are multiples themselves.
  const double slack = 1e-9 * extent;
  Step step{1, static_cast<int>(std::floor(std::log10(extent / most))) - 1};
  for (;; step = step.next()) {
    const double first = std::ceil((range.low - slack) / step.times(1.0)),
                 last = std::floor((range.high + slack) / step.times(1.0));
    if (last - first + 1.0 > most) continue;
    for (double count = first; count <= last; ++count) {
      const double value = std::clamp(step.times(count), range.low, range.high);
      ticks.push_back({value, label_of(step.times(count), step)});
    }
    return ticks;
  }
}

LegendLayout lay_out_legend(const ColorKey& key, const Font& font, const std::optional<glm::ivec2>& size) {
  constexpr int k_smallest_font = 8, k_bar_ems = 13;
  check_legend(key);
  const auto natural = [&](int font_size) { return lay_out(key, font, font_size, k_bar_ems * font_size); };
  const LegendLayout usual = natural(k_legend_font_size);
  if (!size) return usual;

  const double scale =
      std::min(static_cast<double>(size->x) / usual.width, static_cast<double>(size->y) / usual.height);
  // Texts do not grow evenly with their font: begin a little above the expected size.
  int font_size = std::max(k_smallest_font, static_cast<int>(scale * k_legend_font_size) + 2);
  LegendLayout layout = natural(font_size);
  while (font_size > k_smallest_font && !fits(layout, *size)) layout = natural(--font_size);
  if (!fits(layout, *size)) {
    throw input_error("the legend does not fit the given size",
                      fmt::format("at least {}x{} pixels", layout.width, layout.height),
                      fmt::format("{}x{}", size->x, size->y));
  }
  if (key.scale) layout = lay_out(key, font, font_size, k_bar_ems * font_size + size->y - layout.height);
  layout.width = size->x;
  layout.height = size->y;
  return layout;
}

Canvas draw_legend(const ColorKey& key, const LegendLayout& layout, const Font& font) {
  Canvas canvas(layout.width, layout.height, k_background);
  if (key.scale) draw_bar(*key.scale, layout, canvas);
  for (const LegendSwatch& swatch : layout.swatches) {
    canvas.fill(swatch.box, to_rgb8(swatch.color));
    canvas.frame(around(swatch.box), k_line);
  }
  for (const LegendText& text : layout.texts)
    font.draw(canvas, text.x, text.baseline, text.text, text.size, text.is_note ? k_note : k_text);
  return canvas;
}

std::string share_label(std::uint64_t count, std::uint64_t total) {
  const double percent = 100.0 * static_cast<double>(count) / static_cast<double>(total);
  return percent < 0.1 ? "  < 0.1 %" : fmt::format("  {:.1f} %", percent);
}

int draw_swatch(Canvas& canvas, const Font& font, int left, int top, const Rgb8& color,
                const std::string& label) {
  const PixelBox box{left, top, left + k_panel_row, top + k_panel_row - 8};
  canvas.fill(box, color);
  canvas.frame(box, k_panel_line);
  font.draw(canvas, box.right + 8, top + 16, label, k_panel_font_size, k_panel_text);
  return top + k_panel_row;
}

int draw_color_bar(Canvas& canvas, const Font& font, int left, int top, const ValueRange& range,
                   std::span<const RoundTick> ticks, const std::function<Rgb8(double share)>& color) {
  constexpr int k_height = k_panel_bar_height;
  const int right = left + k_panel_bar_width;
  for (int i = 0; i < k_height; ++i)
    canvas.fill({left, top + i, right, top + i + 1}, color(1.0 - static_cast<double>(i) / (k_height - 1)));
  canvas.frame({left - 1, top - 1, right + 1, top + k_height + 1}, k_panel_line);
  for (const RoundTick& tick : ticks) {
    const int y = top + static_cast<int>(std::lround((1.0 - range.share(tick.value)) * (k_height - 1)));
    canvas.fill({right + 1, y, right + 7, y + 1}, k_panel_line);
    font.draw(canvas, right + 12, y + 6, tick.label, k_panel_font_size, k_panel_text);
  }
  return top + k_height + k_panel_row;
}

void write_legend(const ColorKey& key, const std::filesystem::path& file,
                  const std::optional<glm::ivec2>& size, bool overwrite) {
  const Font font(find_font());
  const Canvas canvas = draw_legend(key, lay_out_legend(key, font, size), font);
  write_png(canvas, file, overwrite);
}

}  // namespace alidade::image
