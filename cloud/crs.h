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

inline Crs crs_of_wkt(std::string wkt) {
  Crs crs;
  crs.wkt = std::move(wkt);
  return crs;
}

/// The piece of a WKT from the first of the keys that is in it, such as "PROJCS[", to the bracket that closes
/// it; brackets within quotes do not count. Empty if it is missing or does not end. It points into `wkt`.
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

/// EPSG codes that GeoTIFF keys give directly, as "EPSG:25832" and "vertical EPSG:7837": geographic,
/// projected and vertical system.
std::vector<std::string> epsg_codes(const Crs& crs);

/// Name of a system for people: that in its WKT, of compound ones those of the parts, else its EPSG codes.
std::string crs_name(const Crs& crs);

/// The alphanumeric characters of a name, in lower case: programs write one name with different separators.
std::string alphanumeric(std::string_view name);

/// What is known about two systems being one.
enum class CrsAgreement { same, unknown, different };

/// Compares two systems that are not empty, however they are written: by a CrsLibrary if one is used. Of what it does
/// not understand, and without one, by the units that they state, by their EPSG codes where both have one, else WKT by
/// its names, characters and digits alone, and its numbers, and GeoTIFF keys among themselves as they are; nothing is
/// known of WKT without code beside keys, and of two names for the same numbers (same_definition()). Where a library is
/// used and does not understand one of them, they are not `different`: `same` or `unknown`.
CrsAgreement compare_crs(const Crs& a, const Crs& b);

/// Whether two projected systems, WKT of version 1, are defined by the same numbers: ellipsoid, prime
/// meridian, units, and the parameters of the projection. Parameters are compared by the alphanumeric
/// characters of their names. Programs give systems, datums and projections names of their own, as
/// "ETRS89 / UTM zone 32N" and "ETRS_1989_UTM_Zone_32N", but share the numbers up to their last digit. Equal
/// numbers do not make equal systems: datums on one ellipsoid lie up to some metres apart. False for systems
/// without parameters, or with other ones, as WKT of version 2 beside that of version 1.
bool same_definition(const std::string& wkt_a, const std::string& wkt_b);

/// compare_crs() without a library.
CrsAgreement compare_crs_text(const Crs& a, const Crs& b);

/// What a library that this room does without knows about systems: PROJ (geo/crs_library.h).
struct CrsLibrary {
  /// Empty: it does not understand one of them.
  std::optional<CrsAgreement> (*compare)(const Crs& a, const Crs& b) = nullptr;
  /// All of a system as WKT, heights included; empty: it does not understand it.
  std::string (*wkt)(const Crs& crs) = nullptr;
};

/// To be called before clouds are read, by programs that have such a library.
void use_crs_library(const CrsLibrary& library);
/// The one that is used; without functions if none is.
const CrsLibrary& crs_library();

/// The first value of a GeoTIFF key that is stored in the directory itself.
std::optional<std::uint16_t> geotiff_value(const Crs& crs, std::uint16_t key);

/// Whether the system's horizontal coordinates are longitude and latitude: WKT of a geographic system (also
/// as part of a compound one), or, without WKT, a GeoTIFF model type of 2; without a model type, keys that
/// name a geographic system and no projected one. False if unknown.
bool is_geographic(const Crs& crs);

/// Whether the system's origin is the centre of the Earth: WKT of a geocentric system or, without WKT, a
/// GeoTIFF model type of 3.
bool is_geocentric(const Crs& crs);

/// A sentence if the points cannot lie in the system. Longitude and latitude: horizontal coordinates beyond
/// 400 (a full circle in gradians, the widest unit of angle in use) are no angles. Geocentric: the middle of
/// the points is 6300 to 6500 km from the centre of the Earth, whose radius is 6357 to 6378 km. Empty bounds
/// are never wrong.
std::optional<std::string> implausible_crs(const Crs& crs, const Bounds& bounds);

}  // namespace alidade
