// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cloud/written_column.h"
#include "jobs/listener.h"
#include "octree/index_file/index_file.h"

namespace alidade::jobs {

/// Points that come in pieces of any size.
struct PointRows {
  const PointCloud& like;  ///< all but the points: lattice, reference system, records, extra dimensions
  AttributeSet attributes;
  std::size_t count;
  PointPieces from;
};

/// Writes points by the extension: PLY, CSV, XYZ, or else LAS 1.4, LAZ or COPC, with warnings. `memory`: of
/// COPC (LasWriteOptions). Errors: as write_ply(), write_text(), LasWriter.
void write_rows(const std::filesystem::path& file, const PointRows& rows, bool overwrite,
                std::optional<std::uint64_t> memory, Listener& listener);

/// The metadata for a copy of a cloud with other columns: lattice, reference system, LAS records and
/// encoding. No points, no columns.
PointCloud description_of(const IndexedCloud& cloud);

/// A column that a job adds to the points of a cloud.
struct ResultColumn {
  ExtraDimension description;  ///< its `values` are empty
  /// Writes the values of the points [first, first + count), little endian and one after another.
  std::function<void(std::size_t first, std::size_t count, std::uint8_t* values)> fill;
};

/// A column of a scalar type whose values are `value(id)`. Requires that the type is that of Value.
template <class Value, class Of>
ResultColumn result_column(std::string name, std::string description, ScalarType type, Of value) {
  ResultColumn column;
  column.description.name = std::move(name);
  column.description.description = std::move(description);
  column.description.type = type;
  column.description.byte_count = scalar_size(type);
  column.fill = [value = std::move(value)](std::size_t first, std::size_t count, std::uint8_t* values) {
    for (std::size_t i = 0; i < count; ++i) {
      const Value number = value(first + i);
      std::memcpy(values + i * sizeof(Value), &number, sizeof(Value));
    }
  };
  return column;
}

/// A cloud and the columns that are added to it.
struct CloudResults {
  const IndexedCloud& cloud;
  std::vector<ResultColumn> results;
  std::span<const Color16> colors{};  ///< by point id, instead of the cloud's; empty: the cloud's
};

/// Errors: the name does not end in .las, .laz or .ply.
void check_points_name(const std::filesystem::path& file);

/// The points of a cloud in their order, with all their attributes, scale, offset, reference system and LAS
/// records, and with these columns: LAS 1.4 or PLY by the extension. Columns of the cloud with one of their
/// names are replaced, with a warning. Memory: 12 B per point, on the disk if the octree has scratch files;
/// for COPC also `memory` (LasWriteOptions). Errors: as LasWriter, write_ply().
void write_points(const std::filesystem::path& file, const IndexedCloud& cloud,
                  const std::vector<ResultColumn>& results, bool overwrite,
                  std::optional<std::uint64_t> memory, Listener& listener);

/// Writes several clouds, at least one, into one file, one after the other. A column that only some have is 0
/// in the others. Positions are on one lattice (joined_lattice()), which rounds some by half a step at most
/// if it does not hold all of them exactly. Reference system: that of the first cloud that has one; records
/// and encoding: of the first.
void write_points(const std::filesystem::path& file, std::span<const CloudResults> clouds, bool overwrite,
                  std::optional<std::uint64_t> memory, Listener& listener);

}  // namespace alidade::jobs
