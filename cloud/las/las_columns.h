// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cloud/las/las_header.h"
#include "cloud/lattice.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// Contiguous point data records, and the first of the rows that they fill.
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

  /// Attributes of the records.
  AttributeSet attributes() const;

  /// Which attributes of the records are kept, and in which columns.
  struct Choice {
    AttributeSet kept;
    LatticeShift shift;
    std::vector<std::size_t> extra_columns;
  };

  /// Chooses those of the `wanted` attributes that the records have; adds the columns of extra dimensions to
  /// `cloud`. Errors: the lattices of cloud and file are incompatible.
  Choice choose(AttributeSet wanted, PointCloud& cloud) const;

  /// Fills existing rows from records. Several threads may fill different rows. Errors: a position that the
  /// cloud's lattice does not reach.
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
