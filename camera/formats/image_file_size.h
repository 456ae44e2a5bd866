// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/input_file.h"

namespace alidade {

struct ImageFileSize {
  std::uint64_t width = 0, height = 0;
};

/// Size in pixels of a PNG or JPEG file as it is stored: an EXIF orientation is not applied. A name without
/// an extension also finds the file with .png, .jpg or .jpeg behind. Errors: no such file, another format,
/// damage. Cost: some bytes at the beginning are read; of a JPEG, one small read for each of its segments.
ImageFileSize image_file_size(const std::filesystem::path& file);

/// The same from an open file.
ImageFileSize image_file_size(InputFile& file);

}  // namespace alidade
