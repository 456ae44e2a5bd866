// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <set>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade {

/// Keeps one copy of the records that the tiles of a survey repeat. Repetitions within one file stay: they
/// stood there. Cost: that of sorting all records.
class JoinedRecords {
 public:
  /// The records must outlive this object, and change only at their end while it lives.
  explicit JoinedRecords(std::vector<VariableLengthRecord>& records)
      : records_(records), earlier_(Order{&records}) {}

  /// Takes out of the records from place `first` on, which one file has added, what an earlier file had.
  void join(std::size_t first);

 private:
  struct Order {
    const std::vector<VariableLengthRecord>* records;
    bool operator()(std::size_t a, std::size_t b) const;
  };

  std::vector<VariableLengthRecord>& records_;
  std::set<std::size_t, Order> earlier_;  ///< places of the records of the files joined so far
};

}  // namespace alidade
