// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tools/render/views.h"

namespace alidade {

/// Names of the pictures of a set, in its order. `pattern` holds one %d, %04d (number, from 0, with leading
/// zeros up to that width) or %s (the camera's name without extension, with / and what file names cannot hold
/// as
/// _); %% is a percent sign. Errors: none or several of them though there is more than one view; two views
/// that would have the same name.
std::vector<std::filesystem::path> picture_names(const std::filesystem::path& pattern,
                                                 std::span<const View> views);

}  // namespace alidade
