// SPDX-License-Identifier: MIT
#include "octree/cloud/copc/copc_hierarchy.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "octree/cloud/byte_order.h"
#include "octree/error.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_entry_size = 32;
constexpr std::int32_t k_page_entry = -1;  // the point count of an entry that points to another page

struct Page {
  std::uint64_t place, size;
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
      for (std::uint64_t i = 0; i < page.size / k_entry_size; ++i) read_entry(page.place + i * k_entry_size);
    }
    return std::move(nodes_);
  }

 private:
  [[noreturn]] void fail(std::uint64_t byte, std::string problem, std::string expected,
                         std::string found) const {
    throw Error({.file = file_.name(),
                 .place = fmt::format("byte {}", byte),
                 .problem = std::move(problem),
                 .expected = std::move(expected),
                 .found = std::move(found)});
  }

  /// Checks a page that the bytes at `from` point to; it is read later.
  void announce(const Page& page, std::uint64_t from) {
    const std::string said = from == 0 ? "the COPC record" : fmt::format("byte {}", from);
    const bool inside = page.place <= file_.size() && page.size <= file_.size() - page.place;
    if (!inside || page.size == 0 || page.size % k_entry_size != 0) {
      fail(page.place, fmt::format("bad page of the COPC hierarchy, which {} points to", said),
           fmt::format("a multiple of {} bytes inside the file", k_entry_size), std::to_string(page.size));
    }
    // Pages that overlap could be read for ever.
    bytes_ += page.size;
    if (!places_.insert(page.place).second || bytes_ > file_.size()) {
      fail(page.place, fmt::format("a page of the COPC hierarchy is met twice, from {} again", said), "", "");
    }
    pages_.push_back(page);
  }

  void read_entry(std::uint64_t place) {
    const std::byte* const at = file_.view(place, k_entry_size).data();
    const CopcKey key{load<std::int32_t>(at), load<std::int32_t>(at + 4), load<std::int32_t>(at + 8),
                      load<std::int32_t>(at + 12)};
    const std::uint64_t target = load<std::uint64_t>(at + 16);
    const std::int32_t size = load<std::int32_t>(at + 24), count = load<std::int32_t>(at + 28);
    const bool level_exists = key.level >= 0 && key.level <= k_deepest_copc_level;
    const std::int64_t end = level_exists ? std::int64_t{1} << key.level : 0;
    const auto on_level = [end](std::int32_t number) { return number >= 0 && number < end; };
    if (!level_exists || !on_level(key.x) || !on_level(key.y) || !on_level(key.z)) {
      fail(place, "bad key in the COPC hierarchy",
           fmt::format("a level from 0 to {} and places on it", k_deepest_copc_level), key.name());
    }
    if (count < k_page_entry) {
      fail(place + 28, fmt::format("bad number of points of COPC node {}", key.name()), "-1 or more",
           std::to_string(count));
    }
    if (count == k_page_entry) {
      announce({target, static_cast<std::uint64_t>(std::max(size, 0))}, place);
      return;
    }
    LazChunk& chunk = nodes_[key];
    if (count == 0) return;
    if (chunk.point_count != 0)
      fail(place, fmt::format("the COPC hierarchy has two nodes {}", key.name()), "", "");
    chunk = {target, static_cast<std::uint64_t>(std::max(size, 0)), static_cast<std::uint64_t>(count)};
  }

  InputFile& file_;
  std::vector<Page> pages_;  ///< still to be read
  std::set<std::uint64_t> places_;
  std::uint64_t bytes_ = 0;
  std::map<CopcKey, LazChunk> nodes_;
};

void add_missing_ancestors(std::map<CopcKey, LazChunk>& nodes) {
  std::vector<CopcKey> keys;
  for (const auto& [key, chunk] : nodes) keys.push_back(key);
  for (CopcKey key : keys) {
    while (key.level > 0 && nodes.try_emplace(key.parent()).second) key = key.parent();
  }
}

/// Gives every node the rows of its chunk.
void find_rows(const std::string& file_name, std::span<const LazChunk> chunks, std::vector<CopcNode>& nodes) {
  std::vector<CopcNode*> in_file;
  for (CopcNode& node : nodes) {
    if (node.chunk.point_count > 0) in_file.push_back(&node);
  }
  std::ranges::sort(in_file, {}, [](const CopcNode* node) { return node->chunk.place; });
  std::uint64_t row = 0;
  for (std::size_t i = 0; i < in_file.size(); ++i) {
    if (i >= chunks.size() || in_file[i]->chunk != chunks[i]) {
      throw Error({.file = file_name,
                   .place = fmt::format("byte {}", in_file[i]->chunk.place),
                   .problem = fmt::format("the COPC node {} is no chunk of the file", in_file[i]->key.name()),
                   .expected = i < chunks.size()
                                   ? fmt::format("{} points in {} bytes from byte {} on",
                                                 chunks[i].point_count, chunks[i].byte_count, chunks[i].place)
                                   : "no more chunks",
                   .found = fmt::format("{} points in {} bytes", in_file[i]->chunk.point_count,
                                        in_file[i]->chunk.byte_count)});
    }
    in_file[i]->first_row = row;
    row += chunks[i].point_count;
  }
  if (in_file.size() < chunks.size()) {
    throw Error({.file = file_name,
                 .place = fmt::format("byte {}", chunks[in_file.size()].place),
                 .problem = "the COPC hierarchy leaves out a chunk of the file"});
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
  std::map<CopcKey, LazChunk> found = Entries(file).read({info.root_page, info.root_page_size});
  add_missing_ancestors(found);
  CopcHierarchy hierarchy;
  std::map<CopcKey, std::uint32_t> places;
  for (const auto& [key, chunk] : found) {
    const std::uint32_t place = static_cast<std::uint32_t>(hierarchy.nodes.size());
    places.emplace(key, place);
    CopcNode& node = hierarchy.nodes.emplace_back(CopcNode{.key = key, .chunk = chunk, .children = {}});
    node.children.fill(k_no_copc_node);
    if (key.level == 0) continue;
    auto& siblings = hierarchy.nodes[places.at(key.parent())].children;
    *std::ranges::find(siblings, k_no_copc_node) = place;
  }
  find_rows(file.name(), chunks, hierarchy.nodes);
  return hierarchy;
}

}  // namespace alidade
