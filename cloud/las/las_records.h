// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/output_file.h"
#include "cloud/las/las_header.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// A record that describes how points are stored.
struct StorageRecord {
  std::uint64_t offset = 0;  ///< of its data in the file
  std::vector<std::byte> data;
};

/// The content of the variable length records of a LAS file.
struct LasRecords {
  Crs crs;  ///< without another WKT, that of a libLAS record, which is also in `others`
  /// Extra dimensions in the order of their bytes; together they cover all extra bytes of a point. Bytes that
  /// are not described, or not by the first 341 entries, are dimensions "undocumented".
  std::vector<ExtraDimension> extra_dimensions;
  std::vector<VariableLengthRecord> others;
  std::optional<StorageRecord> laszip;     ///< "laszip encoded" 22204, of LAZ
  std::optional<StorageRecord> copc_info;  ///< "copc" 1, if it is the first, behind a header of 375 bytes
};

/// Reads the records before and after the points. Records that contradict themselves but do no harm are left
/// out and reported in `warnings`. Records about the storage of points are not in `others`, because a writer
/// of the points makes its own. Errors: a record that does not end before the points; two different laszip
/// records. A record behind the points that does not end before the end of the file is damage;
/// Damage::read_over leaves out this record and those behind it, with a warning. Memory: at most the size of
/// the records in the file.
LasRecords read_las_records(InputFile& file, const LasHeader& header, std::vector<std::string>& warnings,
                            Damage damage = Damage::reject);

/// How the points of a file are packed, by its laszip record. Empty if they are not, even if the header marks
/// them as packed: header.compressed is then reset. Errors: no such record, or one that contradicts itself or
/// the header; missing points that are not packed, which is damage.
std::optional<LazLayout> read_packing(const InputFile& file, LasHeader& header, const LasRecords& records,
                                      Damage damage = Damage::reject);

/// The CRS as LAS records: WKT and GeoTIFF keys, as far as it has them.
std::vector<VariableLengthRecord> las_crs_records(const Crs& crs);

/// Shortens the names of dimensions to the 32 bytes that LAS keeps, with a number at the end where different
/// names would become equal. Returns a clause on those that changed, such as "'long name' becomes 'long_2'";
/// empty if none did.
std::string shorten_names(std::vector<ExtraDimension>& dimensions);

/// The record that describes extra bytes. Requires at least one dimension. Errors: more than 341 dimensions,
/// the most that fit.
VariableLengthRecord las_extra_bytes_record(std::span<const ExtraDimension> dimensions,
                                            const std::string& file_name);

/// The header of a record, short or long.
std::vector<std::byte> las_record_head(const VariableLengthRecord& record, bool extended);

/// Appends a record with the short header (`data` at most 65535 bytes) or the long one.
void write_las_record(OutputFile& file, const VariableLengthRecord& record, bool extended);

inline constexpr std::size_t k_las_record_head = 54;           ///< bytes before the data, if not extended
inline constexpr std::size_t k_las_extended_record_head = 60;  ///< if extended
inline constexpr std::size_t k_longest_las_record = 65535;     ///< data of a record that is not extended
inline constexpr std::size_t k_extra_bytes_entry = 192;        ///< bytes that describe one extra dimension
/// Most extra dimensions that a record can describe.
inline constexpr std::size_t k_most_extra_dimensions = k_longest_las_record / k_extra_bytes_entry;

}  // namespace alidade
