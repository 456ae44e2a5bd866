// SPDX-License-Identifier: MIT
#pragma once

#include <cpl_error.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal.h>
#include <ogr_srs_api.h>
#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "cloud/crs.h"
#include "geo/vector_file.h"

// What belongs to GDAL, given back when it is no longer used.

namespace alidade::geo {

/// GDAL says nothing by itself while this lives; what it would have said last is kept.
class QuietGdal {
 public:
  QuietGdal() {
    CPLPushErrorHandler(CPLQuietErrorHandler);
    CPLErrorReset();
  }
  ~QuietGdal() { CPLPopErrorHandler(); }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
};

/// A file in memory under a name of its own, by default that of a TIFF file, that is gone with this object.
class GdalMemoryFile {
 public:
  explicit GdalMemoryFile(const char* extension = ".tif")
      : name_(fmt::format("/vsimem/alidade_{}{}", static_cast<const void*>(this), extension)) {}
  ~GdalMemoryFile() { VSIUnlink(name_.c_str()); }
  GdalMemoryFile(const GdalMemoryFile&) = delete;
  GdalMemoryFile& operator=(const GdalMemoryFile&) = delete;

  const char* name() const { return name_.c_str(); }
  std::span<const std::byte> bytes() const {
    vsi_l_offset size = 0;
    const GByte* const data = VSIGetMemFileBuffer(name_.c_str(), &size, FALSE);
    if (data == nullptr) return {};
    return std::as_bytes(std::span(data, static_cast<std::size_t>(size)));
  }

 private:
  std::string name_;
};

/// What was expected where a reference system is unknown: with the authority for a number alone, else `usual`.
std::string expected_system(const std::string& text, const std::string& usual);

/// Throws the Error about a GeoTIFF, with what GDAL said last.
[[noreturn]] void fail_geotiff(const std::filesystem::path& file, const char* what);

/// Something that GDAL made, given back by the function `release` when it is no longer used.
template <auto release>
struct GdalRelease {
  void operator()(void* handle) const { release(handle); }
};
template <auto release>
using GdalHandle = std::unique_ptr<void, GdalRelease<release>>;

using GdalDataset = GdalHandle<GDALClose>;
using GdalReference = GdalHandle<OSRRelease>;
using GdalTransformation = GdalHandle<OCTDestroyCoordinateTransformation>;

/// The reference system as WKT: what the file gave, or what its GeoTIFF keys mean, as GDAL reads them. Empty
/// if it is missing or invalid.
std::string wkt_of(const Crs& crs);

/// Null for text that is empty or that GDAL does not understand.
GdalReference reference_of_wkt(const std::string& wkt);

/// A system as WKT of a kind that GDAL names, such as "FORMAT=WKT1"; empty if it has none of that kind.
std::string wkt_in_format(OGRSpatialReferenceH reference, const char* format);

/// The plane part of a cloud's system; null if GDAL does not know it or it lies nowhere on Earth.
GdalReference plane_reference(const Crs& crs);

/// Longitude before latitude, WGS 84; null if GDAL's tables are not installed.
GdalReference globe_reference();

/// Null if there is no way from one to the other.
GdalTransformation transformation_between(const GdalReference& from, const GdalReference& to);

/// The way from a file's reference system, `own`, WKT, empty if the file says nothing, to the cloud's; null
/// if positions stay what they are, because both are the same or none is known. `source` is what an Error
/// names. Errors: one is known and the other not; one that GDAL does not understand; there is no way.
GdalTransformation transformation_to_cloud(const std::string& own, const ObserverReference& reference,
                                           const std::string& source);

/// A position in the other reference system, if it has an image there.
std::optional<glm::dvec2> transformed(glm::dvec2 position, const GdalTransformation& transformation);

/// A position in the cloud's reference system. Errors: it has no image there; they name `source`.
glm::dvec2 transformed(const glm::dvec2& position, const GdalTransformation& transformation,
                       const std::string& source);

}  // namespace alidade::geo
