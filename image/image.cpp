// SPDX-License-Identifier: MIT
#include "image/image_file.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cassert>
#include <span>

#include "base/error.h"
#include "base/output_file.h"
#include "geo/geotiff.h"
#include "image/image_display.h"
#include "image/image_exr.h"
#include "image/image_rows.h"
#include "renderer/picture_metadata.h"

namespace alidade {
namespace {

constexpr int k_longest_jpeg_side = 65500;

void write_exr(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
               OutputFile& file) {
  const std::vector<Channel> channels = exr_channels(output);
  if (channels.empty()) fail_image(output.file, "no layer is asked for");
  for (const NamedLayer& known : k_layers) {
    if (std::ranges::find(output.layers, known.layer) != output.layers.end() && !film.holds(known.layer))
      fail_image(output.file, "its layer " + std::string(known.name) + " was not rendered");
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
      fail_image(output.file, "JPEG ends at 65500 pixels");
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
