// SPDX-License-Identifier: MIT
#include "image/read_image.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <system_error>

#include "base/error.h"
#include "image/backend.h"

namespace alidade::image {
namespace {

constexpr std::uint64_t k_most_pixels_per_byte = 4096;
constexpr float k_infinite_light = 65504.0f, k_most_light = 1e9f;

/// Errors: not a flat image, a cut-out, or more pixels than these or than the file can hold.
struct ImageLimits {
  std::string content;
  std::uint64_t pixels;
  std::string pixels_text;
};

void check(const ImageHeader& header, std::uint64_t file_size, const ImageLimits& limits,
           const std::filesystem::path& file) {
  if (header.is_deep || header.depth > 1)
    throw file_error(file, "not a flat image", "one value per channel and pixel");
  if (header.width < 1 || header.height < 1 || header.channel_count < 1)
    throw file_error(file, "the image has no pixels");
  const std::string found = size_text({header.width, header.height});
  const auto count = static_cast<std::uint64_t>(header.width) * static_cast<std::uint64_t>(header.height);
  if (count > limits.pixels)
    throw file_error(file, "too large for a " + limits.content, limits.pixels_text, found);
  if (count / k_most_pixels_per_byte > file_size) {
    throw file_error(file, "the file is too short for its pixels",
                     "more than " + std::to_string(file_size) + " bytes", found);
  }
  const bool is_whole = header.x == header.full_x && header.y == header.full_y &&
                        header.width == header.full_width && header.height == header.full_height;
  if (!is_whole) {
    throw file_error(file, "the image is a crop",
                     "all " + size_text({header.full_width, header.full_height}) + " pixels", found);
  }
}

/// An image that was checked, open for reading. Its bytes in memory must outlive it.
std::unique_ptr<ImageReader> open_image(const std::filesystem::path& file, const ImageBytes& bytes,
                                        const ImageLimits& limits) {
  const std::uint64_t byte_count = bytes ? bytes->size() : image_file_size(file);
  std::string failure;
  std::unique_ptr<ImageReader> image = backend().open_image(file.string(), bytes, failure);
  if (!image) throw file_error(file, "cannot read the image: " + image_trouble(failure));
  check(image->header(), byte_count, limits, file);
  return image;
}

ChannelRun color_channels(const ImageHeader& header) {
  if (header.channel_count < 3) return {0, 1};
  const std::vector<std::string>& names = header.channel_names;
  for (int i = 0; i + 2 < static_cast<int>(names.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (names[at] == "R" && names[at + 1] == "G" && names[at + 2] == "B") return {i, i + 3};
  }
  return {0, 3};
}

/// Reads the channels of all pixels, which are `stride` bytes apart.
void read_channels(ImageReader& image, ChannelRun channels, ValueType type, void* values, std::size_t stride,
                   const std::filesystem::path& file) {
  const Failure failure = image.read_all(channels, type, values, stride);
  if (failure) throw file_error(file, "the image has missing pixels: " + image_trouble(*failure));
}

/// Linear values of the display values 0, 1/65535, ... 1.
std::vector<float> linear_values() {
  std::vector<float> values(65536);
  for (std::size_t code = 0; code < values.size(); ++code)
    values[code] = static_cast<float>(linear_from_srgb(static_cast<double>(code) / 65535.0));
  return values;
}

std::unique_ptr<ImageReader> open_photo(const std::filesystem::path& file, const ImageBytes& bytes) {
  constexpr std::uint64_t k_most_pixels = 1u << 28;
  std::unique_ptr<ImageReader> image = open_image(
      file, bytes, {"photo", k_most_pixels, "at most " + std::to_string(k_most_pixels) + " pixels"});
  if (is_float(image->header().type)) {
    throw file_error(file, "a photo with floating-point values",
                     "a photo of 8 or 16 bits per channel, such as JPEG, PNG or TIFF");
  }
  return image;
}

/// Converts a value to light; counts invalid ones.
float light_of(float value, std::uint64_t& replaced) {
  if (value >= 0.0f && value <= k_most_light) return value;
  ++replaced;
  if (!(value > 0.0f)) return 0.0f;
  return std::isinf(value) ? k_infinite_light : k_most_light;
}

}  // namespace

std::string image_trouble(const std::string& said) {
  std::vector<std::string> lines;
  std::istringstream stream(said);
  for (std::string line; std::getline(stream, line);) {
    line.erase(line.find_last_not_of(" \r\t") + 1);
    const auto holds_line = [&](const std::string& other) { return other.find(line) != std::string::npos; };
    if (std::ranges::any_of(lines, holds_line)) continue;
    std::erase_if(lines, [&](const std::string& other) { return line.find(other) != std::string::npos; });
    lines.push_back(line);
  }
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "; ") + line;
  return text.empty() ? "unknown reason" : text;
}

std::uint64_t image_file_size(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw file_error(file, "no such file");
  if (!std::filesystem::is_regular_file(status)) throw file_error(file, "not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw file_error(file, "cannot read the image");
  return size;
}

SkyPixels read_sky_image(const std::filesystem::path& file) {
  const std::unique_ptr<ImageReader> image =
      open_image(file, {},
                 {"sky", k_most_sky_pixels,
                  "at most " + std::to_string(k_most_sky_pixels) + " pixels, as in 16384 x 8192"});
  const ImageHeader& header = image->header();

  SkyPixels pixels{.width = header.width, .height = header.height};
  pixels.values.resize(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height));
  const ChannelRun channels = color_channels(header);
  const bool is_grey = channels.end - channels.begin == 1;
  read_channels(*image, channels, ValueType::single, pixels.values.data(), sizeof(Rgb), file);
  if (is_grey)
    for (Rgb& value : pixels.values) value = Rgb(value.r);

  if (!is_float(header.type_of(channels.begin))) {
    const std::vector<float> linear = linear_values();
    for (Rgb& value : pixels.values)
      for (int i = 0; i < 3; ++i)
        value[i] = linear[static_cast<std::size_t>(std::lround(std::clamp(value[i], 0.0f, 1.0f) * 65535.0f))];
    return pixels;
  }
  std::uint64_t replaced = 0;
  for (Rgb& value : pixels.values)
    for (int i = 0; i < 3; ++i) value[i] = light_of(value[i], replaced);
  if (replaced > 0) {
    pixels.warning =
        file.string() + ": " + std::to_string(is_grey ? replaced / 3 : replaced) +
        " invalid radiances (negative, not finite or above 1e9): using 0 for negative values and NaN, "
        "65504 for infinity";
  }
  return pixels;
}

std::string size_text(const ImageSize& size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

ImageSize photo_size(const std::filesystem::path& file, const ImageBytes& bytes) {
  const std::unique_ptr<ImageReader> image = open_photo(file, bytes);
  return {image->header().width, image->header().height};
}

PhotoPixels read_photo(const std::filesystem::path& file, const ImageBytes& bytes) {
  const std::unique_ptr<ImageReader> image = open_photo(file, bytes);
  const ImageHeader& header = image->header();
  PhotoPixels pixels{.size = {header.width, header.height}};
  pixels.values.resize(static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height));
  const ChannelRun channels = color_channels(header);
  const bool is_grey = channels.end - channels.begin == 1;
  read_channels(*image, channels, ValueType::uint8, pixels.values.data(), sizeof(pixels.values[0]), file);
  if (is_grey)
    for (std::array<std::uint8_t, 3>& value : pixels.values) value[1] = value[2] = value[0];
  return pixels;
}

}  // namespace alidade::image
