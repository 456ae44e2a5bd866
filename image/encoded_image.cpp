// SPDX-License-Identifier: MIT
#include "image/encoded_image.h"

#include <fmt/format.h>
#include <algorithm>

#include "base/error.h"
#include "image/backend.h"

namespace alidade::image {

ImagePacking packing_for(ImagePacking wanted, std::size_t pixels) {
  constexpr std::size_t k_most_lossless = 2'000'000;
  if (wanted != ImagePacking::automatic) return wanted;
  return pixels <= k_most_lossless ? ImagePacking::png : ImagePacking::jpeg;
}

std::string data_url(const ByteImage& image, ImagePacking packing) {
  const std::size_t pixels = image.bytes.size() / 3;
  const bool is_png = packing_for(packing, pixels) == ImagePacking::png;
  const std::string format = is_png ? "png" : "jpeg";
  ImageToWrite written{
      {image.width, image.height, 3, ValueType::uint8}, format, {{"oiio:ColorSpace", "sRGB"}}};
  if (is_png) {
    // The last percents of size cost most of the time.
    written.attributes.emplace_back("png:compressionLevel", pixels > 1'000'000 ? 3 : 9);
  } else {
    written.attributes.emplace_back("Compression", "jpeg:92");
    written.attributes.emplace_back("jpeg:subsampling", "4:4:4");
  }
  const auto rows = [&](int begin, int) {
    const std::size_t first = 3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(begin);
    return std::as_bytes(std::span(image.bytes)).subspan(first).data();
  };
  std::vector<unsigned char> encoded;
  const Failure failure = backend().encode(written, "report." + format, rows, encoded);
  if (failure) throw Error({.problem = "cannot encode an image of the report: " + *failure});
  return fmt::format("data:image/{};base64,", format) + base64(encoded);
}

ByteImage shrunk(const ByteImage& image, int longest_side) {
  const int step = std::max(1, (std::max(image.width, image.height) + longest_side - 1) / longest_side);
  ByteImage small{
      .width = (image.width + step - 1) / step, .height = (image.height + step - 1) / step, .bytes = {}};
  small.bytes.reserve(static_cast<std::size_t>(small.width) * static_cast<std::size_t>(small.height) * 3);
  for (int y = 0; y < image.height; y += step) {
    for (int x = 0; x < image.width; x += step) {
      const int right = std::min(x + step, image.width), bottom = std::min(y + step, image.height);
      const int count = (right - x) * (bottom - y);
      for (int c = 0; c < 3; ++c) {
        int sum = count / 2;
        for (int row = y; row < bottom; ++row)
          for (int column = x; column < right; ++column)
            sum += image.bytes[(static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                                static_cast<std::size_t>(column)) *
                                   3 +
                               static_cast<std::size_t>(c)];
        small.bytes.push_back(static_cast<std::uint8_t>(sum / count));
      }
    }
  }
  return small;
}

std::string base64(std::span<const unsigned char> bytes) {
  constexpr std::string_view k_digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t three = std::uint32_t{bytes[i]} << 16;
    if (left > 1) three |= std::uint32_t{bytes[i + 1]} << 8;
    if (left > 2) three |= bytes[i + 2];
    for (std::size_t digit = 0; digit < 4; ++digit)
      text += digit <= left ? k_digits[three >> (18 - 6 * digit) & 63] : '=';
  }
  return text;
}

}  // namespace alidade::image
