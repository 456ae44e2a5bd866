// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "image/pixel_box.h"

namespace alidade::compare {

/// The encoding of an image file's colours: files of whole numbers (8, 16 bits) hold sRGB codes, files of
/// half or float numbers hold linear light.
enum class ColorEncoding { display, linear };

/// An image as it is compared: row by row from the top, pixel (0, 0) top left. Layers that the file does not
/// have are empty. Memory per pixel: colour 12 bytes, alpha 4, depth 4, its sigma 4, normals 12, ids 4.
struct ComparedImage {
  std::filesystem::path file;
  int width = 0, height = 0;
  int origin_x = 0, origin_y = 0;  ///< where an EXR's data window begins in its display window
  ColorEncoding encoding = ColorEncoding::display;
  int color_channels = 0;    ///< as stored: 1 (grey, copied to three) or 3; 0: layers only
  int largest_code = 0;      ///< of a display image: 255, 65535; 0: not whole numbers (linear, resized)
  std::vector<float> color;  ///< 3 per pixel; display: code / largest code; linear: as stored
  std::vector<float> alpha;  ///< 1 per pixel, not multiplied into display colours
  std::vector<float> depth;  ///< layer Z, metres; where there is nothing, not is_depth()
  /// Layer depth.sigma, metres: standard deviation of depth; infinite: unknown.
  std::vector<float> depth_sigma;
  std::vector<float> normals;      ///< layer N, 3 per pixel; 0 0 0 where there is nothing
  std::vector<std::uint32_t> ids;  ///< layer id: point id + 1; 0 where there is nothing
  std::vector<std::pair<std::string, std::string>> metadata;  ///< of our own images and of EXIF, as texts

  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// An image without pixels that is otherwise like `image`, in another size.
ComparedImage in_size(const ComparedImage& image, int width, int height);

/// Number of a pixel, row by row, in an image with rows of `width`.
inline std::size_t pixel_index(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

/// The two images differ in size (or in position within their display windows).
class SizeMismatch : public Error {
 public:
  using Error::Error;
};

/// Three values of linear light per pixel: the sRGB curve (IEC 61966-2-1) undone where needed.
std::vector<float> linear_color(const ComparedImage& image);
/// Three sRGB values in 0 .. 1 per pixel; linear light is clamped to 0 .. 1 first (NaN becomes 0).
std::vector<float> display_color(const ComparedImage& image);

/// Whether a value is a depth: finite and above 0. Other values mean that there is nothing.
bool is_depth(float depth);
/// Whether a pixel shows something: alpha of at least one half, and a depth, as far as the image has them.
bool shows_surface(const ComparedImage& image, std::size_t pixel);

/// Throws SizeMismatch naming the files and sizes unless width, height and origin are equal.
void require_same_size(const ComparedImage& reference, const ComparedImage& test);

/// As require_same_size(), and throws Error with this problem unless both images have colours.
void require_colors(const ComparedImage& reference, const ComparedImage& test, const char* problem);

/// Whether all three components of a colour or a normal are finite.
inline bool is_finite(const float* three) {
  return std::isfinite(three[0]) && std::isfinite(three[1]) && std::isfinite(three[2]);
}

/// The part of all layers inside the rectangle. Errors: it is empty or reaches beyond the image.
ComparedImage cropped(const ComparedImage& image, const image::PixelBox& rectangle);

/// Which pixels count.
struct ImageMask {
  std::vector<std::uint8_t> counts;  ///< one per pixel, 1 counts, 0 does not; empty: all do

  bool at(std::size_t pixel) const { return counts.empty() || counts[pixel] != 0; }
};

/// Number of pixels that count in an image of so many.
std::uint64_t counted_pixels(const ImageMask& mask, std::size_t pixels);

// Each of these takes pixels out of `mask`; several in a row leave what all of them leave. "Every image
// that has it" are those of the two that have the layer in question. Errors name what is missing.

/// Leaves the pixels that are light in a mask image: above half of the display range in the mean of its
/// channels. Errors: another width or height than `image` (SizeMismatch), an image without colour.
void keep_light(ImageMask& mask, const ComparedImage& mask_image, const ComparedImage& image);

/// Leaves pixels with alpha >= `least` in every image that has it. Errors: none of them has alpha.
void keep_alpha(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test,
                float least = 0.5f);

/// Leaves pixels whose depth is finite and above 0 in every image that has it. Errors: none has depth.
void keep_valid_depth(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test);

/// Takes out pixels that are sky (id 0; without ids: no depth) in every image that has it: where one
/// sees a surface and the other the sky something changed, and it stays. Errors: none has ids or depth.
void ignore_sky(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test);

/// Leaves the pixels inside any of the rectangles, which may reach beyond the image. None: all stay.
void keep_rectangles(ImageMask& mask, const ComparedImage& image,
                     std::span<const image::PixelBox> rectangles);
/// Takes out the pixels inside any of them.
void ignore_rectangles(ImageMask& mask, const ComparedImage& image,
                       std::span<const image::PixelBox> rectangles);

/// Takes out pixels with a NaN or infinite colour value in either image; returns how many it took out.
/// The metrics leave out such pixels by themselves.
std::uint64_t keep_finite(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test);

}  // namespace alidade::compare
