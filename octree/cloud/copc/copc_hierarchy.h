// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "octree/bounds.h"
#include "octree/cloud/copc/copc_info.h"
#include "octree/cloud/input_file.h"
#include "octree/cloud/las_header.h"
#include "octree/cloud/laz/chunk_table.h"
#include "octree/cloud/laz/laz_layout.h"

namespace alidade {

inline constexpr int k_deepest_copc_level = 30;

/// A cube of the octree: level 0 is the root; on level L each axis has 2^L cubes.
struct CopcKey {
  int level = 0;
  std::int32_t x = 0, y = 0, z = 0;

  auto operator<=>(const CopcKey&) const = default;
  CopcKey parent() const { return {level - 1, x >> 1, y >> 1, z >> 1}; }
  /// "2-1-0-3".
  std::string name() const;
};

/// The cube of a key.
Bounds copc_cube(const CopcInfo& info, const CopcKey& key);

inline constexpr std::uint32_t k_no_copc_node = UINT32_MAX;

struct CopcNode {
  CopcKey key;
  LazChunk chunk;               ///< point_count 0: the node has no points of its own
  std::uint64_t first_row = 0;  ///< of its points, in the order of the file
  /// Places of the children in CopcHierarchy::nodes, those that exist, before k_no_copc_node.
  std::array<std::uint32_t, 8> children;
};

/// The octree of a COPC file. Every point of the file belongs to exactly one node.
struct CopcHierarchy {
  std::vector<CopcNode> nodes;  ///< level by level; the root is the first

  int levels() const { return nodes.empty() ? 0 : nodes.back().key.level + 1; }
};

/// Reads all pages of the hierarchy. Ancestors that the file leaves out are added as nodes without points, so
/// that every node is reached from the root. `chunks` are those of the file's chunk table: the nodes must
/// have exactly these, from which follow the rows of their points. Errors: pages or chunks outside the file,
/// pages that are met twice, keys that no octree has, two nodes of one key, nodes that are not the chunks of
/// the file. Memory: in proportion to the pages.
CopcHierarchy read_copc_hierarchy(InputFile& file, const CopcInfo& info, std::span<const LazChunk> chunks);

}  // namespace alidade
