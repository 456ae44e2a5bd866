// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/bounds.h"
#include "base/progress.h"
#include "cloud/attributes.h"
#include "cloud/crs.h"

namespace alidade::geo {

/// What a catalog states of a cloud file.
struct CatalogFile {
  std::string name;  ///< relative to the catalog, or a URL
  bool is_url = false;
  std::string format;
  std::uint64_t point_count = 0, byte_count = 0;
  AttributeSet attributes;
  Bounds box;              ///< empty without points
  std::size_t system = 0;  ///< of the reference systems of the catalog
  std::string modified;    ///< "2026-05-01T12:00:00Z"; empty of remote files
  std::string date;        ///< of the scan or, if unknown, of the file
};

/// Writes a catalog that read_catalog() (cloud/catalog.h) reads: a collection of STAC items with the
/// extensions pointcloud and projection, a line for each file, with the outline of its box on the globe if
/// its reference system is known. `progress` is in files. Errors: those of OutputFile. Cancelled.
void write_catalog(const std::filesystem::path& path, std::span<const CatalogFile> files,
                   std::span<const Crs> systems, bool overwrite, const Progress& progress);

/// Writes the boxes of files, at least one, as polygons of a GeoPackage. Errors: files in different reference
/// systems; those of write_geopackage().
void write_footprints(const std::filesystem::path& path, std::span<const CatalogFile> files,
                      std::span<const Crs> systems, bool overwrite);

}  // namespace alidade::geo
