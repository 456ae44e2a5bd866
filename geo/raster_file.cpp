// SPDX-License-Identifier: MIT
#include "geo/raster_file.h"

#include <fmt/format.h>
#include <gdal_frmts.h>

#include <algorithm>
#include <cassert>

#include "base/error.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

GDALDataType type_of(const RasterBand& band) {
  constexpr std::array k_types = {GDT_Byte, GDT_UInt16, GDT_UInt32, GDT_Float32};
  return k_types[band.values.index()];
}

/// Shows the caller's values to GDAL without copying them.
void add_band(void* dataset, const RasterBand& band, const RasterGrid& grid,
              const std::filesystem::path& file) {
  const void* const data = std::visit(
      [&](const auto& values) -> const void* {
        if (values.size() != grid.size()) throw file_error(file, "the size of a band does not match the map");
        return values.data();
      },
      band.values);
  const std::string pointer = fmt::format("DATAPOINTER={}", data);
  const char* const options[] = {pointer.c_str(), nullptr};
  if (GDALAddBand(dataset, type_of(band), options) != CE_None) fail_geotiff(file, "cannot write a band");
  void* const added = GDALGetRasterBand(dataset, GDALGetRasterCount(dataset));
  if (band.no_data) GDALSetRasterNoDataValue(added, *band.no_data);
  if (!band.description.empty()) GDALSetDescription(added, band.description.c_str());
  if (!band.unit.empty()) GDALSetRasterUnitType(added, band.unit.c_str());
}

/// Hands the image over in rows of tiles, band by band, so that the copy of the image stays small.
void write_rows(void* dataset, const GroundImage& image, const FillRows& fill,
                const std::filesystem::path& file) {
  constexpr int k_rows = 256;
  const std::size_t row_size = 4 * static_cast<std::size_t>(image.width);
  std::vector<std::uint8_t> pixels(row_size * std::min(k_rows, image.height));
  for (int begin = 0; begin < image.height; begin += k_rows) {
    const int rows = std::min(k_rows, image.height - begin);
    fill(begin, rows, std::span(pixels).first(row_size * rows));
    if (GDALDatasetRasterIO(dataset, GF_Write, 0, begin, image.width, rows, pixels.data(), image.width, rows,
                            GDT_Byte, 4, nullptr, 4, 4 * image.width, 1) != CE_None)
      fail_geotiff(file, "cannot write rows");
  }
}

/// Sets transform and reference system. One that GDAL does not understand is left out; the rest is right
/// without it.
void georeference(void* dataset, std::array<double, 6> transform, const std::string& wkt,
                  const std::filesystem::path& file) {
  if (GDALSetGeoTransform(dataset, transform.data()) != CE_None)
    fail_geotiff(file, "cannot set the georeference");
  if (!wkt.empty()) GDALSetProjection(dataset, wkt.c_str());
}

/// Closes a file in memory and writes its bytes to another.
void complete(GdalDataset dataset, const GdalMemoryFile& memory, const std::filesystem::path& file,
              OutputFile& output) {
  dataset.reset();
  if (CPLGetLastErrorType() >= CE_Failure || memory.bytes().empty())
    fail_geotiff(file, "cannot complete the file");
  output.write(memory.bytes());
}

/// Writes a dataset to a cloud-optimised GeoTIFF. `resampling`: of its overviews.
void encode(void* dataset, const char* resampling, const std::filesystem::path& file, OutputFile& output) {
  GDALRegister_GTiff();
  GDALRegister_COG();
  const GDALDriverH driver = GDALGetDriverByName("COG");
  if (driver == nullptr) fail_geotiff(file, "GDAL lacks the COG driver");
  const std::string overviews = std::string("OVERVIEW_RESAMPLING=") + resampling;
  const char* const options[] = {"COMPRESS=DEFLATE", "PREDICTOR=YES",   "BIGTIFF=IF_SAFER",
                                 "NUM_THREADS=1",    overviews.c_str(), nullptr};
  const GdalMemoryFile encoded;
  CPLErrorReset();
  GdalDataset copy(GDALCreateCopy(driver, encoded.name(), dataset, FALSE, options, nullptr, nullptr));
  if (!copy) fail_geotiff(file, "cannot encode the file");
  complete(std::move(copy), encoded, file, output);
}

}  // namespace

void write_raster(const std::filesystem::path& file, const RasterContents& contents, bool overwrite) {
  check_raster_name(file);
  assert(!contents.bands.empty() && contents.grid.size() > 0);
  for (const RasterBand& band : contents.bands) {
    if (band.values.index() != contents.bands.front().values.index())
      throw file_error(file, "the bands have different data types");
  }
  OutputFile output(file, overwrite);
  const std::string wkt = wkt_of(contents.crs);
  const QuietGdal quiet;
  GDALRegister_MEM();
  const GDALDriverH memory_driver = GDALGetDriverByName("MEM");
  if (memory_driver == nullptr) fail_geotiff(file, "GDAL lacks the MEM driver");

  const RasterGrid& grid = contents.grid;
  const GdalDataset values(GDALCreate(memory_driver, "", grid.columns, grid.rows, 0, GDT_Byte, nullptr));
  if (!values) fail_geotiff(file, "cannot create the file");
  for (const RasterBand& band : contents.bands) add_band(values.get(), band, grid, file);
  georeference(values.get(),
               {grid.north_west.x, grid.cell_size, 0.0, grid.north_west.y, 0.0, -grid.cell_size}, wkt, file);
  GDALSetMetadataItem(values.get(), "TIFFTAG_SOFTWARE", "Alidade " ALIDADE_VERSION, nullptr);
  for (const auto& [key, text] : contents.metadata)
    GDALSetMetadataItem(values.get(), key.c_str(), text.c_str(), nullptr);

  const bool whole_numbers = type_of(contents.bands.front()) != GDT_Float32;
  encode(values.get(), whole_numbers ? "NEAREST" : "AVERAGE", file, output);
  output.commit();
}

void write_geotiff(const std::filesystem::path& name, const GroundImage& image, const FillRows& fill,
                   OutputFile& file) {
  const std::string wkt = wkt_of(image.crs);
  const QuietGdal quiet;
  GDALRegister_GTiff();
  const GdalMemoryFile memory;
  const GDALDriverH driver = GDALGetDriverByName("GTiff");
  if (driver == nullptr) fail_geotiff(name, "GDAL lacks the GTiff driver");
  const char* const options[] = {"COMPRESS=DEFLATE",   "PREDICTOR=2",      "TILED=YES",     "PHOTOMETRIC=RGB",
                                 "ALPHA=UNASSOCIATED", "BIGTIFF=IF_SAFER", "NUM_THREADS=1", nullptr};
  GdalDataset dataset(GDALCreate(driver, memory.name(), image.width, image.height, 4, GDT_Byte, options));
  if (!dataset) fail_geotiff(name, "cannot create the file");
  GDALSetRasterColorInterpretation(GDALGetRasterBand(dataset.get(), 4), GCI_AlphaBand);
  georeference(dataset.get(), image.transform, wkt, name);
  for (const auto& [key, text] : image.texts) {
    // To GDAL a colon ends the name.
    std::string item = key == "Software" ? "TIFFTAG_SOFTWARE" : key;
    std::ranges::replace(item, ':', '_');
    GDALSetMetadataItem(dataset.get(), item.c_str(), text.c_str(), nullptr);
  }
  write_rows(dataset.get(), image, fill, name);
  GDALFlushCache(dataset.get());
  encode(dataset.get(), "AVERAGE", name, file);
}

}  // namespace alidade::geo
