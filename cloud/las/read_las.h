// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cloud/las/las_header.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// Point data records one behind the other, and the first of the rows they go to.
struct RecordBlock {
  const std::byte* bytes;
  std::size_t point_size;
  std::size_t count;
  std::size_t first_row;
};

/// How the point data records of a LAS file become columns of a cloud.
class LasColumns {
 public:
  LasColumns(std::string file_name, const LasHeader& header,
             const std::vector<ExtraDimension>& extra_dimensions);

  /// Attributes the records have.
  AttributeSet attributes() const;

  /// What is kept of the records, and where.
  struct Choice {
    AttributeSet kept;
    LatticeShift shift;
    std::vector<std::size_t> extra_columns;
  };

  /// Those of the `wanted` attributes that are there; makes the columns of extra dimensions in `cloud`.
  /// Errors: the lattices of cloud and file are incompatible.
  Choice choose(AttributeSet wanted, PointCloud& cloud) const;

  /// Puts records into rows that exist. Different rows may be filled by different threads. Errors: a position
  /// that the cloud's lattice does not reach.
  void take(const RecordBlock& block, const Choice& choice, PointCloud& cloud) const;

 private:
  struct PlacedDimension {
    ExtraDimension description;
    int offset;  ///< byte within a point
  };

  void take_attributes(const RecordBlock& block, AttributeSet kept, PointCloud& cloud) const;

  std::string file_name_;
  Lattice lattice_;
  LasPointLayout layout_;
  std::vector<PlacedDimension> extra_dimensions_;
  std::optional<int> normal_offset_;
};

}  // namespace alidade
