// SPDX-License-Identifier: MIT
#include "image/font.h"

#include <array>
#include <system_error>

#include "base/error.h"

namespace alidade::image {

std::span<const std::filesystem::path> font_places() {
  static const std::array<std::filesystem::path, 5> places = {
      "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
      "/usr/share/fonts/TTF/DejaVuSans.ttf", "/usr/share/fonts/dejavu/DejaVuSans.ttf",
      "/usr/local/share/fonts/DejaVuSans.ttf"};
  return places;
}

std::filesystem::path find_font(std::span<const std::filesystem::path> places) {
  for (const std::filesystem::path& place : places) {
    std::error_code error;
    if (std::filesystem::is_regular_file(place, error)) return place;
  }
  throw Error({.file = places.empty() ? "" : places.front().string(),
               .problem = "missing font for the legend",
               .expected = "DejaVu Sans (Debian: fonts-dejavu-core)"});
}

}  // namespace alidade::image
