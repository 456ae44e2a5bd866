// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "geo/raster.h"
#include "tests/support/random.h"

// Elevation rasters whose viewsheds are compared with exact ones.

namespace alidade::test {

/// Two waves.
inline geo::Raster<float> hills(int size) {
  geo::Raster<float> heights({{690000.0, 5325000.0}, 10.0, size, size}, 0.0f);
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      heights.at(column, row) =
          static_cast<float>(600.0 + 40.0 * std::sin(0.11 * column) * std::cos(0.13 * row) +
                             9.0 * std::sin(0.9 * column + 0.4 * row));
    }
  }
  return heights;
}

/// Streets at a height of 20 between boxes of all heights, and some holes.
inline geo::Raster<float> town(int size, Random& random) {
  geo::Raster<float> heights({{690000.0, 5325000.0}, 1.0, size, size}, 20.0f);
  for (int box = 0; box < size; ++box) {
    const auto west = static_cast<int>(random.below(size)), north = static_cast<int>(random.below(size));
    const auto width = static_cast<int>(2 + random.below(12)),
               length = static_cast<int>(2 + random.below(12));
    const auto roof = static_cast<float>(random.between(23, 40));
    for (int row = north; row < std::min(north + length, size); ++row)
      for (int column = west; column < std::min(west + width, size); ++column) heights.at(column, row) = roof;
  }
  for (int i = 0; i < size; ++i) {
    heights.at(static_cast<int>(random.below(size)), static_cast<int>(random.below(size))) =
        std::numeric_limits<float>::quiet_NaN();
  }
  return heights;
}

/// A town() with streets in place of the holes.
inline geo::Raster<float> whole_town(const geo::Raster<float>& town) {
  geo::Raster<float> whole = town;
  std::ranges::replace_if(
      whole.values, [](float height) { return std::isnan(height); }, 20.0f);
  return whole;
}

}  // namespace alidade::test
