// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/output_file.h"
#include "cloud/crs.h"

namespace alidade::geo {

/// A picture on the ground, but for its pixels.
struct GroundPicture {
  int width = 0, height = 0;
  /// World x = [0] + [1] column + [2] row, y = [3] + [4] column + [5] row, with (0, 0) the outer corner of
  /// the first pixel.
  std::array<double, 6> transform{};
  Crs crs;
  std::vector<std::pair<std::string, std::string>> texts;  ///< metadata: key and text
};

/// Fills rows of red, green, blue and alpha, from `first_row` on.
using FillRows = std::function<void(int first_row, int rows, std::span<std::uint8_t> rgba)>;

/// Red, green, blue and alpha with 8 bits, in tiles, compressed without loss. The same pixels give the same
/// bytes. `name` is the file's in messages.
void write_geotiff(const std::filesystem::path& name, const GroundPicture& picture, const FillRows& fill,
                   OutputFile& file);

}  // namespace alidade::geo
