// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>

namespace alidade {

struct ImageFileSize {
  std::uint64_t width = 0, height = 0;
};

/// Size in pixels of an image file of any kind OpenImageIO knows, as it is stored (an EXIF orientation is not
/// applied). A name without an extension also finds the file with .png, .jpg or .jpeg behind. Errors: no such
/// file, unreadable. Cost: that of reading the file's header.
ImageFileSize image_file_size(const std::filesystem::path& file);

}  // namespace alidade
