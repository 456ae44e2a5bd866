// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/huge_memory.h"
#include "base/interval.h"
#include "base/scratch_file.h"
#include "cloud/copc/copc_file.h"
#include "cloud/point_cloud.h"

// The parts of a LAZ file that make it COPC: the order of its points, its chunks and two records. Source:
// COPC 1.0.

namespace alidade {

/// The octree of a file to be written. Its nodes are in the order of their chunks: level by level.
struct CopcPlan {
  struct Node {
    CopcKey key;
    std::uint32_t point_count = 0;
  };

  CopcInfo info;  ///< root_page is still unknown
  std::vector<Node> nodes;
  HugeArray<std::uint32_t> order;  ///< the rows of the points in the order of the chunks

  /// Points of the chunks.
  std::vector<std::uint32_t> counts() const;
};

/// Plans the octree of points on a lattice, and their order in the file. The root is the cube around
/// `extent`, that of all points. A node whose cube has at most `most_points` points that the nodes above it
/// have not taken, and every node of level 14, takes all of these. Other nodes divide their cube into 128
/// cells along each side and take one point of each cell, the middle one along Morton's curve; their children
/// take the others. So the levels 0 to L are a cloud with a spacing of about side / (128 * 2^L), where `side`
/// is that of the root. The result does not depend on the number of threads.
///
/// `positions` are in a scratch file that is mapped into memory; they are overwritten. Memory: that of
/// `scratch`, and 4 B for each point that a node takes from a cell. Disk: 12 to 28 B per point beside the
/// positions. Cost: about 0.2 s of one thread per million points. Errors: more than 2^31 - 1 points; those of
/// ScratchFile.
CopcPlan plan_copc(const Lattice& lattice, const LatticeExtent& extent, std::span<LatticePosition> positions,
                   const ScratchSpace& scratch, std::size_t most_points = 50000);

/// The first record of the file: 160 bytes of data. `times` are the GPS times of the points; if low > high,
/// they have none.
VariableLengthRecord copc_info_record(const CopcInfo& info, const Interval& times);

/// The extended record with the hierarchy, whose first page begins at info.root_page of the plan; sets
/// info.root_page_size. Trees of more than 1024 nodes have a page for each four levels. `chunks` are those of
/// the nodes, in their order.
VariableLengthRecord copc_hierarchy_record(CopcPlan& plan, std::span<const LazChunk> chunks);

}  // namespace alidade
