// SPDX-License-Identifier: MIT
#include "image/image_file.h"

#include <Imath/half.h>
#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <iterator>

#include "base/error.h"
#include "base/output_file.h"
#include "geo/raster_file.h"
#include "image/backend.h"
#include "image/canvas.h"
#include "image/srgb.h"

namespace alidade::image {
namespace {

[[noreturn]] void fail_image(const std::filesystem::path& file, const std::string& message) {
  throw file_error(file, "cannot write the image: " + message);
}

/// Encodes the rows that `pack(y, bytes of row y)` fills in memory and then writes them: libpng and libjpeg,
/// as OpenImageIO calls them, overlook a full disk or end the program. Errors name `final_name`.
template <typename PackRow>
void write_rows(const ImageToWrite& image, const std::filesystem::path& final_name, OutputFile& file,
                const PackRow& pack) {
  const std::size_t row_bytes = static_cast<std::size_t>(image.width) * image.pixel_bytes();
  std::vector<std::byte> bytes;
  const auto rows = [&](int begin, int end) {
    bytes.resize(row_bytes * static_cast<std::size_t>(end - begin));
    for (int y = begin; y < end; ++y)
      pack(y, std::span(bytes).subspan(static_cast<std::size_t>(y - begin) * row_bytes, row_bytes));
    return bytes.data();
  };
  std::vector<unsigned char> encoded;
  const Failure failure = backend().encode(image, final_name.string(), rows, encoded);
  if (failure) fail_image(final_name, *failure);
  file.write(std::as_bytes(std::span(encoded)));
}

/// A channel of an EXR file, under the name that other programs expect.
struct Channel {
  std::string name;
  ValueType type;
  Layer layer;
  int component;  ///< 0, 1, 2 of a vector or colour; 3 = alpha
};

constexpr float k_largest_half = 65504.0f;

float value_of(const Film& film, std::size_t pixel, const Channel& channel, const glm::dvec3& offset) {
  const int i = channel.component;
  switch (channel.layer) {
    case Layer::color:
      return i == 3 ? film.alpha[pixel] : film.color[pixel][i];
    case Layer::depth:
      return film.depth[pixel];
    case Layer::distance:
      return film.distance[pixel];
    case Layer::normal:
      return film.normal[pixel][i];
    // A pixel without a surface stays 0 0 0; infinite depth distinguishes it from a real position.
    case Layer::position:
      return film.position[pixel] == glm::dvec3(0.0)
                 ? 0.0f
                 : static_cast<float>(film.position[pixel][i] - offset[i]);
    case Layer::albedo:
      return film.albedo[pixel][i];
    case Layer::variance:
      return film.variance[pixel][i];
    case Layer::depth_sigma:
      return film.depth_sigma[pixel];
    case Layer::coverage:
      return film.coverage[pixel];
    case Layer::id:
    case Layer::support:
      break;
  }
  return 0.0f;
}

template <typename Value>
std::size_t put(std::span<std::byte> bytes, std::size_t offset, const Value& value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
  return offset + sizeof value;
}

/// The channels of the requested layers, in the order of the enumeration Layer.
std::vector<Channel> exr_channels(const OutputSettings& output) {
  const ValueType color = output.half ? ValueType::half : ValueType::single;
  struct Group {
    Layer layer;
    ValueType type;
    std::vector<std::string> names;
  };
  const Group groups[] = {{Layer::color, color, {"R", "G", "B", "A"}},
                          {Layer::depth, ValueType::single, {"Z"}},
                          {Layer::distance, ValueType::single, {"distance.T"}},
                          {Layer::normal, color, {"N.X", "N.Y", "N.Z"}},
                          {Layer::position, ValueType::single, {"P.X", "P.Y", "P.Z"}},
                          {Layer::albedo, color, {"albedo.R", "albedo.G", "albedo.B"}},
                          {Layer::id, ValueType::uint32, {"id"}},
                          {Layer::variance, ValueType::single, {"variance.R", "variance.G", "variance.B"}},
                          {Layer::depth_sigma, ValueType::single, {"depth.sigma"}},
                          {Layer::coverage, ValueType::single, {"coverage"}},
                          {Layer::support, ValueType::uint32, {"support"}}};
  std::vector<Channel> channels;
  for (const Group& group : groups) {
    if (std::ranges::find(output.layers, group.layer) == output.layers.end()) continue;
    for (int i = 0; const std::string& name : group.names)
      channels.push_back({name, group.type, group.layer, i++});
  }
  return channels;
}

/// Row `y` of the film as pixels of these channels. `offset`: ImageFacts::position_offset. `bytes`: as many
/// as the row takes.
void pack_row(const Film& film, int y, std::span<const Channel> channels, const glm::dvec3& offset,
              std::span<std::byte> bytes) {
  std::size_t byte = 0;
  for (int x = 0; x < film.width; ++x) {
    const std::size_t pixel = film.index(x, y);
    for (const Channel& channel : channels) {
      if (channel.type == ValueType::uint32) {
        byte = put(bytes, byte, (channel.layer == Layer::id ? film.id : film.support)[pixel]);
        continue;
      }
      const float value = value_of(film, pixel, channel, offset);
      if (channel.type == ValueType::single) {
        byte = put(bytes, byte, value);
      } else {
        // Brighter than the largest half (a view into the sun): the largest, since infinity spoils every
        // later filter.
        byte = put(bytes, byte, Imath::half(std::clamp(value, -k_largest_half, k_largest_half)));
      }
    }
  }
  assert(byte == bytes.size());
}

constexpr int k_longest_jpeg_side = 65500;

void write_exr(const Film& film, const OutputSettings& output, const ImageFacts& facts, OutputFile& file) {
  const std::vector<Channel> channels = exr_channels(output);
  if (channels.empty()) fail_image(output.file, "no layers requested");
  for (const NamedLayer& known : k_layers) {
    if (std::ranges::find(output.layers, known.layer) != output.layers.end() && !film.holds(known.layer))
      fail_image(output.file, "the layer " + std::string(known.name) + " was not rendered");
  }
  // Without a time OpenImageIO writes that of the clock, and equal films would give different bytes.
  ImageToWrite image{{.width = film.width,
                      .height = film.height,
                      .channel_count = static_cast<int>(channels.size()),
                      .type = ValueType::single},
                     "openexr",
                     {{"compression", "zip"}, {"DateTime", ""}}};
  for (const Channel& channel : channels) {
    image.channel_names.push_back(channel.name);
    image.channel_types.push_back(channel.type);
  }
  std::ranges::copy(facts.texts, std::back_inserter(image.attributes));
  write_rows(image, output.file, file, [&](int y, std::span<std::byte> bytes) {
    pack_row(film, y, channels, facts.position_offset, bytes);
  });
}

std::uint8_t alpha_code(const Film& film, std::size_t pixel) {
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(film.alpha[pixel], 0.0f, 1.0f)));
}

