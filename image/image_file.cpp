// SPDX-License-Identifier: MIT
// Without fmt: OpenImageIO's headers would put fmt's own functions into this file, and programs that link the
// library and use fmt would get OpenImageIO along with them.

#include "image/image_file.h"

#include <Imath/half.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "base/output_file.h"
#include "geo/raster_file.h"
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
void write_rows(const std::string& format, const std::filesystem::path& final_name, OutputFile& file,
                const OIIO::ImageSpec& spec, const PackRow& pack) {
  OIIO::Filesystem::IOVecOutput encoded;
  // A whole number of OpenEXR's 16-row compression blocks; the copy of the image stays small.
  constexpr int k_rows_at_once = 64;
  const auto image = OIIO::ImageOutput::create(format);
  if (!image) fail_image(final_name, OIIO::geterror());
  if (!image->set_ioproxy(&encoded)) fail_image(final_name, format + " encoding failed");
  if (!image->open(final_name.string(), spec)) fail_image(final_name, image->geterror());
  const std::size_t row_bytes = spec.scanline_bytes(true);
  std::vector<std::byte> bytes(row_bytes * static_cast<std::size_t>(std::min(k_rows_at_once, spec.height)));
  for (int begin = 0; begin < spec.height; begin += k_rows_at_once) {
    const int end = std::min(begin + k_rows_at_once, spec.height);
    for (int y = begin; y < end; ++y)
      pack(y, std::span(bytes).subspan(static_cast<std::size_t>(y - begin) * row_bytes, row_bytes));
    if (!image->write_scanlines(begin, end, 0, OIIO::TypeUnknown, bytes.data()))
      fail_image(final_name, image->geterror());
  }
  if (!image->close()) fail_image(final_name, image->geterror());
  file.write(std::as_bytes(std::span(encoded.buffer())));
}

/// How a channel's values are stored.
enum class ChannelType { half_float, single_float, unsigned_integer };

/// A channel of an EXR file, under the name that other programs expect.
struct Channel {
  std::string name;
  ChannelType type;
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
  const ChannelType color = output.half ? ChannelType::half_float : ChannelType::single_float;
  struct Group {
    Layer layer;
    ChannelType type;
    std::vector<std::string> names;
  };
  const Group groups[] = {
      {Layer::color, color, {"R", "G", "B", "A"}},
      {Layer::depth, ChannelType::single_float, {"Z"}},
      {Layer::distance, ChannelType::single_float, {"distance.T"}},
      {Layer::normal, color, {"N.X", "N.Y", "N.Z"}},
      {Layer::position, ChannelType::single_float, {"P.X", "P.Y", "P.Z"}},
      {Layer::albedo, color, {"albedo.R", "albedo.G", "albedo.B"}},
      {Layer::id, ChannelType::unsigned_integer, {"id"}},
      {Layer::variance, ChannelType::single_float, {"variance.R", "variance.G", "variance.B"}},
      {Layer::depth_sigma, ChannelType::single_float, {"depth.sigma"}},
      {Layer::coverage, ChannelType::single_float, {"coverage"}},
      {Layer::support, ChannelType::unsigned_integer, {"support"}}};
  std::vector<Channel> channels;
  for (const Group& group : groups) {
    if (std::ranges::find(output.layers, group.layer) == output.layers.end()) continue;
    for (int i = 0; const std::string& name : group.names)
      channels.push_back({name, group.type, group.layer, i++});
  }
  return channels;
}

/// Size of a pixel of these channels in bytes, each value in its own type, without gaps.
[[maybe_unused]] std::size_t pixel_bytes(std::span<const Channel> channels) {
  std::size_t bytes = 0;
  for (const Channel& channel : channels) bytes += channel.type == ChannelType::half_float ? 2 : 4;
  return bytes;
}

/// Row `y` of the film as pixels of these channels. `offset`: ImageFacts::position_offset. `bytes`: width *
/// pixel_bytes() of them.
void pack_row(const Film& film, int y, std::span<const Channel> channels, const glm::dvec3& offset,
              std::span<std::byte> bytes) {
  assert(bytes.size() == pixel_bytes(channels) * static_cast<std::size_t>(film.width));
  std::size_t byte = 0;
  for (int x = 0; x < film.width; ++x) {
    const std::size_t pixel = film.index(x, y);
    for (const Channel& channel : channels) {
      if (channel.type == ChannelType::unsigned_integer) {
        byte = put(bytes, byte, (channel.layer == Layer::id ? film.id : film.support)[pixel]);
        continue;
      }
      const float value = value_of(film, pixel, channel, offset);
      if (channel.type == ChannelType::single_float) {
        byte = put(bytes, byte, value);
      } else {
        // Brighter than the largest half (a view into the sun): the largest, since infinity spoils every
        // later filter.
        byte = put(bytes, byte, Imath::half(std::clamp(value, -k_largest_half, k_largest_half)));
      }
    }
  }
}

