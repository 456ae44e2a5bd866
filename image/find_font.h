// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>

namespace alidade {

/// Where Linux distributions keep DejaVu Sans, the first of them Debian's place.
std::span<const std::filesystem::path> font_places();

/// The font of legends: the first of the places that is a file. Errors: none is; the message names the
/// package that brings one.
std::filesystem::path find_font(std::span<const std::filesystem::path> places = font_places());

}  // namespace alidade
