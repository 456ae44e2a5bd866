// SPDX-License-Identifier: MIT
#include "image/font.h"

#include <algorithm>
#include <cassert>
#include <system_error>

#include "base/error.h"
#include "image/backend.h"

namespace alidade::image {
namespace {

constexpr char32_t k_replacement = 0xFFFD;

/// The characters of UTF-8; the replacement character for every invalid byte.
std::vector<char32_t> characters_of(std::string_view text) {
  std::vector<char32_t> characters;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>(text[k]); };
    const std::uint8_t first = byte(i);
    const std::size_t length = first < 0x80       ? 1
                               : first >> 5 == 6  ? 2
                               : first >> 4 == 14 ? 3
                               : first >> 3 == 30 ? 4
                                                  : 0;
    char32_t character = length == 1 ? first : first & (0x7Fu >> length);
    bool whole = length > 0 && i + length <= text.size();
    for (std::size_t k = 1; whole && k < length; ++k) {
      whole = byte(i + k) >> 6 == 2;
      character = character << 6 | (byte(i + k) & 0x3Fu);
    }
    characters.push_back(whole ? character : k_replacement);
    i += whole ? length : 1;
  }
  return characters;
}

/// Calls visit(glyph, pen) for every character, with the column where it begins, and returns the column
/// after the last.
template <class Visit>
int for_each_glyph(FontFace& face, std::string_view text, int size, const Visit& visit) {
  assert(size >= 1);
  face.set_size(size);
  int pen = 0;
  for (const char32_t character : characters_of(text)) {
    const std::optional<Glyph> glyph = face.draw(character);
    if (!glyph) continue;
    visit(*glyph, pen);
    pen += glyph->advance;
  }
  return pen;
}

}  // namespace

std::span<const std::filesystem::path> font_files() {
  static const std::array<std::filesystem::path, 5> files = {
      "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
      "/usr/share/fonts/TTF/DejaVuSans.ttf", "/usr/share/fonts/dejavu/DejaVuSans.ttf",
      "/usr/local/share/fonts/DejaVuSans.ttf"};
  return files;
}

std::filesystem::path find_font(std::span<const std::filesystem::path> files) {
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error)) return file;
  }
  throw file_error(files.empty() ? "" : files.front().string(), "missing font for the legend",
                   "DejaVu Sans (Debian: fonts-dejavu-core)");
}

Font::Font(const std::filesystem::path& file) : face_(backend().open_font(file.string())) {
  if (face_ == nullptr) throw file_error(file, "not a font file");
}

Font::~Font() = default;
Font::Font(Font&&) noexcept = default;
Font& Font::operator=(Font&&) noexcept = default;

TextExtent Font::measure(std::string_view text, int size) const {
  TextExtent extent;
  extent.width = for_each_glyph(*face_, text, size, [&](const Glyph& glyph, int) {
    extent.ascent = std::max(extent.ascent, glyph.top);
    extent.descent = std::max(extent.descent, glyph.height - glyph.top);
  });
  return extent;
}

void Font::draw(Canvas& canvas, int x, int baseline, std::string_view text, int size,
                const Rgb8& color) const {
  for_each_glyph(*face_, text, size, [&](const Glyph& glyph, int pen) {
    const int left = x + pen + glyph.left, top = baseline - glyph.top;
    for (int row = 0; row < glyph.height; ++row) {
      const unsigned char* const covers = glyph.covers + row * glyph.pitch;
      for (int column = 0; column < glyph.width; ++column)
        canvas.blend(left + column, top + row, color, covers[column]);
    }
  });
}

}  // namespace alidade::image
