// SPDX-License-Identifier: MIT
#include "camera/formats/image_file_size.h"

#include <cstring>
#include <optional>
#include <string>

#include "base/error.h"

// Source of both layouts: ISO/IEC 15948 (PNG), ITU-T T.81 annex B (JPEG). Numbers are big endian.

namespace alidade {
namespace {

std::uint64_t number_at(std::span<const std::byte> bytes, std::size_t place, std::size_t count) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < count; ++i)
    number = number << 8 | std::to_integer<std::uint64_t>(bytes[place + i]);
  return number;
}

std::optional<ImageFileSize> png_size(InputFile& file) {
  constexpr char k_beginning[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
  const std::span<const std::byte> bytes = file.view_up_to(0, 24);
  if (bytes.size() < 24 || std::memcmp(bytes.data(), k_beginning, 16) != 0) return std::nullopt;
  return ImageFileSize{number_at(bytes, 16, 4), number_at(bytes, 20, 4)};
}

/// The segment that begins a frame: C0 to CF but for DHT, JPG and DAC.
bool is_frame(std::uint64_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

std::optional<ImageFileSize> jpeg_size(InputFile& file) {
  const std::span<const std::byte> beginning = file.view_up_to(0, 2);
  if (beginning.size() < 2 || number_at(beginning, 0, 2) != 0xFFD8) return std::nullopt;
  // Photos carry thumbnails and profiles before the frame, of some megabytes at most.
  constexpr std::uint64_t k_farthest_frame = 64u << 20;
  for (std::uint64_t place = 2; place < k_farthest_frame;) {
    const std::span<const std::byte> bytes = file.view_up_to(place, 9);
    if (bytes.size() < 9 || number_at(bytes, 0, 1) != 0xFF) return std::nullopt;
    const std::uint64_t marker = number_at(bytes, 1, 1);
    if (is_frame(marker)) return ImageFileSize{number_at(bytes, 7, 2), number_at(bytes, 5, 2)};
    if (marker == 0xFF) {
      place += 1;  // a filling byte
    } else if (marker == 0xDA || marker == 0xD9) {
      return std::nullopt;  // the picture or its end, without a frame before
    } else {
      place += 2 + number_at(bytes, 2, 2);
    }
  }
  return std::nullopt;
}

std::filesystem::path existing(const std::filesystem::path& file) {
  std::error_code error;
  for (const char* const extension : {"", ".png", ".jpg", ".jpeg"}) {
    std::filesystem::path name = file;
    name += extension;
    if (std::filesystem::is_regular_file(name, error)) return name;
  }
  throw Error({.problem = "size of the image is not told and its file is missing",
               .expected = "width and height, or the file " + file.string()});
}

}  // namespace

ImageFileSize image_file_size(InputFile& file) {
  if (const auto size = png_size(file)) return *size;
  if (const auto size = jpeg_size(file)) return *size;
  throw Error(
      {.file = file.name(), .problem = "size of the image cannot be read", .expected = "a PNG or JPEG file"});
}

ImageFileSize image_file_size(const std::filesystem::path& path) {
  InputFile file(existing(path));
  return image_file_size(file);
}

}  // namespace alidade
