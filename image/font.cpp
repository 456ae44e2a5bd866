// SPDX-License-Identifier: MIT
#include "image/font.h"

#include <ft2build.h>
#include <algorithm>
#include <cassert>
#include FT_FREETYPE_H
#include <system_error>

#include "base/error.h"

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

struct Font::Face {
  FT_Library library = nullptr;
  FT_Face face = nullptr;

  ~Face() {
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }

  /// Calls visit(glyph, pen) for every character, with the column where it begins, and returns the column
  /// after the last.
  template <class Visit>
  int for_each_glyph(std::string_view text, int size, const Visit& visit) const {
    assert(size >= 1);
    FT_Set_Pixel_Sizes(face, 0, static_cast<FT_UInt>(size));
    constexpr int k_unit_bits = 6;
    int pen = 0;
    for (const char32_t character : characters_of(text)) {
      // The light hints keep stems crisp from top to bottom and do not move characters sideways.
      if (FT_Load_Char(face, character, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT) != 0) continue;
      visit(*face->glyph, pen);
      pen += static_cast<int>(face->glyph->advance.x >> k_unit_bits);
    }
    return pen;
  }
};

Font::Font(const std::filesystem::path& file) : face_(std::make_unique<Face>()) {
  const bool opened = FT_Init_FreeType(&face_->library) == 0 &&
                      FT_New_Face(face_->library, file.c_str(), 0, &face_->face) == 0 &&
                      FT_IS_SCALABLE(face_->face);
  if (!opened) throw file_error(file, "not a font file");
}

Font::~Font() = default;
Font::Font(Font&&) noexcept = default;
Font& Font::operator=(Font&&) noexcept = default;

TextExtent Font::measure(std::string_view text, int size) const {
  TextExtent extent;
  extent.width = face_->for_each_glyph(text, size, [&](const FT_GlyphSlotRec_& glyph, int) {
    extent.ascent = std::max(extent.ascent, glyph.bitmap_top);
    extent.descent = std::max(extent.descent, static_cast<int>(glyph.bitmap.rows) - glyph.bitmap_top);
  });
  return extent;
}

void Font::draw(Canvas& canvas, int x, int baseline, std::string_view text, int size,
                const Rgb8& color) const {
  face_->for_each_glyph(text, size, [&](const FT_GlyphSlotRec_& glyph, int pen) {
    const int left = x + pen + glyph.bitmap_left, top = baseline - glyph.bitmap_top;
    for (int row = 0; row < static_cast<int>(glyph.bitmap.rows); ++row) {
      const unsigned char* const covers = glyph.bitmap.buffer + row * glyph.bitmap.pitch;
      for (int column = 0; column < static_cast<int>(glyph.bitmap.width); ++column)
        canvas.blend(left + column, top + row, color, covers[column]);
    }
  });
}

}  // namespace alidade::image