void write_display(const Film& film, const OutputSettings& output, const ImageFacts& facts,
                   ImageFormat format, OutputFile& file) {
  const bool has_alpha = output.transparent && format == ImageFormat::png;
  ImageToWrite image{{film.width, film.height, has_alpha ? 4 : 3, ValueType::uint8},
                     format == ImageFormat::png ? "png" : "jpeg",
                     {{"oiio:ColorSpace", "sRGB"}}};
  if (has_alpha) image.attributes.emplace_back("oiio:UnassociatedAlpha", 1);
  if (format == ImageFormat::jpeg) {
    // Checked here because libjpeg would print it on stderr.
    if (std::max(film.width, film.height) > k_longest_jpeg_side)
      fail_image(output.file, "JPEG is limited to 65500 pixels");
    image.attributes.emplace_back("Compression", "jpeg:95");
    image.attributes.emplace_back("jpeg:subsampling", "4:4:4");
  }
  std::ranges::copy(facts.texts, std::back_inserter(image.attributes));
  write_rows(image, output.file, file, [&](int y, std::span<std::byte> bytes) {
    auto byte = bytes.begin();
    for (int x = 0; x < film.width; ++x) {
      const std::size_t pixel = film.index(x, y);
      for (const std::uint8_t code : displayed(film, pixel, output)) *byte++ = std::byte{code};
      if (has_alpha) *byte++ = std::byte{alpha_code(film, pixel)};
    }
  });
}

