// SPDX-License-Identifier: MIT
// Without fmt: OpenImageIO's headers would put fmt's own functions into this file, and programs that link the
// library and use fmt would get OpenImageIO along with them.

#include "image/read_image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <system_error>

#include "base/error.h"

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

void check(const OIIO::ImageSpec& spec, std::uint64_t file_size, const ImageLimits& limits,
           const std::filesystem::path& file) {
  if (spec.deep || spec.depth > 1)
    throw file_error(file, "not a flat image", "one value per channel and pixel");
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1)
    throw file_error(file, "the image has no pixels");
  const std::string found = size_text({spec.width, spec.height});
  const auto count = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
  if (count > limits.pixels)
    throw file_error(file, "too large for a " + limits.content, limits.pixels_text, found);
  if (count / k_most_pixels_per_byte > file_size) {
    throw file_error(file, "the file is too short for its pixels",
                     "more than " + std::to_string(file_size) + " bytes", found);
  }
  const bool is_whole = spec.x == spec.full_x && spec.y == spec.full_y && spec.width == spec.full_width &&
                        spec.height == spec.full_height;
  if (!is_whole) {
    throw file_error(file, "the image is a crop",
                     "all " + size_text({spec.full_width, spec.full_height}) + " pixels", found);
  }
}

/// An image that is being read. Its bytes in memory must outlive it.
struct OpenImage {
  std::unique_ptr<OIIO::Filesystem::IOProxy> memory;  ///< what `input` reads from; null: the file
  std::unique_ptr<OIIO::ImageInput> input;

  const OIIO::ImageSpec& spec() const { return input->spec(); }
};

/// An open image that was checked.
OpenImage open_image(const std::filesystem::path& file, const ImageBytes& bytes, const ImageLimits& limits) {
  const std::uint64_t byte_count = bytes ? bytes->size() : image_file_size(file);
  // Alpha is not examined, so it must not be multiplied in either.
  OIIO::ImageSpec hints;
  hints.attribute("oiio:UnassociatedAlpha", 1);
  OpenImage image;
  if (bytes) {
    image.memory = std::make_unique<OIIO::Filesystem::IOMemReader>(bytes->data(), bytes->size());
    void* const proxy = image.memory.get();
    hints.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  }
  image.input = OIIO::ImageInput::open(file.string(), &hints);
  if (!image.input) throw file_error(file, "cannot read the image: " + image_trouble(OIIO::geterror()));
  check(image.spec(), byte_count, limits, file);
  return image;
}

/// The channels to read.
struct Channels {
  int begin = 0, count = 1;
};

Channels color_channels(const OIIO::ImageSpec& spec) {
  if (spec.nchannels < 3) return {0, 1};
  const std::vector<std::string>& names = spec.channelnames;
  for (int i = 0; i + 2 < static_cast<int>(names.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (names[at] == "R" && names[at + 1] == "G" && names[at + 2] == "B") return {i, 3};
  }
  return {0, 3};
}

/// Reads the channels of all pixels, which are `stride` bytes apart.
void read_channels(OIIO::ImageInput& input, const Channels& channels, OIIO::TypeDesc type, void* values,
                   std::size_t stride, const std::filesystem::path& file) {
  const bool is_read = input.read_image(0, 0, channels.begin, channels.begin + channels.count, type, values,
                                        static_cast<OIIO::stride_t>(stride));
  // For TIFF files OpenImageIO returns success even where it reports that pixels are missing.
  if (!is_read || input.has_error())
    throw file_error(file, "the image has missing pixels: " + image_trouble(input.geterror()));
}

/// Linear values of the display values 0, 1/65535, ... 1.
std::vector<float> linear_values() {
  std::vector<float> values(65536);
  for (std::size_t code = 0; code < values.size(); ++code)
    values[code] = static_cast<float>(linear_from_srgb(static_cast<double>(code) / 65535.0));
  return values;
}

OpenImage open_photo(const std::filesystem::path& file, const ImageBytes& bytes) {
  constexpr std::uint64_t k_most_pixels = 1u << 28;
  OpenImage image = open_image(
      file, bytes, {"photo", k_most_pixels, "at most " + std::to_string(k_most_pixels) + " pixels"});
  if (image.spec().format.is_floating_point()) {
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
  const OpenImage image =
      open_image(file, {},
                 {"sky", k_most_sky_pixels,
                  "at most " + std::to_string(k_most_sky_pixels) + " pixels, as in 16384 x 8192"});
  const OIIO::ImageSpec spec = image.spec();

  SkyPixels pixels{.width = spec.width, .height = spec.height};
  pixels.values.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
  const Channels channels = color_channels(spec);
  read_channels(*image.input, channels, OIIO::TypeFloat, pixels.values.data(), sizeof(Rgb), file);
  if (channels.count == 1)
    for (Rgb& value : pixels.values) value = Rgb(value.r);

  if (!spec.channelformat(channels.begin).is_floating_point()) {
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
        file.string() + ": " + std::to_string(channels.count == 1 ? replaced / 3 : replaced) +
        " invalid radiances (negative, not finite or above 1e9): using 0 for negative values and NaN, "
        "65504 for infinity";
  }
  return pixels;
}

std::string size_text(const ImageSize& size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

ImageSize photo_size(const std::filesystem::path& file, const ImageBytes& bytes) {
  const OpenImage image = open_photo(file, bytes);
  return {image.spec().width, image.spec().height};
}

PhotoPixels read_photo(const std::filesystem::path& file, const ImageBytes& bytes) {
  const OpenImage image = open_photo(file, bytes);
  const OIIO::ImageSpec spec = image.spec();
  PhotoPixels pixels{.size = {spec.width, spec.height}};
  pixels.values.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
  const Channels channels = color_channels(spec);
  read_channels(*image.input, channels, OIIO::TypeUInt8, pixels.values.data(), sizeof(pixels.values[0]),
                file);
  if (channels.count == 1)
    for (std::array<std::uint8_t, 3>& value : pixels.values) value[1] = value[2] = value[0];
  return pixels;
}

}  // namespace alidade::image
