// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "cloud/las/las_records.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/laz_points.h"

namespace alidade::test {

/// Keeps the records as they are.
class RecordSink final : public LazSink {
 public:
  explicit RecordSink(std::size_t record_size) : record_size_(record_size) {}

  void make_room(std::uint64_t count) override {
    records.resize(records.size() + static_cast<std::size_t>(count) * record_size_);
  }
  void take(const std::byte* some, std::size_t count, std::uint64_t first_row) override {
    if ((first_row + count) * record_size_ > records.size()) throw std::logic_error("no room was made");
    std::copy(some, some + count * record_size_,
              records.begin() + static_cast<std::ptrdiff_t>(first_row * record_size_));
  }

  std::vector<std::byte> records;

 private:
  std::size_t record_size_;
};

struct ReadLaz {
  LasHeader header;
  std::vector<std::byte> records;  ///< as in a LAS file
  std::vector<LostPoints> lost;
  std::vector<std::string> warnings;
};

/// The point data records of a LAZ file.
inline ReadLaz read_laz(InputFile file, Damage damage = Damage::reject, const LazLayers& wanted = {},
                        const Progress& progress = {}) {
  ReadLaz read;
  read.header = read_las_header(file, read.warnings, damage);
  const LasRecords records = read_las_records(file, read.header, read.warnings, damage);
  const LazLayout layout =
      parse_laszip_record(records.laszip.value().data, file.name(), records.laszip->offset,
                          read.header.point_format, read.header.point_size);
  LazPoints points(file, read.header, layout, damage);
  RecordSink sink(read.header.point_size);
  read.lost = points.read(wanted, sink, progress);
  read.warnings.insert(read.warnings.end(), points.warnings().begin(), points.warnings().end());
  read.records = std::move(sink.records);
  return read;
}

inline ReadLaz read_laz(std::span<const std::byte> bytes, Damage damage = Damage::reject,
                        const LazLayers& wanted = {}) {
  return read_laz(InputFile(bytes, "memory"), damage, wanted);
}

}  // namespace alidade::test
