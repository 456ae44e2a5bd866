// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace alidade {

/// The coordinate reference system as the file gave it. Nothing is interpreted here; what came in goes out.
/// All empty = the file says nothing.
struct Crs {
  std::string wkt;                          ///< OGC WKT, without trailing NUL
  std::vector<std::uint16_t> geotiff_keys;  ///< GeoKeyDirectoryTag: groups of four
  std::vector<double> geotiff_doubles;      ///< GeoDoubleParamsTag
  std::string geotiff_ascii;                ///< GeoAsciiParamsTag

  bool empty() const { return wkt.empty() && geotiff_keys.empty(); }
  bool operator==(const Crs&) const = default;
};

}  // namespace alidade
