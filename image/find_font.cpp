// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "image/font.h"

#include <system_error>

namespace alidade::image {

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

}  // namespace alidade::image
