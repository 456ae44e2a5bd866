// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cloud/copc/copc_file.h"
#include "cloud/read_cloud.h"

namespace alidade {

/// Some nodes of a COPC file.
struct ChosenNodes {
  const CopcFile* file = nullptr;
  std::vector<std::uint32_t> nodes;  ///< places in its hierarchy, none twice
};

/// Reads the points of these nodes, file by file in the order given, node by node: a part of what
/// read_cloud() gives. Of the options, region and partial have no meaning; progress is in points. Chunks are
/// unpacked in parallel (oneTBB); the result does not depend on the number of threads. Errors: files of
/// different lattices; a damaged chunk.
PointCloud read_copc_nodes(std::span<const ChosenNodes> parts, const ReadOptions& options = {});

/// How many points read_copc_nodes() would read.
std::uint64_t point_count(std::span<const ChosenNodes> parts);

}  // namespace alidade
