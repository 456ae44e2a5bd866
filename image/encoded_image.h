// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace alidade::image {

/// An image as screens show it: red, green, blue of 8 bits (sRGB), rows from the top.
struct ByteImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> bytes;  ///< 3 per pixel
};

/// How images are packed into a page.
enum class ImagePacking {
  automatic,  ///< png up to 2 million pixels, jpeg beyond
  png,        ///< without loss
  jpeg        ///< quality 92, colours at full resolution: about a fifth of the size
};

/// `wanted`, with `automatic` replaced by png or jpeg for an image of this many pixels.
ImagePacking packing_for(ImagePacking wanted, std::size_t pixels);

/// "data:image/png;base64,...": the image as an address that holds all of it. Cost: up to a second for 8
/// million pixels. Errors: what OpenImageIO reports.
std::string data_url(const ByteImage& image, ImagePacking packing);

/// The image with means of squares of pixels, at most `longest_side` wide and high. Requires longest_side
/// >= 1.
ByteImage shrunk(const ByteImage& image, int longest_side);

/// RFC 4648, with padding.
std::string base64(std::span<const unsigned char> bytes);

}  // namespace alidade::image
