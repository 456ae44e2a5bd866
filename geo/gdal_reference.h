// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "cloud/crs.h"
#include "geo/gdal.h"
#include "geo/vector_file.h"

// Objects of GDAL, released when they are no longer used.

namespace alidade::geo {

/// Keeps GDAL from printing messages while this lives; its last message is kept.
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

/// Sets an option of GDAL for this thread while this lives.
class GdalOption {
 public:
  GdalOption(const char* name, const char* value) : name_(name) {
    if (const char* const before = CPLGetThreadLocalConfigOption(name, nullptr)) before_ = before;
    CPLSetThreadLocalConfigOption(name, value);
  }
  ~GdalOption() { CPLSetThreadLocalConfigOption(name_, before_ ? before_->c_str() : nullptr); }
  GdalOption(const GdalOption&) = delete;
  GdalOption& operator=(const GdalOption&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_{};
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

/// What messages expect instead of an unknown reference system: "EPSG:" with the number for a number alone,
/// else `usual`.
std::string expected_system(const std::string& text, const std::string& usual);

/// Throws the Error about a GeoTIFF, with GDAL's last message.
[[noreturn]] void fail_geotiff(const std::filesystem::path& file, const char* what);

/// An object that GDAL made, released by the function `release` when it is no longer used.
template <const auto& release>
struct GdalRelease {
  void operator()(auto* object) const { release(object); }
};
template <const auto& release, class Object = void>
using GdalHandle = std::unique_ptr<Object, GdalRelease<release>>;

using GdalDataset = GdalHandle<GDALClose>;
using GdalReference = GdalHandle<OSRRelease>;
using GdalTransformation = GdalHandle<OCTDestroyCoordinateTransformation>;

/// The reference system as WKT: that of the file, or that of its GeoTIFF keys, as GDAL reads them. Empty if
/// it is missing or invalid.
std::string wkt_of(const Crs& crs);

/// Null for text that is empty or that GDAL does not understand.
GdalReference reference_of_wkt(const std::string& wkt);

/// A system as WKT in a format of GDAL, such as "FORMAT=WKT1"; empty if it cannot be written so.
std::string wkt_in_format(OGRSpatialReferenceH reference, const char* format);

/// The plane part of a cloud's system; null if GDAL does not support it or it has no relation to the Earth.
GdalReference plane_reference(const Crs& crs);

/// Longitude before latitude, WGS 84; null if GDAL's tables are not installed.
GdalReference globe_reference();

/// Null if there is no transformation from one to the other.
GdalTransformation transformation_between(const GdalReference& from, const GdalReference& to);

/// The transformation of move_to_cloud(); null if positions need none.
GdalTransformation transformation_to_cloud(const std::string& own, const ObserverReference& reference,
                                           const std::string& source);

/// Transforms a position; empty if it has no image in the other system.
std::optional<glm::dvec2> transformed(glm::dvec2 position, const GdalTransformation& transformation);

}  // namespace alidade::geo
