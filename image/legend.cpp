// SPDX-License-Identifier: MIT
#include "image/legend.h"

#include <algorithm>

#include "image/canvas_png.h"
#include "image/find_font.h"

namespace alidade {
namespace {

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
    const double place = constant ? 0.5 : static_cast<double>(bar.bottom - 1 - y) / (bar.height() - 1);
    canvas.fill({bar.left, y, bar.right, y + 1}, to_rgb8(to_color16(map_color(scale.map, place))));
  }
  canvas.frame(around(bar), k_line);
  const int length = std::max(layout.font_size / 3, 2);
  for (const LegendTick& tick : layout.ticks)
    canvas.fill({bar.right + 1, tick.y, bar.right + 1 + length, tick.y + 1}, k_line);
}

}  // namespace

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

void write_legend(const ColorKey& key, const std::filesystem::path& file,
                  const std::optional<glm::ivec2>& size, bool overwrite) {
  const Font font(find_font());
  const Canvas canvas = draw_legend(key, lay_out_legend(key, font, size), font);
  write_png(canvas, file, overwrite);
}

}  // namespace alidade
