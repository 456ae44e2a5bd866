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
  Progress progress;  ///< in points, roughly
};

/// Builds the adaptive octree over a cloud's points, in parallel. The result does not depend on the number of
/// threads. The cloud is only read. Cost: about n log n; 10 million points take a second or two on two cores.
/// Memory: at the peak 12 B per point beside the cloud; the finished octree takes about 11 B per point (23 B
/// when the cloud spans more than 2^21 lattice steps on an axis). At most 2^32 - 1 points; more is an Error.
Octree build(const PointCloud& cloud, const BuildOptions& options = {});

/// The same, but takes the positions out of the cloud (cloud.positions is empty afterwards) and frees them as
/// early as possible: the octree holds every position without loss. Attributes stay in the cloud.
Octree build(PointCloud&& cloud, const BuildOptions& options = {});

}  // namespace alidade
