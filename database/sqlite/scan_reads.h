// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace alidade {

/// What scans of clouds have read.
struct ScanReads {
  std::uint64_t scans = 0;        ///< a table in a join is scanned once for each row before it
  std::uint64_t chunks = 0;       ///< that the clouds have, summed over the scans
  std::uint64_t chunks_read = 0;  ///< of these
  std::uint64_t points_read = 0;  ///< in these
  std::uint64_t rows_given = 0;   ///< points that SQLite got to see

  ScanReads& operator+=(const ScanReads& other) {
    scans += other.scans;
    chunks += other.chunks;
    chunks_read += other.chunks_read;
    points_read += other.points_read;
    rows_given += other.rows_given;
    return *this;
  }
};

}  // namespace alidade
