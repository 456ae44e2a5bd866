// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "base/bytes.h"
#include "base/remote_map.h"
#include "database/point_stream.h"
#include "database/sqlite/file_chunks.h"
#include "octree/index_file/index_file.h"
#include "octree/tree_walk.h"

namespace alidade::database {
namespace {

/// The union of child_bounds() of all leaves of a node, at the cost of one; empty if it has none.
Bounds leaf_bounds(const TreeView& tree, const Frame& frame) {
  SlotBox all;
  all.low.fill(std::numeric_limits<std::int64_t>::max());
  all.high.fill(std::numeric_limits<std::int64_t>::min());
  bool has_leaves = false;
  for (int slot = 0; slot < k_node_width; ++slot) {
    if (!is_leaf(tree.nodes[frame.node].kind[slot])) continue;
    const SlotBox box = slot_box(tree, frame, slot);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.low[axis] = std::min(all.low[axis], box.low[axis]);
      all.high[axis] = std::max(all.high[axis], box.high[axis]);
    }
    has_leaves = true;
  }
  Bounds bounds;
  const auto world = [&](int axis, std::int64_t steps) {
    return tree.lattice.offset[axis] +
           tree.lattice.scale[axis] * static_cast<double>(tree.base[axis] + steps);
  };
  for (int axis = 0; has_leaves && axis < 3; ++axis) {
    bounds.min[axis] = world(axis, all.low[static_cast<std::size_t>(axis)]);
    bounds.max[axis] = world(axis, all.high[static_cast<std::size_t>(axis)]);
  }
  return bounds;
}

class OctreeChunks final : public ChunkSource {
 public:
  explicit OctreeChunks(IndexedCloud cloud)
      : cloud_(std::move(cloud)),
        blobs_(value_blobs(cloud_.columns())),
        colors_(cloud_.columns().colors),
        tree_(cloud_.octree.view()) {
    note_frames();
  }

  std::uint64_t chunk_count() const { return chunk_count_; }

  std::vector<ChunkLocation> chunks(const PointFilter& filter, std::optional<std::uint64_t> only) override {
    std::vector<ChunkLocation> found;
    const auto take = [&](std::uint32_t number) {
      const Bounds box = leaf_bounds(tree_, frames_[number]);
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
      // In reverse, so that the first child is taken from the stack first.
      const Node& node = tree_.nodes[number];
      const unsigned slots = inner_slots(node);
      std::uint32_t child = node.first_child + static_cast<std::uint32_t>(std::popcount(slots));
      for (int slot = k_node_width - 1; slot >= 0; --slot) {
        if ((slots >> slot & 1u) == 0) continue;
        --child;
        if (may_hold(filter, child_bounds(tree_, frames_[number], slot))) stack.push_back(child);
      }
    }
    check_arrived();
    return found;
  }

  std::shared_ptr<StoredChunk> read(const ChunkLocation& location) override {
    const Frame& frame = frames_[static_cast<std::size_t>(location.id)];
    const Node& node = tree_.nodes[frame.node];
    auto chunk = std::make_shared<StoredChunk>();
    chunk->id = location.id;
    chunk->blobs.resize(k_made_blobs);
    chunk->positions.reserve(leaf_counts(node).sum());
    Leaf leaf{.first = node.first_point, .corner = frame.corner};
    for (const std::uint8_t kind : node.kind) {
      if (!is_leaf(kind)) continue;
      leaf.count = kind;
      for (std::uint32_t i = 0; i < leaf.count; ++i) chunk->positions.push_back(position_of(tree_, leaf, i));
      leaf.first += leaf.count;
    }
    check_arrived();
    return chunk;
  }

  const std::byte* bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) override {
    const std::uint32_t first = tree_.nodes[chunk.id].first_point;
    if (column.blob > 0) {
      const std::uint64_t id = point_id(tree_, first + static_cast<std::uint32_t>(row));
      const ValueBlob& blob = blobs_[static_cast<std::size_t>(column.blob - 1)];
      if (blob.is(Attribute::color) && !colors_.shallow().empty())
        return color_bytes(chunk, id, row) + static_cast<std::size_t>(column.byte);
      const std::byte* const value = blob.values + static_cast<std::size_t>(id) * blob.size;
      RemoteMap::touch({value, blob.size});
      check_arrived();
      return value + static_cast<std::size_t>(column.byte);
    }
    if (!chunk.blobs.front()) {
      std::vector<std::byte>& ids =
          chunk.blobs.front().emplace(chunk.positions.size() * sizeof(std::uint64_t));
      for (std::size_t i = 0; i < chunk.positions.size(); ++i) {
        const std::uint64_t id = point_id(tree_, first + static_cast<std::uint32_t>(i));
        std::memcpy(ids.data() + i * sizeof id, &id, sizeof id);
      }
    }
    check_arrived();
    return chunk.blobs.front()->data() + row * sizeof(std::uint64_t);
  }

 private:
  /// The blobs that the octree does not hold in the form that SQL needs: ids, and colours of 8 bits.
  static constexpr std::size_t k_made_blobs = 2;

  /// The colour of a point of the chunk as Color16.
  const std::byte* color_bytes(StoredChunk& chunk, std::uint64_t id, std::size_t row) const {
    std::optional<std::vector<std::byte>>& colors = chunk.blobs.back();
    if (!colors) colors.emplace(chunk.positions.size() * sizeof(Color16));
    const ColorColumn one = colors_.subspan(static_cast<std::size_t>(id), 1);
    RemoteMap::touch(std::as_bytes(one.shallow()));
    check_arrived();
    std::byte* const made = colors->data() + row * sizeof(Color16);
    store(made, one[0]);
    return made;
  }

  /// Errors: a part of a remote index file could not be fetched.
  void check_arrived() const { RemoteMap::check(tree_.coordinates); }

  /// Computes the frames of all nodes; children come after their parents.
  void note_frames() {
    if (tree_.node_count == 0) return;
    frames_.resize(tree_.node_count);
    frames_[0] = root_frame(tree_);
    for (std::uint32_t number = 0; number < tree_.node_count; ++number) {
      const Node& node = tree_.nodes[number];
      for (unsigned slots = inner_slots(node); slots != 0; slots &= slots - 1) {
        const Frame child = child_frame(tree_, frames_[number], std::countr_zero(slots));
        frames_[child.node] = child;
      }
      if (leaf_counts(node).sum() > 0) ++chunk_count_;
    }
  }

  IndexedCloud cloud_;
  std::vector<ValueBlob> blobs_;
  ColorColumn colors_;
  const TreeView& tree_;
  std::vector<Frame> frames_;  ///< of the nodes, by their numbers
  std::uint64_t chunk_count_ = 0;
};

}  // namespace

FileChunks octree_chunks(const CloudInputs& inputs, const ReadOptions& reading) {
  IndexedCloud cloud = load_indexed_cloud(inputs, {.read = reading});
  const AttributeColumns columns = cloud.columns();
  std::vector<ExtraDimension> dimensions;
  for (const ExtraColumn& column : columns.extra_dimensions) dimensions.push_back(column.description);
  FileChunks chunks{.warnings = std::move(cloud.cloud.warnings)};
  chunks.schema.lattice = cloud.octree.lattice();
  chunks.schema.point_count = cloud.octree.size();
  chunks.schema.columns = stored_columns(columns.attributes(), std::move(dimensions));
  auto source = std::make_unique<OctreeChunks>(std::move(cloud));
  chunks.schema.chunk_count = source->chunk_count();
  chunks.source = std::move(source);
  return chunks;
}

}  // namespace alidade::database
