// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "tools/render/views.h"

namespace alidade::tools {

/// A transforms.json to be written again with its depth maps.
struct DepthTransforms {
  std::filesystem::path input, output;
  std::string text;  ///< of the input
};

/// Reads the input. Errors: it is not a transforms.json; the output would be in another folder, but names of
/// photographs are relative to the input's.
DepthTransforms read_depth_transforms(const std::filesystem::path& input,
                                      const std::filesystem::path& output);

/// Writes the output: every frame gets `depth_file_path`, relative to the output's folder; all other keys and
/// their values stay, in their order. `files[i]` is the depth map of `views[i]`; the views are all frames.
/// The file is written completely or not at all. Errors: it exists and `overwrite` is false; write failures.
void write_depth_transforms(const DepthTransforms& transforms, std::span<const View> views,
                            std::span<const std::filesystem::path> files, bool overwrite);

}  // namespace alidade::tools
