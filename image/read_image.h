// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/color.h"

namespace alidade::image {

/// OpenImageIO's message about a failure, in one line: its lines without those that another one repeats and
/// extends.
std::string image_trouble(const std::string& said);

/// Size of an image's file in bytes. Errors: no such file, not a regular file, cannot be read.
std::uint64_t image_file_size(const std::filesystem::path& file);

/// Pixels of a sky image, linear, row 0 on top.
struct SkyPixels {
  int width = 0, height = 0;
  std::vector<Rgb> values{};
  std::string warning{};  ///< values of the image that were corrected; empty = none
};

/// The most pixels a sky image may have, inclusive: 16384 x 8192. A sky takes 20 bytes for each.
inline constexpr std::uint64_t k_most_sky_pixels = 1u << 27;

/// Reads a sky from an image in any format that OpenImageIO reads (EXR, HDR, TIFF, PNG, JPEG, ...): the
/// channels R, G, B, else the first three, or one as grey; alpha is ignored. Values are taken as linear, but
/// those of whole-number formats as sRGB. Values that light cannot have are corrected and reported in the
/// warning: negative ones and NaN count as 0, infinite ones as 65504 (the largest half), those above 1e9 as
/// 1e9. Errors: no such file, not an image, deep or 3D, a cut-out (its data window is not the whole), no
/// pixels or more than k_most_sky_pixels, more than 4096 pixels per byte of the file (no format packs so
/// many), pixels missing. Memory: 12 bytes per pixel.
SkyPixels read_sky_image(const std::filesystem::path& file);

/// Width and height of an image.
struct ImageSize {
  int width = 0, height = 0;
  bool operator==(const ImageSize&) const = default;
};

/// "640 x 480", for messages.
std::string size_text(const ImageSize& size);

/// The pixels of a photo as they are displayed, 8 bits each, row 0 on top.
struct PhotoPixels {
  ImageSize size{};
  std::vector<std::array<std::uint8_t, 3>> values{};  ///< red, green, blue
};

/// The bytes of an image that is in memory; empty: it is a file.
using ImageBytes = std::optional<std::span<const std::byte>>;

/// Size of a photo as its pixels are stored: an orientation in its metadata does not count, as cameras of
/// photogrammetry do not count it. Errors: no such file; not an image; deep or 3D; floating-point values,
/// which have no display; more than 2^28 pixels, or more than 4096 per byte of the file. Cost: that of
/// reading the header. Of a photo in memory `file` is its name in messages, with the extension of its format.
ImageSize photo_size(const std::filesystem::path& file, const ImageBytes& bytes = {});

/// Reads a photo in any format that OpenImageIO reads (JPEG, PNG, TIFF, ...): the channels R, G, B, else the
/// first three, or one as grey; alpha is ignored; 16 bits become 8. Errors: those of photo_size(); pixels
/// missing. Memory: 3 bytes per pixel.
PhotoPixels read_photo(const std::filesystem::path& file, const ImageBytes& bytes = {});

}  // namespace alidade::image
