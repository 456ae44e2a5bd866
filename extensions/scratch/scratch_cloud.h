// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/scratch_file.h"
#include "cloud/large_cloud.h"
#include "extensions/scratch/kept_file.h"
#include "extensions/scratch/scratch_checkpoint.h"

namespace alidade {

/// A cloud whose positions and attribute columns are in scratch files, which are mapped into memory.
class ScratchCloud : public LargeCloud {
 public:
  /// Reads a cloud with the points, rows, values and warnings of read_cloud(). Memory: that of `scratch`, and
  /// some 64 MB for LAZ (CloudReader::read()). Disk: 12 B per point for positions, and the size of
  /// the attributes (PointCloud). With a checkpoint, which must outlive the object, the scratch files are
  /// those of the checkpoint, and its rows are not read again from LAS, LAZ and index files without a
  /// selection; other files are read again. Errors: as read_cloud(); those of scratch files.
  ScratchCloud(const CloudInputs& inputs, const ReadOptions& options, const ScratchSpace& scratch,
               ScratchCheckpoint* checkpoint = nullptr);

  std::size_t size() const { return static_cast<std::size_t>(size_); }
  const ScratchSpace& scratch() const override { return scratch_; }
  const PointCloud& facts() const override { return facts_; }
  /// With a checkpoint, they are in read-only memory.
  std::span<LatticePosition> positions() override;
  AttributeColumns columns() override;
  /// One column by row, which may be changed as positions() may; empty if the cloud does not have it. Value
  /// is the type of the column in PointCloud.
  template <class Value>
  std::span<Value> column_of(Attribute attribute) {
    const std::span<std::byte> bytes = bytes_of(number_of(attribute));
    return {reinterpret_cast<Value*>(bytes.data()), bytes.size() / sizeof(Value)};
  }
  PointCloud rows(std::size_t first, std::size_t count) override;

  // They require no checkpoint. Disk: one column of the kept rows, and what thin() takes. Errors: those of
  // scratch files. `progress` is in points.
  void keep_every(std::uint64_t step, const Progress& progress) override;
  void thin(double edge, const Progress& progress) override;
  std::span<glm::vec3> add_normals() override;

 protected:
  /// Closes the files; the cloud must not be used any more.
  void close();

 private:
  void keep_rows(std::span<const std::uint8_t> marks, const Progress& progress);
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
    KeptFile file;
  };
  [[noreturn]] void fail_as_corrupt(const std::string& name, std::uint64_t bytes) const;
  KeptFile file(const std::string& name, std::size_t value_bytes) const;
  Column& column(std::size_t number, std::size_t value_bytes);

  ScratchSpace scratch_;
  ScratchCheckpoint* checkpoint_;
  std::uint64_t size_ = 0;
  std::uint64_t recalled_;  ///< rows of an earlier run
  KeptFile positions_;
  /// By the number of the attribute's bit; extra dimensions follow from the number of their bit on.
  std::vector<Column> columns_;
  PointCloud facts_;
};

}  // namespace alidade
