// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "image/canvas.h"

namespace alidade {

/// Writes a canvas as PNG. The file appears whole or not at all. Errors: a name that does not end in .png; an
/// existing file without `overwrite`; a full disk and other write failures.
void write_png(const Canvas& canvas, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade
