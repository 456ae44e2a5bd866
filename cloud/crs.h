// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bounds.h"

namespace alidade {

/// The coordinate reference system that a file states, in the file's notation; writers write it unchanged.
/// All members are empty for a file that states no system.
struct Crs {
  std::string wkt;                          ///< OGC WKT, without trailing NUL
  std::vector<std::uint16_t> geotiff_keys;  ///< GeoKeyDirectoryTag: groups of four
  std::vector<double> geotiff_doubles;      ///< GeoDoubleParamsTag
  std::string geotiff_ascii;                ///< GeoAsciiParamsTag

  bool empty() const { return wkt.empty() && geotiff_keys.empty(); }
  bool operator==(const Crs&) const = default;
};

inline Crs crs_of_wkt(std::string wkt) {
  Crs crs;
  crs.wkt = std::move(wkt);
  return crs;
}

/// The part of a WKT from the first of the keys that it contains, such as "PROJCS[", to the bracket that
/// closes it; brackets within quotes do not count. Empty if it is missing or does not end. A view of `wkt`.
inline std::string_view wkt_node(std::string_view wkt, std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) {
    const std::size_t begin = wkt.find(key);
    if (begin == std::string_view::npos) continue;
    int depth = 0;
    bool is_quoted = false;
    for (std::size_t i = begin; i < wkt.size(); ++i) {
      if (wkt[i] == '"') is_quoted = !is_quoted;
      if (is_quoted) continue;
      if (wkt[i] == '[') ++depth;
      if (wkt[i] == ']' && --depth == 0) return wkt.substr(begin, i + 1 - begin);
    }
  }
  return {};
}

/// EPSG codes that GeoTIFF keys contain, such as "EPSG:25832" and "vertical EPSG:7837": those of geographic,
/// projected and vertical system.
std::vector<std::string> epsg_codes(const Crs& crs);

/// Name of a system for messages: that in its WKT (for a compound one those of its parts), else its codes by
/// epsg_codes().
std::string crs_name(const Crs& crs);

/// The alphanumeric characters of a name, in lower case: programs write one name with different separators.
std::string alphanumeric(std::string_view name);

/// Whether two systems are the same, as far as known.
enum class CrsAgreement { same, unknown, different };

/// Compares two systems, which must not be empty, in any notation. The CrsLibrary decides, if one is in use
/// and supports both systems. Otherwise compare_crs_text() decides, except that beside a library its result
/// `different` becomes `unknown`.
CrsAgreement compare_crs(const Crs& a, const Crs& b);

/// Whether two projected systems, WKT of version 1, are defined by the same numbers: ellipsoid, prime
/// meridian, units, and the parameters of the projection. Parameters are compared by the alphanumeric
/// characters of their names. Programs have their own names of systems, datums and projections, such as
/// "ETRS89 / UTM zone 32N" and "ETRS_1989_UTM_Zone_32N", but agree in the numbers up to their last digit.
/// Equal numbers do not make equal systems: datums on one ellipsoid differ by up to some metres. False for
/// systems without parameters, or with different ones, such as WKT of version 2 beside that of version 1.
bool same_definition(const std::string& wkt_a, const std::string& wkt_b);

/// compare_crs() without a library. Different units make different systems. Then, if both systems have EPSG
/// codes, the codes decide; else WKT is compared with WKT, by the alphanumeric characters of names and by
/// numbers, and GeoTIFF keys with GeoTIFF keys, value by value. `unknown`: WKT without a code beside keys;
/// different names of the same numbers (same_definition()).
CrsAgreement compare_crs_text(const Crs& a, const Crs& b);

/// Functions of a library of reference systems. The one in use is PROJ (geo/crs_library.h), on which this
/// folder does not depend.
struct CrsLibrary {
  /// Empty if the library does not support one of the systems.
  std::optional<CrsAgreement> (*compare)(const Crs& a, const Crs& b) = nullptr;
  /// All of a system as WKT, heights included; empty if the library does not support it.
  std::string (*wkt)(const Crs& crs) = nullptr;
};

/// Sets the library. Call before clouds are read.
void use_crs_library(const CrsLibrary& library);
/// The library in use; both functions are null before use_crs_library().
const CrsLibrary& crs_library();

/// All of a system as WKT: that of the file, or that of its GeoTIFF keys by the library. Empty if the system
/// is unknown, or its keys are not supported.
std::string whole_wkt(const Crs& crs);

/// The first value of a GeoTIFF key that is stored in the directory itself.
std::optional<std::uint16_t> geotiff_value(const Crs& crs, std::uint16_t key);

/// Whether the system's horizontal coordinates are longitude and latitude. WKT: that of a geographic system,
/// also as part of a compound one. GeoTIFF keys, if there is no WKT: model type 2 or, without a model type, a
/// geographic system and no projected one. False if unknown.
bool is_geographic(const Crs& crs);

/// Whether the system's origin is the centre of the Earth: WKT of a geocentric system or, if there is no WKT,
/// the GeoTIFF model type 3.
bool is_geocentric(const Crs& crs);

/// A warning if points within `bounds` cannot belong to the system; else empty. Longitude and latitude:
/// horizontal coordinates beyond 400 (a full circle in gradians, the smallest unit of angle in use) are not
/// angles.
/// Geocentric: the middle of the points must be 6300 to 6500 km from the centre of the Earth, whose radius is
/// 6357 to 6378 km. Empty bounds are plausible.
std::optional<std::string> implausible_crs(const Crs& crs, const Bounds& bounds);

}  // namespace alidade
