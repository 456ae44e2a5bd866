// SPDX-License-Identifier: MIT
// Without fmt, for the reason that renderer/read_sky_image.cpp gives.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <optional>

#include "compare/compared_image.h"
#include "compare/orientation.h"
#include "renderer/image_trouble.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_most_pixels_per_byte = 4096;
constexpr std::uint64_t k_most_values_at_once = std::uint64_t{1} << 23;
constexpr int k_longest_text = 4096;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& problem,
                       const std::string& expected = {}, const std::string& found = {}) {
  throw Error({.file = file.string(), .problem = problem, .expected = expected, .found = found});
}

/// Where the layers stand among the channels of a file; -1: not there.
struct Places {
  std::array<int, 3> color{-1, -1, -1};
  std::array<int, 3> normal{-1, -1, -1};
  int alpha = -1, depth = -1, id = -1;
  int color_channels = 0;

  std::array<int, 9> all() const {
    return {color[0], color[1], color[2], normal[0], normal[1], normal[2], alpha, depth, id};
  }
};

std::array<int, 3> three(const OIIO::ImageSpec& spec, const std::array<const char*, 3>& names) {
  std::array<int, 3> places{};
  for (std::size_t i = 0; i < 3; ++i) places[i] = spec.channelindex(names[i]);
  if (std::ranges::find(places, -1) != places.end()) return {-1, -1, -1};
  return places;
}

Places places_of(const OIIO::ImageSpec& spec, bool has_named_channels) {
  Places places;
  places.alpha = spec.channelindex("A");
  places.depth = spec.channelindex("Z");
  places.id = spec.channelindex("id");
  places.normal = three(spec, {"N.X", "N.Y", "N.Z"});
  if (places.normal[0] < 0) places.normal = three(spec, {"Nx", "Ny", "Nz"});
  places.color = three(spec, {"R", "G", "B"});
  // Formats without names of their own call their channels as they like.
  if (places.color[0] < 0 && !has_named_channels && spec.nchannels >= 3) places.color = {0, 1, 2};
  places.color_channels = places.color[0] < 0 ? 0 : 3;
  if (places.color_channels == 0) {
    const int grey = spec.channelindex("Y") >= 0 || has_named_channels ? spec.channelindex("Y") : 0;
    if (grey >= 0) {
      places.color = {grey, grey, grey};
      places.color_channels = 1;
    }
  }
  return places;
}

void check(const OIIO::ImageSpec& spec, std::uint64_t file_size, const std::filesystem::path& file) {
  if (spec.deep || spec.depth > 1)
    fail(file, "not a flat picture", "one with a single value per channel and pixel");
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) fail(file, "a picture without pixels");
  const std::string found = std::to_string(spec.width) + " x " + std::to_string(spec.height);
  const auto count = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
  if (count > k_most_compared_pixels)
    fail(file, "too large to be compared", "at most " + std::to_string(k_most_compared_pixels) + " pixels",
         found);
  if (count / k_most_pixels_per_byte > file_size)
    fail(file, "a picture that cannot hold its pixels",
         "more than " + std::to_string(file_size) + " bytes for them", found);
}

std::vector<std::pair<std::string, std::string>> texts_of(const OIIO::ImageSpec& spec) {
  std::vector<std::pair<std::string, std::string>> texts;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    // Profiles and thumbnails are bytes, not something to read.
    if (attribute.datasize() > k_longest_text || attribute.type().basetype == OIIO::TypeDesc::PTR) continue;
    texts.emplace_back(attribute.name().string(), attribute.get_string());
  }
  return texts;
}

/// Reads bands of rows, each with all channels that are wanted, and hands their values to their layers.
class BandReader {
 public:
  BandReader(OIIO::ImageInput& input, const Places& places) : input_(input), spec_(input.spec()) {
    begin_ = spec_.nchannels;
    for (const int channel : places.all()) {
      if (channel < 0) continue;
      begin_ = std::min(begin_, channel);
      end_ = std::max(end_, channel + 1);
    }
    const auto row_values =
        static_cast<std::uint64_t>(spec_.width) * static_cast<std::uint64_t>(end_ - begin_);
    const int most_rows = static_cast<int>(std::max<std::uint64_t>(1, k_most_values_at_once / row_values));
    // Bands end where blocks of tiles or of compressed rows do.
    const int block = spec_.tile_width > 0 ? spec_.tile_height : 64;
    rows_ = std::min(spec_.height, std::max(block, most_rows / block * block));
  }

