// SPDX-License-Identifier: MIT
#include "cloud/copc/copc_hierarchy.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "base/bytes.h"
#include "cloud/damage.h"

namespace alidade {

CopcInfo parse_copc_info(std::span<const std::byte> data, const std::string& file_name,
                         std::uint64_t offset) {
  const HeaderFields fields(data, file_name, offset);
  constexpr std::size_t k_size = 160;
  fields.require(data.size() == k_size, 0, "wrong size of the COPC record", fmt::format("{} bytes", k_size),
                 data.size());
  CopcInfo info;
  info.half_size = fields.get<double>(24);
  // The cube's side is twice as long and must be a number, too.
  fields.require(std::isfinite(2 * info.half_size) && info.half_size > 0, 24,
                 "invalid size of the COPC octree", "a positive number", info.half_size);
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t byte = 8 * static_cast<std::size_t>(axis);
    info.centre[axis] = fields.get<double>(byte);
    fields.require(std::isfinite(std::abs(info.centre[axis]) + 2 * info.half_size), byte,
                   "invalid centre of the COPC octree", "a finite number", info.centre[axis]);
  }
  info.spacing = fields.get<double>(32);
  fields.require(std::isfinite(info.spacing) && info.spacing > 0, 32, "invalid spacing of the COPC octree",
                 "a positive number", info.spacing);
  info.root_page = fields.get<std::uint64_t>(40);
  info.root_page_size = fields.get<std::uint64_t>(48);
  return info;
}

namespace {

constexpr std::uint64_t k_entry_size = 32;
constexpr std::int32_t k_page_entry = -1;  // the point count of an entry that points to another page

struct Page {
  std::uint64_t offset, size;
};

/// What the pages say, checked on its own.
class Entries {
 public:
  explicit Entries(InputFile& file) : file_(file) {}

  std::map<CopcKey, LazChunk> read(const Page& root) {
    announce(root, 0);
    while (!pages_.empty()) {
      const Page page = pages_.back();
      pages_.pop_back();
      read_page(page);
    }
    return std::move(nodes_);
  }

 private:
  /// Checks a page that the bytes at `from` point to; it is read later.
  void announce(const Page& page, std::uint64_t from) {
    const std::string said = from == 0 ? "the COPC record" : fmt::format("byte {}", from);
    const bool inside = page.offset <= file_.size() && page.size <= file_.size() - page.offset;
    if (!inside || page.size == 0 || page.size % k_entry_size != 0) {
      fail_at_byte(file_.name(), page.offset,
                   fmt::format("invalid page of the COPC hierarchy, referenced by {}", said),
                   fmt::format("a multiple of {} bytes inside the file", k_entry_size),
                   std::to_string(page.size));
    }
    if (!offsets_.insert(page.offset).second) {
      fail_at_byte(file_.name(), page.offset,
                   fmt::format("duplicate page of the COPC hierarchy, referenced again by {}", said),
                   "one reference", "another");
    }
    // Pages that overlap could be many more than the file has room for.
    bytes_ += page.size;
    if (bytes_ > file_.size()) {
      fail_at_byte(file_.name(), page.offset, "the pages of the COPC hierarchy exceed the file",
                   fmt::format("at most {}", file_.size()), std::to_string(bytes_));
    }
    pages_.push_back(page);
  }

  void read_page(const Page& page) {
    constexpr std::uint64_t k_block_size = 2048 * k_entry_size;
    for (std::uint64_t done = 0; done < page.size; done += block_.size()) {
      block_.resize(static_cast<std::size_t>(std::min(k_block_size, page.size - done)));
      file_.read_at(page.offset + done, block_);
      for (std::size_t at = 0; at < block_.size(); at += k_entry_size)
        read_entry(block_.data() + at, page.offset + done + at);
    }
  }

  void read_entry(const std::byte* at, std::uint64_t offset) {
    const CopcKey key{load<std::int32_t>(at), load<std::int32_t>(at + 4), load<std::int32_t>(at + 8),
                      load<std::int32_t>(at + 12)};
    const std::uint64_t target = load<std::uint64_t>(at + 16);
    const std::int32_t size = load<std::int32_t>(at + 24), count = load<std::int32_t>(at + 28);
    const bool level_exists = key.level >= 0 && key.level <= k_deepest_copc_level;
    const std::int64_t end = level_exists ? std::int64_t{1} << key.level : 0;
    const auto on_level = [end](std::int32_t number) { return number >= 0 && number < end; };
    if (!level_exists || !on_level(key.x) || !on_level(key.y) || !on_level(key.z)) {
      fail_at_byte(file_.name(), offset, "invalid key in the COPC hierarchy",
                   fmt::format("a level from 0 to {} and indices on it", k_deepest_copc_level), key.name());
    }
    if (count < k_page_entry) {
      fail_at_byte(file_.name(), offset + 28,
                   fmt::format("invalid number of points of COPC node {}", key.name()), "-1 or more",
                   std::to_string(count));
    }
    if (count == k_page_entry) {
      announce({target, static_cast<std::uint64_t>(std::max(size, 0))}, offset);
      return;
    }
    LazChunk& chunk = nodes_[key];
    if (count == 0) return;
    if (chunk.point_count != 0) {
      fail_at_byte(file_.name(), offset, fmt::format("duplicate node {} in the COPC hierarchy", key.name()),
                   "one with points", fmt::format("{} and {} points", chunk.point_count, count));
    }
    chunk = {target, static_cast<std::uint64_t>(std::max(size, 0)), static_cast<std::uint64_t>(count)};
  }

