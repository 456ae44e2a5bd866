// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/progress.h"

namespace alidade {

struct RepackOptions {
  bool overwrite = false;  ///< otherwise an existing file is an Error
  Progress progress{};     ///< in bytes of input
};

/// Whether repack_las() takes a file: LAS or LAZ, but not COPC, whose order of points is described by its
/// records. By its first bytes; false for a file that cannot be read.
bool can_repack(const std::filesystem::path& input);

struct RepackedFile {
  std::uint64_t point_count = 0;
  std::vector<std::string> warnings;  ///< oddities that were read over, one sentence each, naming the file
};

/// Packs a LAS file as LAZ or unpacks it, as the output's name says (is_laz_name()). Nothing else changes:
/// version, header, variable length records, point format and every byte of the point data records stay what
/// they are, and what stands between records and points and behind the points does too, extended records and
/// wave packets among them. What has to differ: the record "laszip encoded" behind the other records, the
/// mark of LAZ in the point format, the number of records, and the offsets of points, extended records and
/// wave packets. So LAS packed and unpacked again is the same, byte for byte. LAZ packed again comes out as
/// LasWriter packs. Of LAZ without a chunk table only extended records are kept of what is behind the points.
///
/// Errors: whatever a reader of the file rejects; COPC; more extra bytes than k_most_laz_extra_bytes; records
/// too long for offsets of 32 bits; those of OutputFile. Memory: records before the points;
/// of LAZ 64 MB of unpacked points, or its largest chunk packed and unpacked if that is more;
/// LazPointWriter's.
RepackedFile repack_las(const std::filesystem::path& input, const std::filesystem::path& output,
                        const RepackOptions& options = {});

}  // namespace alidade
