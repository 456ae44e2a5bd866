// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "base/instruction_set.h"
#include "base/progress.h"
#include "base/scratch_file.h"
#include "cloud/point_cloud.h"
#include "octree/octree.h"

namespace alidade {

struct BuildOptions {
  /// How points are spread over nodes; answers do not depend on it, except where a query requests coarse
  /// levels only.
  /// - adaptive: cells are split until they hold at most leaf_size points; the fastest and smallest.
  /// - fixed: a grid of cells of one size (cell_size). A cell with more than leaf_size points has several
  ///   leaves.
  /// - layered: every node holds up to leaf_size points, taken evenly (in Morton order) from those in its
  ///   cell that no node above it holds; its children hold the rest. So levels 0 .. n of nodes
  ///   (TreeView::level_count) are a thinned cloud, about three to seven times as many points per level, and
  ///   all levels are the cloud. Takes about 2 B per point more.
  Organisation organisation = Organisation::adaptive;
  /// Most points of a leaf. 1 .. 32.
  int leaf_size = 32;
  /// Of fixed: longest side of a cell, world units; cells are the largest octree cells that are not longer,
  /// and not smaller than a lattice step. >= 0 and finite; 0 = the largest cells that hold at most leaf_size
  /// points on average.
  double cell_size = 0.0;
  /// Instruction set of the traversal; answers do not depend on it.
  InstructionSet instruction_set = InstructionSet::best;
  Progress progress{};  ///< in points; called before sorting, before packing and at the end only
};

/// Builds the octree over a cloud's points, in parallel. The result does not depend on the number of threads.
/// The cloud is only read. Cost: linear but for the depth of the tree, whatever the order and distribution of
/// the points; 10 million points take about half a second on two cores.
///
/// Memory: the finished octree takes about 11 B per point. Points whose cells are wider than 2^16 lattice
/// steps, because the cloud is sparse for its lattice, take 12 B more each (TreeView::first_exact). At the
/// peak the build, its result included, takes about 16 B per point beside the cloud; 18 to 28 B if that spans
/// more than 2^21 lattice steps on an axis, the more the sparser it is.
///
/// Errors: leaf_size or cell_size out of range; more than 2^32 - 2 points.
Octree build(const PointCloud& cloud, const BuildOptions& options = {});

/// build() that takes the positions out of the cloud (cloud.positions is empty afterwards) and sorts in their
/// memory, so that it needs little beside what the positions took (2 B per point; 6 to 16 B above 2^21
/// lattice steps): the octree holds every position without loss. Attributes stay in the cloud.
Octree build(PointCloud&& cloud, const BuildOptions& options = {});

/// build() for a caller who does not need the order of the input: brings the rows of all attribute columns
/// into the order of the octree, so that point id = row again and no ids are stored: about 7 B per point. As
/// with a cloud that is given away, cloud.positions is empty afterwards; positions_in_order() gives them
/// back. Memory: ids and one attribute column at a time beside what the octree takes.
Octree build_in_stored_order(PointCloud& cloud, const BuildOptions& options = {});

/// build() for a cloud larger than memory: the same octree. `positions` are those of a scratch file that is
/// mapped into memory, in the order of their ids; their values are lost, but they are not written to. Scratch
/// files also hold the arrays of the octree, what the build needs meanwhile, and what is measured later
/// (Octree::scratch()). Space on the disk: 12 to 32 B per point beside the positions and the octree's 11 to
/// 23 B. Memory: that of `scratch`, and 1 B per point for nodes; the system may keep more of the files in
/// memory while no program needs that memory. Errors: as build(); those of scratch files.
Octree build_in_scratch(const Lattice& lattice, std::span<LatticePosition> positions,
                        const ScratchSpace& scratch, const BuildOptions& options = {});

}  // namespace alidade
