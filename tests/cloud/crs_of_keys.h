// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "cloud/crs.h"

namespace alidade::test {

/// A system of GeoTIFF keys: their numbers, each before its value.
inline Crs crs_of_keys(const std::vector<std::uint16_t>& keys) {
  Crs crs;
  crs.geotiff_keys = {1, 1, 0, static_cast<std::uint16_t>(keys.size() / 2)};
  for (std::size_t i = 0; i < keys.size(); i += 2)
    crs.geotiff_keys.insert(crs.geotiff_keys.end(), {keys[i], 0, 1, keys[i + 1]});
  return crs;
}

}  // namespace alidade::test