constexpr int k_longest_jpeg_side = 65500;

void write_exr(const Film& film, const OutputSettings& output, const ImageFacts& facts, OutputFile& file) {
  const std::vector<Channel> channels = exr_channels(output);
  if (channels.empty()) fail_image(output.file, "no layers requested");
  for (const NamedLayer& known : k_layers) {
    if (std::ranges::find(output.layers, known.layer) != output.layers.end() && !film.holds(known.layer))
      fail_image(output.file, "the layer " + std::string(known.name) + " was not rendered");
  }
  OIIO::ImageSpec spec(film.width, film.height, static_cast<int>(channels.size()), OIIO::TypeFloat);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Channel& channel = channels[i];
    spec.channelnames[i] = channel.name;
    spec.channelformats.push_back(channel.type == ChannelType::half_float     ? OIIO::TypeHalf
                                  : channel.type == ChannelType::single_float ? OIIO::TypeFloat
                                                                              : OIIO::TypeUInt);
    if (channel.name == "A") spec.alpha_channel = static_cast<int>(i);
    if (channel.name == "Z") spec.z_channel = static_cast<int>(i);
  }
  spec.attribute("compression", "zip");
  // Without it OpenImageIO writes the time, and equal films would give different bytes.
  spec.attribute("DateTime", "");
  for (const auto& [key, text] : facts.texts) spec.attribute(key, text);
  write_rows("openexr", output.file, file, spec, [&](int y, std::span<std::byte> bytes) {
    pack_row(film, y, channels, facts.position_offset, bytes);
  });
}

std::uint8_t alpha_code(const Film& film, std::size_t pixel) {
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(film.alpha[pixel], 0.0f, 1.0f)));
}

void write_display(const Film& film, const OutputSettings& output, const ImageFacts& facts,
                   ImageFormat format, OutputFile& file) {
  const bool has_alpha = output.transparent && format == ImageFormat::png;
  OIIO::ImageSpec spec(film.width, film.height, has_alpha ? 4 : 3, OIIO::TypeUInt8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  if (has_alpha) spec.attribute("oiio:UnassociatedAlpha", 1);
  if (format == ImageFormat::jpeg) {
    // Checked here because libjpeg would print it on stderr.
    if (std::max(film.width, film.height) > k_longest_jpeg_side)
      fail_image(output.file, "JPEG is limited to 65500 pixels");
    spec.attribute("Compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");
  }
  for (const auto& [key, text] : facts.texts) spec.attribute(key, text);
  write_rows(format == ImageFormat::png ? "png" : "jpeg", output.file, file, spec,
             [&](int y, std::span<std::byte> bytes) {
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
  return std::string("OpenImageIO ") + OIIO_VERSION_STRING;
}

void write_png(const Canvas& canvas, const std::filesystem::path& file, bool overwrite) {
  if (image_format(file) != ImageFormat::png)
    throw file_error(file, "unknown output format", "the extension .png");
  OutputFile output(file, overwrite);
  OIIO::ImageSpec spec(canvas.width(), canvas.height(), 3, OIIO::TypeUInt8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  write_rows("png", file, output, spec, [&](int y, std::span<std::byte> row) {
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
  OIIO::ImageSpec spec(width, height, static_cast<int>(channels), whole ? OIIO::TypeUInt16 : OIIO::TypeFloat);
  // Without it OpenImageIO writes the time, and equal maps would give different bytes.
  spec.attribute("DateTime", "");
  if (format != DepthFormat::png16) spec.attribute("compression", "zip");
  if (format == DepthFormat::exr) {
    spec.channelnames = {"Y", "Z"};
    spec.z_channel = 1;
  }
  for (const auto& [key, text] : texts) spec.attribute(key, text);
  const char* const writer = whole ? "png" : format == DepthFormat::exr ? "openexr" : "tiff";
  write_rows(writer, file, output, spec, [&](int y, std::span<std::byte> row) {
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
  write_rows("png", file, output, OIIO::ImageSpec(width, height, 1, OIIO::TypeUInt8),
             [&](int y, std::span<std::byte> row) {
               const std::size_t begin = static_cast<std::size_t>(y) * row.size();
               for (std::size_t x = 0; x < row.size(); ++x)
                 row[x] = std::isfinite(depths[begin + x]) ? std::byte{255} : std::byte{0};
             });
  output.commit();
}

}  // namespace alidade::image
