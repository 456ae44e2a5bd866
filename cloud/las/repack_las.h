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

/// Whether repack_las() accepts a file, by its first bytes: LAS or LAZ, but not COPC, whose records describe
/// the order of its points. False for a file that cannot be read.
bool can_repack(const std::filesystem::path& input);

struct RepackedFile {
  std::uint64_t point_count = 0;
  std::vector<std::string> warnings;  ///< on harmless oddities, one sentence each, naming the file
};

/// Packs a LAS file as LAZ, or unpacks it, by the output's name (is_laz_name()). LasWriter writes LAS 1.4 in
/// the point formats 6 to 8; this function keeps version, header, variable length records, point format,
/// every byte of the point data records, and all bytes between records and points and behind the points, such
/// as extended records and wave packets. Only these differ: the record
/// "laszip encoded" behind the other records, the mark of LAZ in the point format, the number of records, and
/// the offsets of points, extended records and wave packets. LAS that is packed and unpacked again is
/// identical, byte for byte. LAZ is packed again as LasWriter packs it. Behind the points of LAZ without a
/// chunk table, only extended records are kept.
///
/// Errors: those of reading the file; COPC; more extra bytes than k_most_laz_extra_bytes; records too long
/// for offsets of 32 bits; those of OutputFile. Memory: records before the points; of LAZ 64 MB of unpacked
/// points, or its largest chunk packed and unpacked if that is more; that of RecordWriter.
RepackedFile repack_las(const std::filesystem::path& input, const std::filesystem::path& output,
                        const RepackOptions& options = {});

}  // namespace alidade
