// SPDX-License-Identifier: MIT
#include "image/canvas_png.h"

#include <algorithm>

#include "base/error.h"
#include "base/output_file.h"
#include "image/image_file.h"
#include "image/image_rows.h"

namespace alidade {

void write_png(const Canvas& canvas, const std::filesystem::path& file, bool overwrite) {
  if (image_format(file) != ImageFormat::png) {
    throw Error({.file = file.string(),
                 .problem = "this picture is written as PNG",
                 .expected = "a name ending in .png"});
  }
  OutputFile output(file, overwrite);
  OIIO::ImageSpec spec(canvas.width(), canvas.height(), 3, OIIO::TypeUInt8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  write_rows("png", file, output, spec, [&](int y, std::span<std::byte> row) {
    const auto pixels = std::as_bytes(std::span(canvas.bytes()));
    std::ranges::copy(pixels.subspan(static_cast<std::size_t>(y) * row.size(), row.size()), row.begin());
  });
  output.commit();
}

}  // namespace alidade
