// SPDX-License-Identifier: MIT
#include "geo/raster_file.h"

#include <fmt/format.h>
#include <gdal_frmts.h>

#include <array>
#include <cassert>

#include "base/error.h"
#include "base/output_file.h"
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
  const GdalTexts options{fmt::format("DATAPOINTER={}", data)};
  if (GDALAddBand(dataset, type_of(band), options.list()) != CE_None)
    fail_geotiff(file, "cannot write a band");
  void* const added = GDALGetRasterBand(dataset, GDALGetRasterCount(dataset));
  if (band.no_data) GDALSetRasterNoDataValue(added, *band.no_data);
  if (!band.description.empty()) GDALSetDescription(added, band.description.c_str());
  if (!band.unit.empty()) GDALSetRasterUnitType(added, band.unit.c_str());
}

}  // namespace

void write_raster(const std::filesystem::path& file, const RasterContents& contents, bool overwrite) {
  check_raster_name(file);
  assert(!contents.bands.empty() && contents.grid.size() > 0);
  for (const RasterBand& band : contents.bands) {
    if (band.values.index() != contents.bands.front().values.index())
      throw file_error(file, "all bands of a raster must have the same data type");
  }
  OutputFile output(file, overwrite);
  const std::string wkt = wkt_of(contents.crs);
  const QuietGdal quiet;
  GDALRegister_MEM();
  GDALRegister_GTiff();
  GDALRegister_COG();
  const GDALDriverH memory_driver = GDALGetDriverByName("MEM"), cog_driver = GDALGetDriverByName("COG");
  if (memory_driver == nullptr || cog_driver == nullptr) fail_geotiff(file, "GDAL lacks the COG driver");

  const RasterGrid& grid = contents.grid;
  const GdalDataset values(GDALCreate(memory_driver, "", grid.columns, grid.rows, 0, GDT_Byte, nullptr));
  if (!values) fail_geotiff(file, "cannot create the file");
  for (const RasterBand& band : contents.bands) add_band(values.get(), band, grid, file);
  std::array<double, 6> transform = {grid.north_west.x, grid.cell_size, 0.0, grid.north_west.y, 0.0,
                                     -grid.cell_size};
  if (GDALSetGeoTransform(values.get(), transform.data()) != CE_None)
    fail_geotiff(file, "cannot set the georeference");
  if (!wkt.empty()) GDALSetProjection(values.get(), wkt.c_str());
  GDALSetMetadataItem(values.get(), "TIFFTAG_SOFTWARE", "Alidade " ALIDADE_VERSION, nullptr);
  for (const auto& [key, text] : contents.metadata)
    GDALSetMetadataItem(values.get(), key.c_str(), text.c_str(), nullptr);

  const bool whole_numbers = type_of(contents.bands.front()) != GDT_Float32;
  const GdalTexts options{"COMPRESS=DEFLATE", "PREDICTOR=YES", "BIGTIFF=IF_SAFER", "NUM_THREADS=1",
                          whole_numbers ? "OVERVIEW_RESAMPLING=NEAREST" : "OVERVIEW_RESAMPLING=AVERAGE"};
  const GdalMemoryFile encoded;
  CPLErrorReset();
  GdalDataset copy(
      GDALCreateCopy(cog_driver, encoded.name(), values.get(), FALSE, options.list(), nullptr, nullptr));
  if (!copy) fail_geotiff(file, "cannot encode the file");
  copy.reset();
  if (CPLGetLastErrorType() >= CE_Failure || encoded.bytes().empty())
    fail_geotiff(file, "cannot complete the file");
  output.write(encoded.bytes());
  output.commit();
}

}  // namespace alidade::geo
