// SPDX-License-Identifier: MIT
#pragma once

#include "octree/cloud/point_cloud.h"
#include "octree/octree.h"
#include "octree/progress.h"
#include "octree/simd/instruction_set.h"

namespace alidade {

struct BuildOptions {
  /// A cell is split until it holds at most this many points. 1 .. 32.
  int leaf_size = 32;
  /// Instruction set of the traversal; answers do not depend on it.
  InstructionSet instruction_set = InstructionSet::best;
  Progress progress{};  ///< in points; asked before sorting, before packing and at the end only
};

/// Builds the adaptive octree over a cloud's points, in parallel. The result does not depend on the number of
/// threads. The cloud is only read. Cost: about n log n; 10 million points take about a second on two cores.
/// Memory: the finished octree takes about 11 B per point (23 B when the cloud spans more than 2^21 lattice
/// steps on an axis); at the peak the build holds about 14 B per point (26 B) beside the cloud. At most 2^32
/// - 2 points; more is an Error.
Octree build(const PointCloud& cloud, const BuildOptions& options = {});

/// The same, but takes the positions out of the cloud (cloud.positions is empty afterwards) and sorts and
/// packs in their memory, so that the build needs next to nothing beside what the cloud took: the octree
/// holds every position without loss. Attributes stay in the cloud.
Octree build(PointCloud&& cloud, const BuildOptions& options = {});

/// The same, for a caller who does not need the order of the input: brings the rows of all attribute columns
/// into the order of the octree, so that point id = row again and no ids are stored: about 7 B per point. As
/// with a cloud that is given away, cloud.positions is empty afterwards; positions_in_order() gives them
/// back. Memory: ids and one attribute column at a time beside what the octree takes.
Octree build_in_stored_order(PointCloud& cloud, const BuildOptions& options = {});

}  // namespace alidade
