// SPDX-License-Identifier: MIT
#include "renderer/camera/image_file_size.h"

#include <OpenImageIO/imageio.h>

#include <string>

#include "octree/error.h"

namespace alidade {
namespace {

std::filesystem::path with_extension(const std::filesystem::path& file) {
  std::error_code error;
  for (const char* const extension : {"", ".png", ".jpg", ".jpeg"}) {
    std::filesystem::path name = file;
    name += extension;
    if (std::filesystem::is_regular_file(name, error)) return name;
  }
  throw Error({.problem = "size of the image is not told and its file is missing",
               .expected = "width and height, or the file " + file.string()});
}

}  // namespace

ImageFileSize image_file_size(const std::filesystem::path& file) {
  const std::filesystem::path found = with_extension(file);
  const auto image = OIIO::ImageInput::open(found.string());
  if (!image) throw Error({.problem = "image " + found.string() + " cannot be read: " + OIIO::geterror()});
  const OIIO::ImageSpec& spec = image->spec();
  if (spec.width < 1 || spec.height < 1) throw Error({.problem = "image " + found.string() + " has no size"});
  return {static_cast<std::uint64_t>(spec.width), static_cast<std::uint64_t>(spec.height)};
}

}  // namespace alidade
