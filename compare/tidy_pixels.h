// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

// Which pixels are set (1) and which are not (0), in a picture with rows of `width`.

namespace alidade {

/// Leaves those set pixels of which at least a share of the 5 x 5 pixels around it, as far as they lie in the
/// picture, is set: what is not scattered. The corner of a square has 9 of 25. Cost: 25 looks per set pixel.
std::vector<std::uint8_t> drop_specks(const std::vector<std::uint8_t>& set, int width, double least_density);

/// Closes gaps between set pixels: a dilation by the square of side 2 gap + 1, then an erosion by it. What is
/// set stays set; beyond the picture's edge everything counts as set to the erosion, so that nothing is lost
/// there. Requires gap >= 0. Cost: four passes, whatever the gap; memory: 1 byte per pixel beside the result.
std::vector<std::uint8_t> close_gaps(const std::vector<std::uint8_t>& set, int width, int gap);

}  // namespace alidade
