// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "base/progress.h"
#include "base/scratch_file.h"
#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"

namespace alidade {

/// A cloud that may be larger than memory: an extension holds its columns, which are mapped into memory.
/// Spans become invalid when rows are removed or normals added.
class LargeCloud {
 public:
  virtual ~LargeCloud() = default;

  /// Where it lies, and what is built over it is to lie.
  virtual const ScratchSpace& scratch() const = 0;
  /// Lattice, reference system, records, files, warnings, and extra dimensions without their values; no
  /// points.
  virtual const PointCloud& facts() const = 0;
  /// Positions by row, which may be changed unless a checkpoint keeps them.
  virtual std::span<LatticePosition> positions() = 0;
  /// Attribute columns by row.
  virtual AttributeColumns columns() = 0;
  /// Attribute columns and positions.
  PointColumns points() { return {facts().lattice, positions(), columns()}; }
  /// Some rows in memory, with the columns that the cloud has.
  virtual PointCloud rows(std::size_t first, std::size_t count) = 0;

  /// keep_every() of cloud/rows.h, thin() of cloud/select_points.h, and a column of normals, all zero, if the
  /// cloud does not have it. After cancellation, the cloud must not be used any more.
  virtual void keep_every(std::uint64_t step, const Progress& progress) = 0;
  virtual void thin(double edge, const Progress& progress) = 0;
  virtual std::span<glm::vec3> add_normals() = 0;

  /// Removes the checkpoint, as the output is written. The cloud must not be used any more.
  virtual void finish() {}
};

/// read_cloud() into such a cloud, with the same points, rows, values and warnings.
using ReadLargeCloud = std::unique_ptr<LargeCloud> (*)(const CloudInputs& inputs, const ReadOptions& options,
                                                       const ScratchSpace& scratch);

}  // namespace alidade
