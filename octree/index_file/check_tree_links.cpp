// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "octree/index_file/check_tree.h"

namespace alidade {
namespace {

using Array = TreeFault::Array;

/// What find_broken_link() knows of a node when it comes to it.
struct Rank {
  std::uint8_t level = 0;  ///< 0: no parent has named it yet
  std::uint8_t depth = 0;  ///< 1: the root
};

constexpr std::uint64_t k_every_byte = 0x0101010101010101u;

// A node's eight kinds are looked at together: slot by slot, the check would take longer than reading the
// file.

std::uint64_t kinds_of(const Node& node) {
  std::uint64_t kinds;
  std::memcpy(&kinds, node.kind, sizeof kinds);
  return kinds;
}

/// Number of points by slot, a byte each; 0 where no leaf is.
std::uint64_t leaf_counts(std::uint64_t kinds) {
  return kinds & ~((kinds >> 7 & k_every_byte) * 0xff);
}

std::uint64_t sum_of_bytes(std::uint64_t bytes) {
  constexpr std::uint64_t k_even_bytes = 0x00ff00ff00ff00ffu;
  return ((bytes & k_even_bytes) + (bytes >> 8 & k_even_bytes)) * 0x0001000100010001u >> 48;
}

/// Gives the inner children of a node their ranks. What is wrong; empty if nothing.
std::string rank_children(const TreeView& tree, std::uint32_t index, std::vector<Rank>& ranks) {
  const Node& node = tree.nodes[index];
  const Rank rank = ranks[index];
  std::uint64_t child = node.first_child;
  for (std::uint64_t inner = kinds_of(node) & (k_every_byte << 7); inner != 0; inner &= inner - 1) {
    const int drop = node.kind[std::countr_zero(inner) / 8] - k_inner_kind;
    if (child <= index || child >= tree.node_count)
      return fmt::format("its child should be a node behind it, below {}, but is {}", tree.node_count, child);
    if (ranks[child].level != 0) return fmt::format("its child {} is that of another node too", child);
    if (drop > k_max_level_drop || rank.level - drop < k_min_frame_level)
      return fmt::format("its child {} lies {} levels below level {}", child, drop, rank.level);
    if (rank.depth == tree.level_count) return fmt::format("it should have no child on level {}", rank.depth);
    ranks[child++] = {static_cast<std::uint8_t>(rank.level - drop),
                      static_cast<std::uint8_t>(rank.depth + 1)};
  }
  return {};
}

std::string leaf_problem(const TreeView& tree, const Node& node, int level) {
  const std::uint64_t counts = leaf_counts(kinds_of(node));
  // Bytes of at most 127 leave room for the sum: bit 7 says which are too large.
  if (((counts + (127 - k_max_leaf_size) * k_every_byte) & (k_every_byte << 7)) != 0)
    return fmt::format("a leaf has more than {} points", k_max_leaf_size);
  const std::uint64_t begin = node.first_point, end = begin + sum_of_bytes(counts);
  if (end > tree.point_count)
    return fmt::format("its leaves should end at place {} but end at {}", tree.point_count, end);
  const bool has_exact_positions = tree.positions != nullptr && begin >= tree.first_exact;
  if (end > begin && coordinate_shift(level) > 0 && !has_exact_positions)
    return "its leaves lie too high to go without exact positions";
  return {};
}

/// Whether below low frames points stand one after another (octree/node.h): from the last node on, so that
/// children come before parents.
std::optional<TreeFault> find_scattered_points(const TreeView& tree, const std::vector<Rank>& ranks) {
  std::vector<std::uint32_t> ends(tree.node_count);  // past the last place below a node
  for (std::uint32_t index = tree.node_count; index-- > 0;) {
    if (ranks[index].level > k_exact_frame_level) continue;
    const Node& node = tree.nodes[index];
    const std::uint64_t kinds = kinds_of(node);
    std::uint32_t place = node.first_point + static_cast<std::uint32_t>(sum_of_bytes(leaf_counts(kinds)));
    const auto inner = static_cast<std::uint32_t>(std::popcount(kinds & (k_every_byte << 7)));
    for (std::uint32_t child = node.first_child; child < node.first_child + inner; ++child) {
      if (tree.nodes[child].first_point != place) {
        return TreeFault{Array::nodes, child,
                         fmt::format("its points should begin at place {} but begin at {}", place,
                                     tree.nodes[child].first_point)};
      }
      place = ends[child];
    }
    ends[index] = place;
  }
  return std::nullopt;
}

}  // namespace

std::optional<TreeFault> find_broken_link(const TreeView& tree) {
  if (tree.node_count == 0) return std::nullopt;
  std::vector<Rank> ranks(tree.node_count);
  ranks[0] = {static_cast<std::uint8_t>(tree.root_level), 1};
  for (std::uint32_t index = 0; index < tree.node_count; ++index) {
    std::string problem =
        ranks[index].level == 0 ? "no node before it has it as its child" : rank_children(tree, index, ranks);
    if (problem.empty()) problem = leaf_problem(tree, tree.nodes[index], ranks[index].level);
    if (!problem.empty()) return TreeFault{Array::nodes, index, std::move(problem)};
  }
  return find_scattered_points(tree, ranks);
}

std::optional<TreeFault> find_bad_id(const TreeView& tree, std::uint32_t begin, std::uint32_t end) {
  if (tree.ids == nullptr) return std::nullopt;
  std::uint32_t highest = 0;
  for (std::uint32_t place = begin; place < end; ++place) highest = std::max(highest, tree.ids[place]);
  if (begin == end || highest < tree.point_count) return std::nullopt;
  const auto bad = std::find_if(tree.ids + begin, tree.ids + end,
                                [&](std::uint32_t id) { return id >= tree.point_count; });
  return TreeFault{Array::ids, static_cast<std::uint64_t>(bad - tree.ids),
                   fmt::format("the id should be below {} but is {}", tree.point_count, *bad)};
}

}  // namespace alidade
