// SPDX-License-Identifier: MIT
#include "renderer/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cassert>
#include <span>

#include "octree/cloud/output_file.h"
#include "octree/error.h"
#include "renderer/image_display.h"
#include "renderer/image_exr.h"
#include "renderer/image_geotiff.h"
#include "renderer/image_metadata.h"

namespace alidade {
namespace {

// Rows handed over at once: a whole number of OpenEXR's 16-row compression blocks; the copy of the image
// stays small.
constexpr int k_rows_at_once = 64;

constexpr int k_longest_jpeg_side = 65500;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& message) {
  throw Error({.file = file.string(), .problem = "image cannot be written: " + message});
}

// Encodes the rows that `pack(y, bytes of row y)` fills in memory and then writes them: libpng and libjpeg,
// as OpenImageIO calls them, overlook a full disk or end the program.
template <typename PackRow>
void write_rows(const std::string& format, const std::filesystem::path& final_name, OutputFile& file,
                const OIIO::ImageSpec& spec, const PackRow& pack) {
  OIIO::Filesystem::IOVecOutput encoded;
  const auto image = OIIO::ImageOutput::create(format);
  if (!image) fail(final_name, OIIO::geterror());
  if (!image->set_ioproxy(&encoded)) fail(final_name, format + " cannot be encoded in memory");
  if (!image->open(final_name.string(), spec)) fail(final_name, image->geterror());
  const std::size_t row_bytes = spec.scanline_bytes(true);
  std::vector<std::byte> bytes(row_bytes * static_cast<std::size_t>(std::min(k_rows_at_once, spec.height)));
  for (int begin = 0; begin < spec.height; begin += k_rows_at_once) {
    const int end = std::min(begin + k_rows_at_once, spec.height);
    for (int y = begin; y < end; ++y) {
      pack(y, std::span(bytes).subspan(static_cast<std::size_t>(y - begin) * row_bytes, row_bytes));
    }
    if (!image->write_scanlines(begin, end, 0, OIIO::TypeUnknown, bytes.data()))
      fail(final_name, image->geterror());
  }
  if (!image->close()) fail(final_name, image->geterror());
  file.write(std::as_bytes(std::span(encoded.buffer())));
}

void write_exr(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
               OutputFile& file) {
  const std::vector<Channel> channels = exr_channels(output);
  if (channels.empty()) fail(output.file, "no layer is asked for");
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
  // Left out, OpenImageIO writes the time: the same film would not give the same bytes.
  spec.attribute("DateTime", "");
  for (const auto& [key, text] : metadata_texts(metadata)) spec.attribute(key, text);
  const glm::dvec3 offset = position_offset(metadata.camera);
  write_rows("openexr", output.file, file, spec,
             [&](int y, std::span<std::byte> bytes) { pack_row(film, y, channels, offset, bytes); });
}

void write_display(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
                   ImageFormat format, OutputFile& file) {
  OIIO::ImageSpec spec(film.width, film.height, 3, OIIO::TypeUInt8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  if (format == ImageFormat::jpeg) {
    // Checked here because libjpeg says it on stderr.
    if (std::max(film.width, film.height) > k_longest_jpeg_side)
      fail(output.file, "JPEG ends at 65500 pixels");
    spec.attribute("Compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");
  }
  for (const auto& [key, text] : metadata_texts(metadata)) spec.attribute(key, text);
  const double scale = exposure_scale(output.exposure);
  write_rows(format == ImageFormat::png ? "png" : "jpeg", output.file, file, spec,
             [&](int y, std::span<std::byte> bytes) {
               std::size_t place = 0;
               for (int x = 0; x < film.width; ++x) {
                 const Rgb& color = film.color[film.index(x, y)];
                 for (int i = 0; i < 3; ++i) bytes[place++] = std::byte{srgb_code(color[i] * scale)};
               }
             });
}

}  // namespace

void write_image(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
                 bool overwrite) {
  check_image_name(output.file);
  const ImageFormat format = *image_format(output.file);
  assert(film.width > 0 && film.height > 0);
  OutputFile file(output.file, overwrite);
  if (format == ImageFormat::exr)
    write_exr(film, output, metadata, file);
  else if (format == ImageFormat::geotiff)
    write_geotiff(film, output, metadata, file);
  else
    write_display(film, output, metadata, format, file);
  file.commit();
}

}  // namespace alidade
