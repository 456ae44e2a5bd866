// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "image/check_legend.h"
#include "image/legend.h"
#include "image/round_ticks.h"

namespace alidade {
namespace {

/// "1 234 567".
std::string grouped(std::uint64_t count) {
  std::string text = std::to_string(count);
  for (std::size_t place = text.size(); place > 3; place -= 3) text.insert(place - 3, 1, ' ');
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

/// Puts one thing below the other.
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
      add_ending(tick.label, label_end, y);
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
      add_ending(row.number, number_end, middle);
      add_text(row.label, label_x, middle + digit_height_ / 2, em_);
      if (row.count) {
        add_ending(grouped(*row.count), count_end, middle);
        add_ending(share_text(*row.count, total), share_end, middle);
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

  /// A text that ends at x, its digits around the row y.
  void add_ending(const std::string& text, int x, int y) {
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

}  // namespace

LegendLayout lay_out_legend(const ColorKey& key, const Font& font, const std::optional<glm::ivec2>& size) {
  constexpr int k_smallest_font = 8, k_bar_ems = 13;
  check_legend(key);
  const auto natural = [&](int font_size) { return lay_out(key, font, font_size, k_bar_ems * font_size); };
  const LegendLayout usual = natural(k_legend_font_size);
  if (!size) return usual;

  const double scale =
      std::min(static_cast<double>(size->x) / usual.width, static_cast<double>(size->y) / usual.height);
  // Texts do not grow evenly with their font: begin a little above what is expected.
  int font_size = std::max(k_smallest_font, static_cast<int>(scale * k_legend_font_size) + 2);
  LegendLayout layout = natural(font_size);
  while (font_size > k_smallest_font && !fits(layout, *size)) layout = natural(--font_size);
  if (!fits(layout, *size)) {
    throw Error({.problem = "the legend does not fit its size",
                 .expected = fmt::format("at least {}x{} pixels", layout.width, layout.height),
                 .found = fmt::format("{}x{}", size->x, size->y)});
  }
  if (key.scale) layout = lay_out(key, font, font_size, k_bar_ems * font_size + size->y - layout.height);
  layout.width = size->x;
  layout.height = size->y;
  return layout;
}

}  // namespace alidade
