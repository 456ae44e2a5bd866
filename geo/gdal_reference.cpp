// SPDX-License-Identifier: MIT
#include "geo/gdal_reference.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace alidade::geo {
namespace {

/// Leaves x and y of a system, x before y whatever its axes. Heights do not affect x and y, and their grids
/// may not be installed.
void make_plane(const GdalReference& reference) {
  OSRStripVertical(reference.get());
  OSRSetAxisMappingStrategy(reference.get(), OAMS_TRADITIONAL_GIS_ORDER);
}

/// Appends values of a TIFF file, little endian.
class TiffBytes {
 public:
  template <typename Value>
  void add(Value value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }

  /// An entry of the directory: tag, type (2 text, 3 short, 4 long, 12 double), count, value or its offset.
  void entry(std::uint16_t tag, std::uint16_t type, std::size_t count, std::size_t value) {
    add(tag);
    add(type);
    add(static_cast<std::uint32_t>(count));
    add(static_cast<std::uint32_t>(value));
  }
  std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

/// The smallest TIFF file, of one pixel, with these GeoTIFF keys: GDAL interprets keys only in a file.
/// Source: TIFF 6.0, OGC GeoTIFF 1.1.
std::vector<std::byte> tiff_with_keys(const Crs& crs) {
  constexpr std::size_t k_entries = 11, k_directory = 8, k_pixel = k_directory + 2 + 12 * k_entries + 4;
  constexpr std::size_t k_keys = k_pixel + 8;
  const std::size_t doubles = k_keys + 2 * crs.geotiff_keys.size();
  // TIFF stores values of up to four bytes in the entry itself; padding avoids that.
  std::vector<double> numbers = crs.geotiff_doubles;
  if (numbers.empty()) numbers.push_back(0.0);
  std::string text = crs.geotiff_ascii;
  text.resize(std::max<std::size_t>(text.size() + 1, 8));
  TiffBytes tiff;
  tiff.add(std::uint32_t{0x002A4949});
  tiff.add(static_cast<std::uint32_t>(k_directory));
  tiff.add(static_cast<std::uint16_t>(k_entries));
  tiff.entry(256, 3, 1, 1);        // width
  tiff.entry(257, 3, 1, 1);        // height
  tiff.entry(258, 3, 1, 8);        // bits
  tiff.entry(259, 3, 1, 1);        // not compressed
  tiff.entry(262, 3, 1, 1);        // black is 0
  tiff.entry(273, 4, 1, k_pixel);  // the pixel
  tiff.entry(278, 3, 1, 1);        // rows in it
  tiff.entry(279, 4, 1, 1);        // its bytes
  tiff.entry(34735, 3, crs.geotiff_keys.size(), k_keys);
  tiff.entry(34736, 12, numbers.size(), doubles);
  tiff.entry(34737, 2, text.size(), doubles + 8 * numbers.size());
  tiff.add(std::uint32_t{0});
  tiff.add(std::uint64_t{0});
  for (const std::uint16_t key : crs.geotiff_keys) tiff.add(key);
  for (const double number : numbers) tiff.add(number);
  for (const char character : text) tiff.add(character);
  return std::move(tiff.bytes());
}

/// The reference system that a user's text or the WKT of a file denotes; null for an empty text. Errors: GDAL
/// does not understand it.
GdalReference read_reference(const std::string& text, bool is_wkt, const std::string& whose,
                             const std::string& way_out) {
  if (text.empty()) return nullptr;
  GdalReference reference = is_wkt ? reference_of_wkt(text) : GdalReference(OSRNewSpatialReference(nullptr));
  check_that(reference && (is_wkt || OSRSetFromUserInput(reference.get(), text.c_str()) == OGRERR_NONE),
             "the reference system of " + whose + " is invalid", expected_system(text, way_out), text);
  return reference;
}

/// The plane part of a reference system, x east and y north; null for one without a relation to the Earth.
GdalReference plane_part(GdalReference reference) {
  if (!reference || OSRIsLocal(reference.get()) != 0) return nullptr;
  // The name of GeoPackage for unknown systems.
  const char* const name = OSRGetName(reference.get());
  if (name != nullptr && std::string_view(name).starts_with("Undefined")) return nullptr;
  make_plane(reference);
  return reference;
}

}  // namespace

std::string expected_system(const std::string& text, const std::string& usual) {
  const bool is_code = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  return is_code ? "EPSG:" + text : usual;
}

void fail_geotiff(const std::filesystem::path& file, const char* what) {
  const std::string said = CPLGetLastErrorMsg();
  throw file_error(file,
                   fmt::format("cannot write the GeoTIFF: {}{}{}", what, said.empty() ? "" : ": ", said));
}

std::string wkt_of(const Crs& crs) {
  constexpr std::size_t k_most_keys = 65535;
  if (!crs.wkt.empty() || crs.geotiff_keys.empty()) return crs.wkt;
  if (crs.geotiff_keys.size() > k_most_keys || crs.geotiff_doubles.size() > k_most_keys) return "";
  const QuietGdal quiet;
  GDALRegister_GTiff();
  const GdalMemoryFile file;
  std::vector<std::byte> bytes = tiff_with_keys(crs);
  VSIFCloseL(VSIFileFromMemBuffer(file.name(), reinterpret_cast<GByte*>(bytes.data()), bytes.size(), FALSE));
  const GdalDataset dataset(GDALOpen(file.name(), GA_ReadOnly));
  if (!dataset) return "";
  const char* const wkt = GDALGetProjectionRef(dataset.get());
  return wkt != nullptr ? wkt : "";
}

GdalReference reference_of_wkt(const std::string& wkt) {
  GdalReference reference(OSRNewSpatialReference(nullptr));
  char* text = const_cast<char*>(wkt.c_str());
  if (wkt.empty() || OSRImportFromWkt(reference.get(), &text) != OGRERR_NONE) return nullptr;
  return reference;
}

std::string wkt_in_format(OGRSpatialReferenceH reference, const char* format) {
  const char* const options[] = {format, nullptr};
  char* text = nullptr;
  const bool is_written = OSRExportToWktEx(reference, &text, options) == OGRERR_NONE;
  std::string wkt = is_written && text != nullptr ? text : "";
  CPLFree(text);
  return wkt;
}

GdalReference plane_reference(const Crs& crs) {
  GdalReference reference = reference_of_wkt(wkt_of(crs));
  if (!reference) return nullptr;
  if (OSRIsGeocentric(reference.get()) != 0 || OSRIsLocal(reference.get()) != 0) return nullptr;
  make_plane(reference);
  return reference;
}

GdalReference globe_reference() {
  GdalReference reference(OSRNewSpatialReference(nullptr));
  if (OSRImportFromEPSG(reference.get(), 4326) != OGRERR_NONE) return nullptr;
  make_plane(reference);
  return reference;
}

GdalTransformation transformation_between(const GdalReference& from, const GdalReference& to) {
  return GdalTransformation(OCTNewCoordinateTransformation(from.get(), to.get()));
}

GdalTransformation transformation_to_cloud(const std::string& own, const ObserverReference& reference,
                                           const std::string& source) {
  if (reference.given == "cloud") return nullptr;
  const QuietGdal quiet;
  const bool is_wkt = reference.given.empty();
  const std::string& option = reference.option;
  const std::string& whose = reference.whose;
  const std::string way_out = fmt::format("{0} SYSTEM, or {0} cloud if they are in the cloud's", option);
  const GdalReference from =
      plane_part(read_reference(is_wkt ? own : reference.given, is_wkt, "the " + whose, way_out));
  const GdalReference to = plane_part(read_reference(wkt_of(reference.cloud), true, "the cloud", way_out));
  if (!from && !to) return nullptr;
  if (!from || !to) {
    const std::string cloud = "cloud";
    throw file_error(source,
                     fmt::format("the reference system of the {} is unknown, but that of the {} is known",
                                 to ? whose : cloud, to ? cloud : whose),
                     to ? way_out : option + " cloud if they are in the cloud's own");
  }
  if (OSRIsSame(from.get(), to.get()) != 0) return nullptr;
  GdalTransformation transformation = transformation_between(from, to);
  check_that(transformation != nullptr,
             fmt::format("no transformation from the reference system of the {} to the cloud's: {}", whose,
                         CPLGetLastErrorMsg()));
  return transformation;
}

std::optional<glm::dvec2> transformed(glm::dvec2 position, const GdalTransformation& transformation) {
  if (OCTTransform(transformation.get(), 1, &position.x, &position.y, nullptr) == 0) return {};
  if (!std::isfinite(position.x) || !std::isfinite(position.y)) return {};
  return position;
}

}  // namespace alidade::geo
