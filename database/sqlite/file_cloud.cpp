// SPDX-License-Identifier: MIT
#include "database/sqlite/file_cloud.h"

#include <sys/stat.h>
#include <algorithm>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"

namespace alidade::database {
namespace {

/// Box of the points in the leaves of a node, or around it; empty if it has none.
Bounds leaf_bounds(const TreeView& tree, const Frame& frame) {
  Bounds box;
  for (int slot = 0; slot < k_node_width; ++slot) {
    if (is_leaf(tree.nodes[frame.node].kind[slot])) box.grow(child_bounds(tree, frame, slot));
  }
  return box;
}

}  // namespace

FileCloud::FileCloud(std::span<const std::filesystem::path> names, const ReadOptions& reading) {
  const CloudInputs inputs = resolve_clouds(names, index_and_file_formats());
  files_ = states_of(inputs);
  cloud_ = load_indexed_cloud(inputs, {.read = reading});
  check_unchanged();
  columns_ = cloud_.columns();
  blobs_ = value_blobs(columns_);
  std::vector<ExtraDimension> dimensions;
  for (const ExtraColumn& column : columns_.extra_dimensions) dimensions.push_back(column.description);
  schema_.lattice = cloud_.octree.lattice();
  schema_.point_count = cloud_.octree.size();
  schema_.columns = stored_columns(columns_.attributes(), std::move(dimensions));
  note_frames();
}

std::vector<FileCloud::FileState> FileCloud::states_of(const CloudInputs& inputs) {
  std::vector<FileState> states;
  for (const CloudInput& input : inputs.inputs) {
    struct stat status {};
    // What is missing has the state of no file.
    if (is_remote_name(input.name.string()) || ::stat(input.name.c_str(), &status) != 0) {
      states.push_back({.name = input.name});
      continue;
    }
    states.push_back({.name = input.name,
                      .device = status.st_dev,
                      .number = status.st_ino,
                      .size = static_cast<std::uint64_t>(status.st_size),
                      .seconds = status.st_mtim.tv_sec,
                      .nanoseconds = status.st_mtim.tv_nsec});
  }
  return states;
}

void FileCloud::check_unchanged() const {
  CloudInputs inputs;
  for (const FileState& file : files_) inputs.inputs.push_back({.name = file.name});
  const std::vector<FileState> now = states_of(inputs);
  for (std::size_t i = 0; i < files_.size(); ++i) {
    if (now[i] == files_[i]) continue;
    throw file_error(files_[i].name.string(),
                     now[i].number == 0 ? "the file was removed since it was opened"
                                        : "the file has changed since it was opened",
                     "the file as it was; open it again (drop the table and create it anew)");
  }
}

/// Children come after their parents.
void FileCloud::note_frames() {
  const TreeView& tree = cloud_.octree.view();
  if (tree.node_count == 0) return;
  frames_.resize(tree.node_count);
  frames_[0] = root_frame(tree);
  for (std::uint32_t number = 0; number < tree.node_count; ++number) {
    const Node& node = tree.nodes[number];
    for (unsigned slots = inner_slots(node); slots != 0; slots &= slots - 1) {
      const Frame child = child_frame(tree, frames_[number], std::countr_zero(slots));
      frames_[child.node] = child;
    }
    if (leaf_counts(node).sum() > 0) ++schema_.chunk_count;
  }
}

std::vector<ChunkLocation> FileCloud::chunks(const PointFilter& filter, std::optional<std::uint64_t> only) {
  const TreeView& tree = cloud_.octree.view();
  std::vector<ChunkLocation> found;
  const auto take = [&](std::uint32_t number) {
    const Bounds box = leaf_bounds(tree, frames_[number]);
    if (!box.empty() && may_hold(filter, box)) found.push_back({number, box});
  };
  if (only) {
    if (*only < frames_.size()) take(static_cast<std::uint32_t>(*only));
    return found;
  }
  std::vector<std::uint32_t> stack;
  if (!frames_.empty()) stack.push_back(0);
  while (!stack.empty()) {
    const std::uint32_t number = stack.back();
    stack.pop_back();
    take(number);
    // The first child comes off the stack first.
    const Node& node = tree.nodes[number];
    const unsigned slots = inner_slots(node);
    std::uint32_t child = node.first_child + static_cast<std::uint32_t>(std::popcount(slots));
    for (int slot = k_node_width - 1; slot >= 0; --slot) {
      if ((slots >> slot & 1u) == 0) continue;
      --child;
      if (may_hold(filter, child_bounds(tree, frames_[number], slot))) stack.push_back(child);
    }
  }
  return found;
}

std::shared_ptr<StoredChunk> FileCloud::read(const ChunkLocation& location) {
  const TreeView& tree = cloud_.octree.view();
  const Frame& frame = frames_[static_cast<std::size_t>(location.id)];
  const Node& node = tree.nodes[frame.node];
  auto chunk = std::make_shared<StoredChunk>();
  chunk->id = location.id;
  chunk->positions.reserve(leaf_counts(node).sum());
  Leaf leaf{.first = node.first_point, .corner = frame.corner};
  for (const std::uint8_t kind : node.kind) {
    if (!is_leaf(kind)) continue;
    leaf.count = kind;
    for (std::uint32_t i = 0; i < leaf.count; ++i) chunk->positions.push_back(position_of(tree, leaf, i));
    leaf.first += leaf.count;
  }
  return chunk;
}

const std::byte* FileCloud::bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) {
  const TreeView& tree = cloud_.octree.view();
  const std::uint32_t first = tree.nodes[chunk.id].first_point;
  if (column.blob > 0) {
    const std::uint64_t id = point_id(tree, first + static_cast<std::uint32_t>(row));
    const ValueBlob& blob = blobs_[static_cast<std::size_t>(column.blob - 1)];
    return blob.values + static_cast<std::size_t>(id) * blob.size + static_cast<std::size_t>(column.byte);
  }
  if (chunk.blobs.empty()) {
    std::vector<std::byte>& ids = chunk.blobs.emplace_back().emplace();
    ids.resize(chunk.positions.size() * sizeof(std::uint64_t));
    for (std::size_t i = 0; i < chunk.positions.size(); ++i) {
      const std::uint64_t id = point_id(tree, first + static_cast<std::uint32_t>(i));
      std::memcpy(ids.data() + i * sizeof id, &id, sizeof id);
    }
  }
  return chunk.blobs.front()->data() + row * sizeof(std::uint64_t);
}

}  // namespace alidade::database
