// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "image/canvas.h"
#include "image/color_key.h"
#include "image/font.h"
#include "image/point_color.h"

namespace alidade::image {

/// A value on a scale and how it is written.
struct RoundTick {
  double value = 0.0;
  std::string label;
};

/// The multiples of 1, 2 or 5 times a power of ten within a range (both ends included), of the finest such
/// step that gives at most `most` of them; all labels have as many decimals as the step needs. A range of one
/// value, or one too narrow for its digits, gives just its ends. Requires low <= high, magnitudes up to
/// k_largest_value, most >= 2.
std::vector<RoundTick> round_ticks(const ValueRange& range, int most);

// Legends: the meaning of an image's colours as a small image for reports, a colour bar with round ticks
// or a list of swatches with names, numbers of points and shares. Black on white.

struct LegendTick {
  double value = 0.0;
  int y = 0;  ///< the row of the bar with this value's colour
};

struct LegendSwatch {
  PixelBox box;
  Color16 color{0};
};

/// A line of text; see font.h.
struct LegendText {
  std::string text;
  int x = 0, baseline = 0;
  int size = 0;  ///< of the font, pixels
  bool is_note = false;
};

/// The layout of a legend, in pixels.
struct LegendLayout {
  int width = 0, height = 0;
  int font_size = 0;
  PixelBox bar;  ///< empty without a scale; high values on top
  std::vector<LegendTick> ticks;
  std::vector<LegendSwatch> swatches;  ///< those of the key, then "no value" if there are such points
  std::vector<LegendText> texts;       ///< title, labels, notes
};

/// Font size of a legend whose size is not given, pixels.
inline constexpr int k_legend_font_size = 20;

/// Lays out the legend: as large as its texts need at k_legend_font_size, or into `size` pixels with the
/// largest font for which all fits; a bar then takes what height is left. Errors: those of check_legend();
/// the size is too small for a font of 8 pixels.
LegendLayout lay_out_legend(const ColorKey& key, const Font& font,
                            const std::optional<glm::ivec2>& size = {});

/// The legend as an image.
Canvas draw_legend(const ColorKey& key, const LegendLayout& layout, const Font& font);

// The panel beside a map: swatches, a bar of colours and notes, one below the other.

inline constexpr int k_panel_font_size = 18, k_panel_note_size = 14, k_panel_row = 28;
inline constexpr int k_panel_bar_width = 24, k_panel_bar_height = 240;
inline constexpr Rgb8 k_panel_text{30, 30, 30}, k_panel_note{95, 95, 95}, k_panel_line{60, 60, 60};

/// The share of a swatch's pixels as its label shows it, behind two blanks: "  12.3 %", "  < 0.1 %".
std::string share_label(std::uint64_t count, std::uint64_t total);

/// Draws a swatch with its label. Returns where the next row begins.
int draw_swatch(Canvas& canvas, const Font& font, int left, int top, const Rgb8& color,
                const std::string& label);

/// Draws the colours of a scale, color(share) for shares from 1 on top to 0, with ticks. Returns where the
/// next row begins.
int draw_color_bar(Canvas& canvas, const Font& font, int left, int top, const ValueRange& range,
                   std::span<const RoundTick> ticks, const std::function<Rgb8(double share)>& color);

/// Writes the legend as PNG, with the font of find_font(). The file is written completely or not at all.
/// Equal bytes for equal key, size, font and version of FreeType. Errors: those of lay_out_legend(); a name
/// that does not end in .png; an existing file without `overwrite`; a full disk and other write failures.
void write_legend(const ColorKey& key, const std::filesystem::path& file,
                  const std::optional<glm::ivec2>& size, bool overwrite);

}  // namespace alidade::image
