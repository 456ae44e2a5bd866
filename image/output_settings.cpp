// SPDX-License-Identifier: MIT
#include "image/output_settings.h"

#include "base/error.h"
#include "base/words.h"

namespace alidade::image {

std::optional<ImageFormat> image_format(const std::filesystem::path& file) {
  const std::string extension = file_extension(file);
  if (extension == ".exr") return ImageFormat::exr;
  if (extension == ".png") return ImageFormat::png;
  if (extension == ".jpg" || extension == ".jpeg") return ImageFormat::jpeg;
  if (extension == ".tif" || extension == ".tiff") return ImageFormat::geotiff;
  return std::nullopt;
}

void check_image_name(const std::filesystem::path& file) {
  if (image_format(file)) return;
  const std::string extension = file.extension().string();
  throw file_error(file, "unknown output format", "the extension .exr, .png, .jpg, .jpeg or .tif",
                   extension.empty() ? "no extension" : extension);
}

}  // namespace alidade::image
