// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>

#include "compare/compared_image.h"

namespace alidade::compare {

/// Most pixels of an image that is read: 2^28, 16384 x 16384.
constexpr std::uint64_t k_most_compared_pixels = std::uint64_t{1} << 28;

/// Reads an image of any format that OpenImageIO reads: the channels R G B, or a single one as grey, A, Z,
/// N.X N.Y N.Z (also Nx Ny Nz), id, and beside these depth.sigma; others are ignored. EXIF orientation is
/// obeyed, CMYK turned into RGB, of several images in a file the first is taken. NaN and infinite values
/// stay: the metrics count them. Whole ids may be stored as floating point, as long as all of them are exact:
/// below 2^24 (half: 2^11). Memory for pixels is taken as they arrive, whatever size the file claims. Errors:
/// no such file, not an image, no pixels or more than k_most_compared_pixels, deep or 3D, pixels missing,
/// ids that are not whole or not exact, none of the channels above.
ComparedImage read_compared_image(const std::filesystem::path& file);

/// Number of pixels that the file claims to have; 0 if it is no image.
std::uint64_t claimed_pixels(const std::filesystem::path& file);

/// The image at another size: colour and alpha through OpenImageIO's resize (its default filter: Lanczos 3
/// when shrinking, Blackman-Harris when growing), display colours clamped to 0 .. 1, linear ones to no less
/// than 0 or the least that the image has; NaN and infinity spread over the pixels that the filter reaches.
/// Depth, its sigma, normals and ids are taken from the nearest pixel, since a mean of two depths or ids
/// belongs to neither surface. The origin is 0, 0. Equal bytes on any number of threads. Errors: a size that
/// is not positive or beyond k_most_compared_pixels, what OpenImageIO reports. Cost: about a second for 8
/// million pixels; memory: the result.
ComparedImage resized(const ComparedImage& image, int width, int height);

}  // namespace alidade::compare
