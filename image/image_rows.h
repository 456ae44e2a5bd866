// SPDX-License-Identifier: MIT
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/output_file.h"

namespace alidade {

[[noreturn]] inline void fail_image(const std::filesystem::path& file, const std::string& message) {
  throw Error({.file = file.string(), .problem = "image cannot be written: " + message});
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
  if (!image->set_ioproxy(&encoded)) fail_image(final_name, format + " cannot be encoded in memory");
  if (!image->open(final_name.string(), spec)) fail_image(final_name, image->geterror());
  const std::size_t row_bytes = spec.scanline_bytes(true);
  std::vector<std::byte> bytes(row_bytes * static_cast<std::size_t>(std::min(k_rows_at_once, spec.height)));
  for (int begin = 0; begin < spec.height; begin += k_rows_at_once) {
    const int end = std::min(begin + k_rows_at_once, spec.height);
    for (int y = begin; y < end; ++y) {
      pack(y, std::span(bytes).subspan(static_cast<std::size_t>(y - begin) * row_bytes, row_bytes));
    }
    if (!image->write_scanlines(begin, end, 0, OIIO::TypeUnknown, bytes.data()))
      fail_image(final_name, image->geterror());
  }
  if (!image->close()) fail_image(final_name, image->geterror());
  file.write(std::as_bytes(std::span(encoded.buffer())));
}

}  // namespace alidade
