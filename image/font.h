// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "image/canvas.h"

namespace alidade::image {

/// Where Linux distributions keep DejaVu Sans, Debian's folder first.
std::span<const std::filesystem::path> font_files();

/// The font of legends: the first of these paths that is a file. Errors: none is; the message names the
/// package that brings one.
std::filesystem::path find_font(std::span<const std::filesystem::path> files = font_files());

class FontFace;

/// The extent of a line of text, in pixels from its beginning on the baseline.
struct TextExtent {
  int width = 0;    ///< to where the next character would begin
  int ascent = 0;   ///< of the highest character, up
  int descent = 0;  ///< of the lowest character, down
};

/// A font, through FreeType. Texts are UTF-8, one line, without kerning; invalid UTF-8 and characters that
/// the font lacks show as its mark for missing ones. Equal pixels for equal font, size and version of
/// FreeType. Not thread safe.
class Font {
 public:
  /// Errors: not a font that FreeType reads.
  explicit Font(const std::filesystem::path& file);
  ~Font();
  Font(Font&&) noexcept;
  Font& operator=(Font&&) noexcept;

  /// `size`: pixels of the em square, which is about the distance of lines; at least 1.
  TextExtent measure(std::string_view text, int size) const;
  /// The first character is at x on the row `baseline`, the last above it.
  void draw(Canvas& canvas, int x, int baseline, std::string_view text, int size, const Rgb8& color) const;

 private:
  std::unique_ptr<FontFace> face_;
};

}  // namespace alidade::image