  InputFile& file_;
  std::vector<Page> pages_;  ///< still to be read
  std::set<std::uint64_t> offsets_;
  std::uint64_t bytes_ = 0;
  std::vector<std::byte> block_;  ///< of a page
  std::map<CopcKey, LazChunk> nodes_;
};

/// Hangs every node below the smallest cube around it that is a node.
void find_children(CopcHierarchy& hierarchy) {
  std::vector<CopcNode>& nodes = hierarchy.nodes;
  std::vector<std::uint32_t> parents(nodes.size());
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    CopcKey key = nodes[i].key;
    auto parent = nodes.end();
    // The root is a node and around everything.
    do {
      key = key.parent();
      parent = std::ranges::lower_bound(nodes, key, {}, &CopcNode::key);
    } while (parent->key != key);
    parents[i] = static_cast<std::uint32_t>(parent - nodes.begin());
    ++parent->child_count;
  }
  std::uint32_t end = 0;
  for (CopcNode& node : nodes) {
    node.first_child = end;
    end += std::exchange(node.child_count, 0);
  }
  hierarchy.children.resize(end);
  for (std::uint32_t i = 1; i < nodes.size(); ++i) {
    CopcNode& parent = nodes[parents[i]];
    hierarchy.children[parent.first_child + parent.child_count++] = i;
  }
}

/// Gives every node the rows of its chunk.
void find_rows(const std::string& file_name, std::span<const LazChunk> chunks, std::vector<CopcNode>& nodes) {
  std::vector<CopcNode*> in_file;
  for (CopcNode& node : nodes) {
    if (node.chunk.point_count > 0) in_file.push_back(&node);
  }
  std::ranges::sort(in_file, {}, [](const CopcNode* node) { return node->chunk.offset; });
  std::uint64_t row = 0;
  for (std::size_t i = 0; i < in_file.size(); ++i) {
    if (i >= chunks.size() || in_file[i]->chunk != chunks[i]) {
      const LazChunk& chunk = in_file[i]->chunk;
      fail_at_byte(file_name, chunk.offset,
                   fmt::format("COPC node {} does not match a chunk of the file", in_file[i]->key.name()),
                   i < chunks.size() ? fmt::format("{} points in {} bytes at byte {}", chunks[i].point_count,
                                                   chunks[i].byte_count, chunks[i].offset)
                                     : "no further chunk",
                   fmt::format("{} points in {} bytes", chunk.point_count, chunk.byte_count));
    }
    in_file[i]->first_row = row;
    row += chunks[i].point_count;
  }
  if (in_file.size() < chunks.size()) {
    fail_at_byte(file_name, chunks[in_file.size()].offset,
                 "the COPC hierarchy does not reference a chunk of the file",
                 fmt::format("{} nodes with points", chunks.size()), std::to_string(in_file.size()));
  }
}

}  // namespace

std::string CopcKey::name() const {
  return fmt::format("{}-{}-{}-{}", level, x, y, z);
}

Bounds copc_cube(const CopcInfo& info, const CopcKey& key) {
  const double side = 2 * info.half_size / static_cast<double>(std::int64_t{1} << key.level);
  const glm::dvec3 min = info.centre - info.half_size + side * glm::dvec3(key.x, key.y, key.z);
  return {min, min + side};
}

CopcHierarchy read_copc_hierarchy(InputFile& file, const CopcInfo& info, std::span<const LazChunk> chunks) {
  CopcHierarchy hierarchy;
  {
    std::map<CopcKey, LazChunk> found = Entries(file).read({info.root_page, info.root_page_size});
    found.try_emplace(CopcKey{});
    hierarchy.nodes.reserve(found.size());
    for (const auto& [key, chunk] : found) hierarchy.nodes.push_back({.key = key, .chunk = chunk});
  }
  find_children(hierarchy);
  find_rows(file.name(), chunks, hierarchy.nodes);
  return hierarchy;
}

}  // namespace alidade
