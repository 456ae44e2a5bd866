// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"

// The section of an index file with everything that has no fixed size: coordinate reference system, files,
// warnings, extra dimensions, LAS records. docs/index_file.md has it byte by byte.

namespace alidade {

/// What a cloud says about itself beside its points, as bytes of the metadata section.
std::vector<std::byte> encode_index_metadata(const PointCloud& cloud);

/// What the section says.
struct IndexMetadata {
  /// CRS, files, warnings and extra dimensions without their values; records without their data.
  PointCloud cloud;
  std::vector<std::uint64_t> record_bytes;  ///< size of each record's data in the section of record data
};

/// Reads the section. Errors: it ends early, goes on behind its end, or has a value that cannot be; they name
/// the byte of the file, in which the section begins at `place`. Memory: a constant factor of its size.
IndexMetadata read_index_metadata(std::span<const std::byte> section, std::uint64_t place,
                                  const std::string& file_name);

}  // namespace alidade
