// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string_view>

#include "renderer/scene.h"

namespace alidade::renderer {

/// Reads a scene file (docs/scene_format.md, scenes/schema/scene.schema.json). Relative paths in it are taken
/// relative to the file. A camera may be in the scene or in a file of its own that the scene names.
/// Errors: Error with file, line:column, JSON pointer, what was expected and found; unknown keys name the
/// nearest known one.
Scene read_scene(const std::filesystem::path& file);

/// read_scene() from text; `name` is used in messages and relative paths are taken relative to its folder.
Scene parse_scene(std::string_view text, const std::filesystem::path& name);

}  // namespace alidade::renderer
