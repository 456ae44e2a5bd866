// SPDX-License-Identifier: MIT
#include "tools/image_writer.h"

// The module that load_image_writer() loads.

extern "C" void alidade_write_image(const alidade::Film& film, const alidade::OutputSettings& output,
                                    const alidade::ImageMetadata& metadata, bool overwrite) {
  alidade::write_image(film, output, metadata, overwrite);
}
