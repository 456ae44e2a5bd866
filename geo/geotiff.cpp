// SPDX-License-Identifier: MIT
#include "geo/geotiff.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "base/error.h"
#include "camera/camera.h"
#include "geo/gdal_reference.h"
#include "image/srgb.h"
#include "renderer/picture_metadata.h"

namespace alidade {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
  const std::string said = CPLGetLastErrorMsg();
  throw Error(
      {.file = file.string(), .problem = fmt::format("GeoTIFF cannot be written: {}", what), .found = said});
}

/// Appends values of a TIFF file, little endian.
class TiffBytes {
 public:
  template <typename Value>
  void add(Value value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  /// An entry of the directory: tag, type (2 text, 3 short, 4 long, 12 double), count, value or its place.
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

/// The smallest TIFF file, of one pixel, with these GeoTIFF keys: GDAL explains keys only in such a file.
/// Source: TIFF 6.0, OGC GeoTIFF 1.1.
std::vector<std::byte> tiff_with_keys(const Crs& crs) {
  constexpr std::size_t k_entries = 11, k_directory = 8, k_pixel = k_directory + 2 + 12 * k_entries + 4;
  constexpr std::size_t k_keys = k_pixel + 8;
  const std::size_t doubles = k_keys + 2 * crs.geotiff_keys.size();
  // Values of up to four bytes would have to stand in the entry itself.
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
  for (const char letter : text) tiff.add(letter);
  return std::move(tiff.bytes());
}

std::uint8_t alpha_code(float alpha) {
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(alpha, 0.0f, 1.0f)));
}

/// Hands the film over in rows of tiles, band by band, so that the copy of the image stays small.
void fill(void* dataset, const Film& film, double scale, const std::filesystem::path& file) {
  constexpr int k_rows = 256;
  std::vector<std::uint8_t> pixels(4 * static_cast<std::size_t>(film.width) * std::min(k_rows, film.height));
  for (int begin = 0; begin < film.height; begin += k_rows) {
    const int rows = std::min(k_rows, film.height - begin);
    auto pixel = pixels.begin();
    for (int y = begin; y < begin + rows; ++y) {
      for (int x = 0; x < film.width; ++x) {
        const std::size_t index = film.index(x, y);
        for (int channel = 0; channel < 3; ++channel)
          *pixel++ = srgb_code(film.color[index][channel] * scale);
        *pixel++ = alpha_code(film.alpha[index]);
      }
    }
    if (GDALDatasetRasterIO(dataset, GF_Write, 0, begin, film.width, rows, pixels.data(), film.width, rows,
                            GDT_Byte, 4, nullptr, 4, 4 * film.width, 1) != CE_None)
      fail(file, "rows were refused");
  }
}

}  // namespace

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

void write_geotiff(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
                   OutputFile& file) {
  std::array<double, 6> transform = ground_transform(metadata.camera);
  const std::string wkt = wkt_of(metadata.crs);
  const QuietGdal quiet;
  GDALRegister_GTiff();
  const GdalMemoryFile memory;
  const GDALDriverH driver = GDALGetDriverByName("GTiff");
  if (driver == nullptr) fail(output.file, "GDAL lacks its GTiff driver");
  char** options = nullptr;
  for (const char* const option : {"COMPRESS=DEFLATE", "PREDICTOR=2", "TILED=YES", "PHOTOMETRIC=RGB",
                                   "ALPHA=UNASSOCIATED", "BIGTIFF=IF_SAFER", "NUM_THREADS=1"})
    options = CSLAddString(options, option);
  GdalDataset dataset(GDALCreate(driver, memory.name(), film.width, film.height, 4, GDT_Byte, options));
  CSLDestroy(options);
  if (!dataset) fail(output.file, "it cannot be created");
  if (GDALSetGeoTransform(dataset.get(), transform.data()) != CE_None)
    fail(output.file, "its place was refused");
  GDALSetRasterColorInterpretation(GDALGetRasterBand(dataset.get(), 4), GCI_AlphaBand);
  // A reference system that GDAL does not understand is left out; the picture is right without it.
  if (!wkt.empty()) GDALSetProjection(dataset.get(), wkt.c_str());
  for (const auto& [key, text] : metadata_texts(metadata)) {
    // To GDAL a colon ends the name.
    std::string name = key == "Software" ? "TIFFTAG_SOFTWARE" : key;
    std::ranges::replace(name, ':', '_');
    GDALSetMetadataItem(dataset.get(), name.c_str(), text.c_str(), nullptr);
  }
  fill(dataset.get(), film, exposure_scale(output.exposure), output.file);
  CPLErrorReset();
  dataset.reset();
  if (CPLGetLastErrorType() >= CE_Failure || memory.bytes().empty())
    fail(output.file, "it cannot be completed");
  file.write(memory.bytes());
}

}  // namespace alidade
