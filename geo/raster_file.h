// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/output_file.h"
#include "base/progress.h"
#include "cloud/crs.h"
#include "geo/raster.h"

namespace alidade::geo {

/// One number for every cell, row after row from the north.
struct RasterBand {
  std::variant<std::span<const std::uint8_t>, std::span<const std::uint16_t>, std::span<const std::uint32_t>,
               std::span<const float>>
      values;
  std::optional<double> no_data{};  ///< the value of cells that have none
  std::string description{}, unit{};
};

/// A map to write. The values belong to the caller.
struct RasterContents {
  RasterGrid grid;
  std::vector<RasterBand> bands;  ///< at least one, all of one type, as many values each as cells
  Crs crs;
  std::vector<std::pair<std::string, std::string>> metadata{};  ///< key and text; a key has no '=' or ':'
};

/// Writes a cloud-optimised GeoTIFF: tiles of 512 cells, compressed without loss, with overviews (nearest
/// cell of whole numbers, mean of float ones) where it is larger than a tile. A reference system that GDAL
/// does not support is left out. The file appears completely or not at all; equal contents give equal bytes
/// with one version of GDAL. Errors: those of check_raster_name(); an existing file without `overwrite`;
/// bands of several types, or with another number of values; a full disk and other write failures. Memory:
/// the encoded file, overviews included.
void write_raster(const std::filesystem::path& file, const RasterContents& contents, bool overwrite);

/// Heights of an elevation raster: of the ground, or of the surface with buildings and trees.
struct HeightRaster {
  Raster<float> heights;       ///< NaN where the file has no data
  Crs crs;                     ///< WKT; empty if the file has none
  std::string heights_note{};  ///< for messages, how heights were converted; empty: they were not
};

/// Whether GDAL reads the file as a raster. Not for text of x, y and z, which is a cloud, and for missing
/// files.
bool is_raster(const std::filesystem::path& file);

/// Reads the first band of a raster in any format of GDAL, with its scale and offset. Heights in another unit
/// than x and y, by the system's vertical part or else the unit of the band, are converted to it. Rows come
/// back from the north. `progress` is in cells. Errors: not a raster; no band of numbers; no georeference;
/// rotated or sheared; cells that are not square (to a thousandth of a cell over the raster); more than
/// k_most_cells cells, or more than the memory holds; geographic coordinates; a finite height beyond 1e6, a
/// no-data value that the file does not declare; damaged data. Cost: that of GDAL's reading. Memory: 4 B per
/// cell, checked with that of a terrain.
HeightRaster read_heights(const std::filesystem::path& file, const Progress& progress = {});

/// An image on the ground, but for its pixels.
struct GroundImage {
  int width = 0, height = 0;
  /// World x = [0] + [1] column + [2] row, y = [3] + [4] column + [5] row, with (0, 0) the outer corner of
  /// the first pixel.
  std::array<double, 6> transform{};
  Crs crs;
  std::vector<std::pair<std::string, std::string>> texts;  ///< metadata: key and text
};

/// Fills rows of red, green, blue and alpha, from `first_row` on.
using FillRows = std::function<void(int first_row, int rows, std::span<std::uint8_t> rgba)>;

/// Red, green, blue and alpha with 8 bits, as write_raster() writes rasters; the pixels of overviews are
/// means. Equal pixels give equal bytes. `name` is the file's in messages. Memory: the file, encoded twice.
void write_geotiff(const std::filesystem::path& name, const GroundImage& image, const FillRows& fill,
                   OutputFile& file);

}  // namespace alidade::geo
