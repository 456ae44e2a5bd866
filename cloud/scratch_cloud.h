// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/scratch_checkpoint.h"
#include "base/scratch_file.h"
#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"

namespace alidade {

/// A cloud that may be larger than memory: positions and attribute columns are in scratch files, which are
/// mapped into memory.
class ScratchCloud {
 public:
  /// Reads a cloud with the points, rows, values and warnings of read_cloud(). Memory: that of `scratch`, and
  /// some 64 MB for LAZ (CloudReader::read()). Disk: 12 B per point for positions, and the size of
  /// the attributes (PointCloud). With a checkpoint, which must outlive the object, the scratch files are
  /// those of the checkpoint, and its rows are not read again from LAS, LAZ and index files without a
  /// selection; other files are read again. Errors: as read_cloud(); those of scratch files.
  ScratchCloud(const CloudInputs& inputs, const ReadOptions& options, const ScratchSpace& scratch,
               ScratchCheckpoint* checkpoint = nullptr);

  std::size_t size() const { return static_cast<std::size_t>(size_); }
  /// The folder of the scratch files.
  const std::filesystem::path& folder() const { return folder_; }
  /// Lattice, reference system, records, files, warnings, and extra dimensions without their values; no
  /// points.
  const PointCloud& facts() const { return facts_; }
  /// Positions by row. They may be changed, except with a checkpoint, which makes them read-only memory.
  std::span<LatticePosition> positions();
  /// Attribute columns by row; valid as long as the object.
  AttributeColumns columns();
  /// Attribute columns and positions.
  PointColumns points() { return {facts_.lattice, positions(), columns()}; }
  /// One column by row, which may be changed as positions() may; empty if the cloud does not have it. Value
  /// is the type of the column in PointCloud.
  template <class Value>
  std::span<Value> column_of(Attribute attribute) {
    const std::span<std::byte> bytes = bytes_of(number_of(attribute));
    return {reinterpret_cast<Value*>(bytes.data()), bytes.size() / sizeof(Value)};
  }
  /// Some rows in memory, with the columns that the cloud has.
  PointCloud rows(std::size_t first, std::size_t count);

  /// keep_rows() of cloud/rows.h. Spans of the cloud become invalid. Disk: one column of the kept rows.
  /// Requires no checkpoint. Errors: those of scratch files; after cancellation, the cloud must not be used
  /// any more. `progress` is in points.
  void keep_rows(std::span<const std::uint8_t> marks, const Progress& progress = {});
  /// Adds a column of normals, all zero, if the cloud does not have it. Requires no checkpoint. Errors: those
  /// of scratch files.
  void add_normals();

 private:
  void take(PointCloud& piece);
  bool recall(PointCloud& piece, std::size_t first, std::size_t count);
  void add(std::size_t number, std::size_t value_bytes, std::span<const std::byte> values, std::size_t known);
  template <class Value>
  void spread_values(Attribute attribute, const std::function<void(std::span<Value>, std::uint64_t)>& spread);
  void keep();
  static std::size_t number_of(Attribute attribute) {
    return static_cast<std::size_t>(std::countr_zero(static_cast<std::uint32_t>(attribute)));
  }
  std::span<std::byte> bytes_of(std::size_t number);

  struct Column {
    std::size_t value_bytes = 0;  ///< per point; 0: the cloud does not have it
    ScratchFile file;
  };
  [[noreturn]] void fail_as_corrupt(const std::string& name, std::uint64_t bytes) const;
  ScratchFile file(const std::string& name, std::size_t value_bytes) const;
  Column& column(std::size_t number, std::size_t value_bytes);

  std::filesystem::path folder_;
  ScratchCheckpoint* checkpoint_;
  std::uint64_t size_ = 0;
  std::uint64_t recalled_;  ///< rows of an earlier run
  ScratchFile positions_;
  /// By the number of the attribute's bit; extra dimensions follow from the number of their bit on.
  std::vector<Column> columns_;
  PointCloud facts_;
};

/// keep_every() of cloud/rows.h, by ScratchCloud::keep_rows().
void keep_every(ScratchCloud& cloud, std::uint64_t step, const Progress& progress = {});

}  // namespace alidade
