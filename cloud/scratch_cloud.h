// SPDX-License-Identifier: MIT
#pragma once

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

/// A cloud that memory need not hold: positions and attribute columns lie in scratch files, which are mapped into
/// memory.
class ScratchCloud {
 public:
  /// Reads what read_cloud() reads: the same points in the same rows with the same values and warnings. Memory: that
  /// of `scratch`, and some 64 MB for LAZ (CloudReader::read_in_pieces()). Space on the disk: 12 B per point for
  /// positions, and what the attributes take (PointCloud). With a checkpoint, which must outlive the object, the files
  /// are its files, and rows that it has are not read again from LAS, LAZ and index files without a selection; other
  /// files are read again. Errors: as read_cloud(); those of scratch files.
  ScratchCloud(const CloudInputs& inputs, const ReadOptions& options, const ScratchSpace& scratch,
               ScratchCheckpoint* checkpoint = nullptr);

  std::size_t size() const { return static_cast<std::size_t>(size_); }
  /// Lattice, reference system, records, files, warnings, and extra dimensions without their values; no points.
  const PointCloud& facts() const { return facts_; }
  /// By row. They may be changed, but with a checkpoint they are read-only memory.
  std::span<LatticePosition> positions();
  /// By row; valid as long as the object.
  AttributeColumns columns();
  /// The same with the positions.
  PointColumns points() { return {facts_.lattice, positions(), columns()}; }
  /// Some rows in memory, with the columns that the cloud has.
  PointCloud rows(std::size_t first, std::size_t count);

 private:
  void take(PointCloud& piece);
  bool recall(PointCloud& piece, std::size_t first, std::size_t count);
  void add(std::size_t number, std::size_t value_bytes, std::span<const std::byte> values, std::size_t known);
  template <class Value>
  void spread_values(Attribute attribute, const std::function<void(std::span<Value>, std::uint64_t)>& spread);
  void keep();
  template <class Value>
  std::span<const Value> values(std::size_t number);

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
  std::vector<Column>
      columns_;  ///< by number of the attribute's bit; extra dimensions from that of theirs on
  PointCloud facts_;
};

}  // namespace alidade
