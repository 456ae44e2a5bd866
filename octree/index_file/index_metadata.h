// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade {

// The section of an index file with everything that has no fixed size: coordinate reference system, files,
// warnings, extra dimensions, LAS records. docs/index_file.md has it byte by byte.

/// The metadata section of a cloud: what describes it beside its points.
std::vector<std::byte> encode_index_metadata(const PointCloud& cloud);

/// What the metadata section holds.
struct IndexMetadata {
  /// CRS, files, warnings and extra dimensions without their values; records without their data.
  PointCloud cloud;
  std::vector<std::uint64_t> record_bytes;  ///< size of each record's data in the section of record data
};

/// Reads the metadata section. Errors: truncated; extra bytes; an invalid value. They name the byte of the
/// file, in which the section begins at `offset`. Memory: a constant factor of its size.
IndexMetadata read_index_metadata(std::span<const std::byte> section, std::uint64_t offset,
                                  const std::string& file_name);

}  // namespace alidade
