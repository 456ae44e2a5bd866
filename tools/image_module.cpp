// SPDX-License-Identifier: MIT
#include "tools/image_writer.h"

// The module that load_image_writer() and load_legend_writer() load.

extern "C" void alidade_write_image(const alidade::Film& film, const alidade::OutputSettings& output,
                                    const alidade::ImageMetadata& metadata, bool overwrite) {
  alidade::write_image(film, output, metadata, overwrite);
}

extern "C" void alidade_write_legend(const alidade::ColorKey& key, const std::filesystem::path& file,
                                     const std::optional<glm::ivec2>& size, bool overwrite) {
  alidade::write_legend(key, file, size, overwrite);
}