  void read(ComparedImage& image, const Places& places) {
    std::vector<float> values(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(spec_.width) *
                              static_cast<std::size_t>(end_ - begin_));
    for (int top = 0; top < spec_.height; top += rows_) {
      const int bottom = std::min(top + rows_, spec_.height);
      if (begin_ < end_) read_band(top, bottom, begin_, end_, OIIO::TypeFloat, values.data());
      const std::size_t first = static_cast<std::size_t>(top) * static_cast<std::size_t>(spec_.width);
      const std::size_t count =
          static_cast<std::size_t>(bottom - top) * static_cast<std::size_t>(spec_.width);
      const auto hand_over = [&](std::vector<float>& layer, std::size_t components, std::size_t component,
                                 int channel) {
        if (channel < 0) return;
        const auto stride = static_cast<std::size_t>(end_ - begin_);
        const float* from = values.data() + (channel - begin_);
        float* to = layer.data() + first * components + component;
        for (std::size_t i = 0; i < count; ++i) to[i * components] = from[i * stride];
      };
      for (std::size_t i = 0; i < 3; ++i) hand_over(image.color, 3, i, places.color[i]);
      for (std::size_t i = 0; i < 3; ++i) hand_over(image.normals, 3, i, places.normal[i]);
      hand_over(image.alpha, 1, 0, places.alpha);
      hand_over(image.depth, 1, 0, places.depth);
      // Ids beyond 2^24 would not survive as floats.
      if (places.id >= 0)
        read_band(top, bottom, places.id, places.id + 1, OIIO::TypeUInt, image.ids.data() + first);
    }
  }

 private:
  void read_band(int top, int bottom, int begin, int end, OIIO::TypeDesc type, void* values) {
    const bool is_read =
        spec_.tile_width > 0
            ? input_.read_tiles(0, 0, spec_.x, spec_.x + spec_.width, spec_.y + top, spec_.y + bottom, 0, 1,
                                begin, end, type, values)
            : input_.read_scanlines(0, 0, spec_.y + top, spec_.y + bottom, 0, begin, end, type, values);
    // Of TIFF files OpenImageIO tells what is missing, but says that all is well.
    if (!is_read || input_.has_error()) {
      throw Error({.problem = "a picture with pixels missing: " + image_trouble(input_.geterror())});
    }
  }

  OIIO::ImageInput& input_;
  OIIO::ImageSpec spec_;
  int begin_ = 0, end_ = 0, rows_ = 1;
};

int largest_code_of(OIIO::TypeDesc type) {
  if (type == OIIO::TypeUInt8) return 255;
  return type == OIIO::TypeUInt16 ? 65535 : 0;
}

}  // namespace

ComparedImage read_compared_image(const std::filesystem::path& file) {
  const std::uint64_t file_size = picture_file_size(file);
  // Colours of PNG and TIFF come as they are stored, not multiplied by alpha.
  OIIO::ImageSpec hints;
  hints.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(file.string(), &hints);
  if (!input) fail(file, "not a picture that can be read: " + image_trouble(OIIO::geterror()));
  const OIIO::ImageSpec spec = input->spec();
  check(spec, file_size, file);
  const Places places = places_of(spec, std::string_view(input->format_name()) == "openexr");
  if (std::ranges::all_of(places.all(), [](int channel) { return channel < 0; }))
    fail(file, "nothing to compare", "channels R G B, Y, A, Z, N.X N.Y N.Z or id");

  ComparedImage image;
  image.file = file;
  image.width = spec.width;
  image.height = spec.height;
  image.origin_x = spec.x - spec.full_x;
  image.origin_y = spec.y - spec.full_y;
  image.color_channels = places.color_channels;
  const OIIO::TypeDesc type = spec.channelformat(std::max(places.color[0], 0));
  image.encoding = type.is_floating_point() ? ColorEncoding::linear : ColorEncoding::display;
  image.largest_code = largest_code_of(type);
  if (places.color[0] >= 0) image.color.resize(3 * image.pixels());
  if (places.normal[0] >= 0) image.normals.resize(3 * image.pixels());
  if (places.alpha >= 0) image.alpha.resize(image.pixels());
  if (places.depth >= 0) image.depth.resize(image.pixels());
  if (places.id >= 0) image.ids.resize(image.pixels());
  image.metadata = texts_of(spec);
  try {
    BandReader(*input, places).read(image, places);
  } catch (const Error& error) {
    fail(file, error.what());
  }
  turn_upright(image, spec.get_int_attribute("Orientation", 1));
  return image;
}

}  // namespace alidade
