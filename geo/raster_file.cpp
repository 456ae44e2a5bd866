// SPDX-License-Identifier: MIT
#include "geo/raster_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string_view>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/input_file.h"
#include "base/words.h"
#include "cloud/axis_units.h"
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

/// Opens a raster, which is closed when it is no longer used; null if GDAL cannot read it.
GdalDataset open_raster(const std::filesystem::path& file) {
  GDALAllRegister();
  // Without this option a GeoTIFF file would lose its vertical part.
  const GdalOption heights("GTIFF_REPORT_COMPD_CS", "YES");
  return GdalDataset(GDALOpenEx(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
}

std::string text_of(const std::array<double, 6>& transform) {
  return fmt::format("{}, {}, {}, {}, {}, {}", transform[0], transform[1], transform[2], transform[3],
                     transform[4], transform[5]);
}

/// World x = [0] + [1] column + [2] row, y = [3] + [4] column + [5] row. Errors: not squares north up, or
/// south up.
std::array<double, 6> square_transform(void* dataset, const std::filesystem::path& file) {
  std::array<double, 6> transform{};
  if (GDALGetGeoTransform(dataset, transform.data()) != CE_None) {
    throw file_error(file, "the raster has no georeference",
                     "a geotransform: gdal_translate -a_ullr or a world file");
  }
  for (const double number : transform) {
    if (!std::isfinite(number))
      throw file_error(file, "the geotransform of the raster is not finite", {}, text_of(transform));
  }
  const int columns = GDALGetRasterXSize(dataset), rows = GDALGetRasterYSize(dataset);
  const double width = transform[1], height = std::fabs(transform[5]);
  const double turned = std::fabs(transform[2]) * rows + std::fabs(transform[4]) * columns;
  constexpr double k_most = 1e-3;  // of a cell
  if (!(width > 0.0) || !(turned <= k_most * width)) {
    throw file_error(file, "the raster is rotated or sheared",
                     "columns along y, rows along x: resample it with gdalwarp", text_of(transform));
  }
  if (!(std::fabs(width - height) * std::max(columns, rows) <= k_most * width)) {
    throw file_error(file, "the cells of the raster are not square",
                     "one cell size: resample with gdalwarp -tr SIZE SIZE",
                     fmt::format("{} x {}", width, height));
  }
  return transform;
}

/// The unit of a band, by the names that programs use.
std::optional<LengthUnit> unit_of_band(void* band) {
  const std::string name = lower_case(GDALGetRasterUnitType(band));
  if (name == "m" || name.starts_with("metre") || name.starts_with("meter")) return k_metre;
  if (name == "us-ft" || name == "ftus" || name.find("survey") != std::string::npos) return k_survey_foot;
  const bool is_foot = name == "ft" || name.starts_with("foot") || name.starts_with("feet");
  return is_foot ? std::optional(k_foot) : std::nullopt;
}

Crs crs_of(void* dataset) {
  const char* const wkt = GDALGetProjectionRef(dataset);
  return crs_of_wkt(wkt != nullptr ? wkt : "");
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

bool is_raster(const std::filesystem::path& file) {
  const QuietGdal quiet;
  const GdalDataset dataset = open_raster(file);
  return dataset != nullptr && GDALGetRasterCount(dataset.get()) > 0 &&
         std::string_view(GDALGetDriverShortName(GDALGetDatasetDriver(dataset.get()))) != "XYZ";
}

HeightRaster read_heights(const std::filesystem::path& file, const Progress& progress) {
  const QuietGdal quiet;
  InputFile{file};
  const GdalDataset dataset = open_raster(file);
  if (!dataset || GDALGetRasterCount(dataset.get()) == 0)
    throw file_error(file, "not a raster", "a GeoTIFF or another raster format of GDAL",
                     CPLGetLastErrorMsg());
  HeightRaster raster;
  raster.crs = crs_of(dataset.get());
  if (is_geographic(raster.crs)) {
    throw file_error(file, "geographic coordinates (degrees) are not supported",
                     "a projected reference system: reproject the raster with gdalwarp -t_srs",
                     crs_name(raster.crs));
  }
  const std::array<double, 6> transform = square_transform(dataset.get(), file);
  const int columns = GDALGetRasterXSize(dataset.get()), rows = GDALGetRasterYSize(dataset.get());
  const auto cells = static_cast<std::uint64_t>(columns) * static_cast<std::uint64_t>(rows);
  if (cells > k_most_cells)
    throw file_error(file, "raster too large", fmt::format("at most {} cells", k_most_cells),
                     fmt::format("{} x {}", columns, rows));
  // The heights, their ranges, and the ground.
  constexpr std::uint64_t k_bytes_per_cell = 16;
  check_memory(k_bytes_per_cell * cells, "the heights of the raster");
  const bool is_south_up = transform[5] > 0.0;
  const double north = is_south_up ? transform[3] + transform[5] * rows : transform[3];
  raster.heights = Raster<float>({{transform[0], north}, transform[1], columns, rows}, 0.0f);

  void* const band = GDALGetRasterBand(dataset.get(), 1);
  if (GDALDataTypeIsComplex(GDALGetRasterDataType(band)) != 0)
    throw file_error(file, "the first band of the raster has complex numbers", "heights");
  const AxisUnits units = stated_units(raster.crs);
  const std::optional<LengthUnit> unit = units.heights ? units.heights : unit_of_band(band);
  const bool is_converted = unit && units.plane && *unit != *units.plane;
  const double factor = is_converted ? unit->metres / units.plane->metres : 1.0;
  if (is_converted) {
    raster.crs = with_height_unit(raster.crs, *units.plane);
    raster.heights_note = fmt::format("heights are converted from {} to {}, the unit of x and y", unit->name,
                                      units.plane->name);
  }
  const double scale = factor * GDALGetRasterScale(band, nullptr),
               offset = factor * GDALGetRasterOffset(band, nullptr);
  void* const mask = GDALGetMaskBand(band);
  std::vector<std::uint8_t> is_valid(static_cast<std::size_t>(columns));
  std::vector<double> values(static_cast<std::size_t>(columns));
  for (int row = 0; row < rows; ++row) {
    const auto read = [&](void* from, void* to, GDALDataType type) {
      if (GDALRasterIO(from, GF_Read, 0, row, columns, 1, to, columns, 1, type, 0, 0) != CE_None)
        throw file_error(file,
                         fmt::format("cannot read row {} of the raster: {}", row, CPLGetLastErrorMsg()));
    };
    read(band, values.data(), GDT_Float64);
    read(mask, is_valid.data(), GDT_Byte);
    float* const heights = &raster.heights.at(0, is_south_up ? rows - 1 - row : row);
    for (std::size_t i = 0; i < values.size(); ++i) {
      heights[i] = is_valid[i] != 0 ? static_cast<float>(offset + scale * values[i])
                                    : std::numeric_limits<float>::quiet_NaN();
      // Mostly the lowest float.
      constexpr float k_highest = 1e6f;
      if (std::isfinite(heights[i]) && std::fabs(heights[i]) > k_highest) {
        throw file_error(file, "the raster has a height beyond 1e6",
                         "a declared no-data value: gdal_edit.py -a_nodata VALUE",
                         fmt::format("{:g}", values[i]));
      }
    }
    constexpr int k_rows_per_report = 256;
    if (row % k_rows_per_report == 0)
      report(progress, static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(columns), cells);
  }
  report(progress, cells, cells);
  return raster;
}

}  // namespace alidade::geo
