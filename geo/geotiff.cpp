// SPDX-License-Identifier: MIT
#include "geo/geotiff.h"

#include <gdal_frmts.h>

#include <algorithm>

#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

/// Hands the picture over in rows of tiles, band by band, so that the copy of the image stays small.
void write_rows(void* dataset, const GroundPicture& picture, const FillRows& fill,
                const std::filesystem::path& file) {
  constexpr int k_rows = 256;
  const std::size_t row_size = 4 * static_cast<std::size_t>(picture.width);
  std::vector<std::uint8_t> pixels(row_size * std::min(k_rows, picture.height));
  for (int begin = 0; begin < picture.height; begin += k_rows) {
    const int rows = std::min(k_rows, picture.height - begin);
    fill(begin, rows, std::span(pixels).first(row_size * rows));
    if (GDALDatasetRasterIO(dataset, GF_Write, 0, begin, picture.width, rows, pixels.data(), picture.width,
                            rows, GDT_Byte, 4, nullptr, 4, 4 * picture.width, 1) != CE_None)
      fail_geotiff(file, "cannot write rows");
  }
}

}  // namespace

void write_geotiff(const std::filesystem::path& name, const GroundPicture& picture, const FillRows& fill,
                   OutputFile& file) {
  std::array<double, 6> transform = picture.transform;
  const std::string wkt = wkt_of(picture.crs);
  const QuietGdal quiet;
  GDALRegister_GTiff();
  const GdalMemoryFile memory;
  const GDALDriverH driver = GDALGetDriverByName("GTiff");
  if (driver == nullptr) fail_geotiff(name, "GDAL lacks the GTiff driver");
  const GdalTexts options{"COMPRESS=DEFLATE",   "PREDICTOR=2",      "TILED=YES",    "PHOTOMETRIC=RGB",
                          "ALPHA=UNASSOCIATED", "BIGTIFF=IF_SAFER", "NUM_THREADS=1"};
  GdalDataset dataset(
      GDALCreate(driver, memory.name(), picture.width, picture.height, 4, GDT_Byte, options.list()));
  if (!dataset) fail_geotiff(name, "cannot create the file");
  if (GDALSetGeoTransform(dataset.get(), transform.data()) != CE_None)
    fail_geotiff(name, "cannot set the georeference");
  GDALSetRasterColorInterpretation(GDALGetRasterBand(dataset.get(), 4), GCI_AlphaBand);
  // A reference system that GDAL does not understand is left out; the picture is right without it.
  if (!wkt.empty()) GDALSetProjection(dataset.get(), wkt.c_str());
  for (const auto& [key, text] : picture.texts) {
    // To GDAL a colon ends the name.
    std::string item = key == "Software" ? "TIFFTAG_SOFTWARE" : key;
    std::ranges::replace(item, ':', '_');
    GDALSetMetadataItem(dataset.get(), item.c_str(), text.c_str(), nullptr);
  }
  write_rows(dataset.get(), picture, fill, name);
  CPLErrorReset();
  dataset.reset();
  if (CPLGetLastErrorType() >= CE_Failure || memory.bytes().empty())
    fail_geotiff(name, "cannot complete the file");
  file.write(memory.bytes());
}

}  // namespace alidade::geo