/// Writes the film as GeoTIFF.
void write_on_ground(const Film& film, const OutputSettings& output, const ImageFacts& facts,
                     OutputFile& file) {
  assert(facts.ground);
  const auto fill = [&](int first_row, int rows, std::span<std::uint8_t> rgba) {
    auto value = rgba.begin();
    for (int y = first_row; y < first_row + rows; ++y) {
      for (int x = 0; x < film.width; ++x) {
        const std::size_t pixel = film.index(x, y);
        value = std::ranges::copy(displayed(film, pixel, output), value).out;
        *value++ = alpha_code(film, pixel);
      }
    }
  };
  geo::write_geotiff(output.file, {film.width, film.height, *facts.ground, facts.crs, facts.texts}, fill,
                     file);
}

}  // namespace

void write_image(const Film& film, const OutputSettings& output, const ImageFacts& facts, bool overwrite) {
  check_image_name(output.file);
  const ImageFormat format = *image_format(output.file);
  assert(film.width > 0 && film.height > 0);
  OutputFile file(output.file, overwrite);
  if (format == ImageFormat::exr)
    write_exr(film, output, facts, file);
  else if (format == ImageFormat::geotiff)
    write_on_ground(film, output, facts, file);
  else
    write_display(film, output, facts, format, file);
  file.commit();
}

std::string library_version() {
  return "OpenImageIO " ALIDADE_OPENIMAGEIO_VERSION;
}

void load_library() {
  backend();
}

void write_png(const Canvas& canvas, const std::filesystem::path& file, bool overwrite) {
  if (image_format(file) != ImageFormat::png)
    throw file_error(file, "unknown output format", "the extension .png");
  OutputFile output(file, overwrite);
  const ImageToWrite image{
      {canvas.width(), canvas.height(), 3, ValueType::uint8}, "png", {{"oiio:ColorSpace", "sRGB"}}};
  write_rows(image, file, output, [&](int y, std::span<std::byte> row) {
    const auto pixels = std::as_bytes(std::span(canvas.bytes()));
    std::ranges::copy(pixels.subspan(static_cast<std::size_t>(y) * row.size(), row.size()), row.begin());
  });
  output.commit();
}

void write_depth_map(std::span<const float> values, int width, int height, DepthFormat format,
                     const std::vector<std::pair<std::string, std::string>>& texts,
                     const std::filesystem::path& file, bool overwrite) {
  assert(values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  static_assert(std::endian::native == std::endian::little);
  OutputFile output(file, overwrite);
  if (format == DepthFormat::npy || format == DepthFormat::colmap) {
    output.write(depth_map_head(format, width, height));
    output.write(std::as_bytes(values));
    output.commit();
    return;
  }
  const bool whole = format == DepthFormat::png16;
  // OpenCV reads zeros from a file with a channel Z alone; it reads the depth from Y.
  const std::size_t channels = format == DepthFormat::exr ? 2 : 1;
  // Without a time OpenImageIO writes that of the clock, and equal maps would give different bytes.
  const char* const writer = whole ? "png" : format == DepthFormat::exr ? "openexr" : "tiff";
  ImageToWrite image{
      {width, height, static_cast<int>(channels), whole ? ValueType::uint16 : ValueType::single},
      writer,
      {{"DateTime", ""}}};
  if (format != DepthFormat::png16) image.attributes.emplace_back("compression", "zip");
  if (format == DepthFormat::exr) image.channel_names = {"Y", "Z"};
  std::ranges::copy(texts, std::back_inserter(image.attributes));
  write_rows(image, file, output, [&](int y, std::span<std::byte> row) {
    std::size_t byte = 0;
    const std::size_t columns = static_cast<std::size_t>(width);
    for (const float value : values.subspan(static_cast<std::size_t>(y) * columns, columns))
      for (std::size_t channel = 0; channel < channels; ++channel)
        byte = whole ? put(row, byte, static_cast<std::uint16_t>(value)) : put(row, byte, value);
  });
  output.commit();
}

void write_depth_mask(std::span<const float> depths, int width, int height, const std::filesystem::path& file,
                      bool overwrite) {
  OutputFile output(file, overwrite);
  const ImageToWrite image{{width, height, 1, ValueType::uint8}, "png"};
  write_rows(image, file, output, [&](int y, std::span<std::byte> row) {
    const std::size_t begin = static_cast<std::size_t>(y) * row.size();
    for (std::size_t x = 0; x < row.size(); ++x)
      row[x] = std::isfinite(depths[begin + x]) ? std::byte{255} : std::byte{0};
  });
  output.commit();
}

}  // namespace alidade::image
