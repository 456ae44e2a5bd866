// SPDX-License-Identifier: MIT
#include "database/file_cloud.h"

#include <sys/stat.h>
#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/input_file.h"
#include "base/parallel.h"
#include "base/recently_used.h"
#include "cloud/input_view.h"
#include "cloud/las/las_columns.h"
#include "cloud/read_in_pieces.h"
#include "octree/copc_tree.h"
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

/// A cloud with its octree: an index file is mapped, and only the requested points and attributes are read;
/// other files are read into memory and indexed. A chunk consists of the leaves of one node, up to 512
/// points; its id is the node's number. Memory: 24 B per node.
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
    std::byte* const made = colors->data() + row * sizeof(Color16);
    store(made, one[0]);
    return made;
  }

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

FileChunks octree_chunks(const CloudInputs& inputs, const ReadOptions& reading) {
  IndexedCloud cloud = load_indexed_cloud(inputs, {.read = reading});
  FileChunks chunks{.warnings = std::move(cloud.cloud.warnings)};
  chunks.schema.lattice = cloud.octree.lattice();
  chunks.schema.point_count = cloud.octree.size();
  chunks.schema.columns = stored_columns(cloud.columns());
  auto source = std::make_unique<OctreeChunks>(std::move(cloud));
  chunks.schema.chunk_count = source->chunk_count();
  chunks.source = std::move(source);
  return chunks;
}

constexpr std::size_t k_chunk_points = BoxedPoints::k_block_points * BoxedPoints::k_fan_out;
constexpr std::size_t k_cache_bytes = std::size_t{512} << 20;
constexpr std::size_t k_attribute_bytes = std::size_t{256} << 20;

/// Upper bound of the memory that CopcCache takes per point.
constexpr std::uint64_t k_bytes_per_point = 20;

/// A COPC file that is not loaded: nodes of its hierarchy are read if a scan may find points in their cubes,
/// attributes of a node when those of one of its points are requested. A chunk is 128 points of a node. A
/// scan that may find points in more nodes than the cache holds tests all points of these. The first
/// statement that uses colours reads those of the nodes until one exceeds 255, which decides about
/// ColorDepth::automatic. `is_given_up` is called after each node; if it returns true, the scan ends with
/// Cancelled. Errors: those of CopcFile; of scans, of CopcCache. Requires a file with points.
class CopcChunks final : public ChunkSource {
 public:
  CopcChunks(const CloudInput& input, std::function<bool()> is_given_up)
      : is_given_up_(std::move(is_given_up)),
        file_(input.file(), false, &input),
        cache_(file_, {.byte_count = k_cache_bytes, .progress = [this](std::uint64_t, std::uint64_t) {
                         return !is_given_up_ || !is_given_up_();
                       }}) {
    for (const CopcNode& node : nodes()) {
      first_chunks_.push_back(chunk_count_);
      chunk_count_ += (node.chunk.point_count + k_chunk_points - 1) / k_chunk_points;
    }
  }

  CloudSchema schema() const {
    const LasColumns columns(file_.name(), file_.header(), file_.records().extra_dimensions);
    PointCloud like;
    like.lattice = file_.header().lattice;
    columns.choose(AttributeSet::all(), like);
    CloudSchema schema;
    schema.lattice = like.lattice;
    schema.point_count = file_.header().point_count;
    schema.chunk_count = chunk_count_;
    schema.columns = stored_columns(columns.attributes(), std::move(like.extra_dimensions));
    return schema;
  }
  const std::vector<std::string>& warnings() const { return file_.warnings(); }

  std::vector<ChunkLocation> chunks(const PointFilter& filter, std::optional<std::uint64_t> only) override {
    std::vector<ChunkLocation> found;
    if (only) {
      if (*only < chunk_count_) found.push_back({*only, file_.bounds(nodes()[node_of(*only)])});
      return found;
    }
    std::vector<std::uint32_t> wanted;
    const std::uint64_t points = find_nodes(filter, wanted);
    if (points > k_cache_bytes / k_bytes_per_point) {
      for (const std::uint32_t node : wanted) {
        const Bounds box = file_.bounds(nodes()[node]);
        const std::uint64_t end = first_chunks_[node] + chunk_count_of(node);
        for (std::uint64_t id = first_chunks_[node]; id < end; ++id) found.push_back({id, box});
      }
      return found;
    }
    std::vector<std::vector<ChunkLocation>> of_nodes(wanted.size());
    in_parallel(wanted.size(), 1, [&](std::size_t i) {
      const std::shared_ptr<const BoxedPoints> points_of_node = cache_.points(wanted[i]);
      const int top = points_of_node->levels() - 1;
      visit(*points_of_node, filter, top, 0, points_of_node->boxes(top).size(), first_chunks_[wanted[i]],
            of_nodes[i]);
    });
    for (std::vector<ChunkLocation>& some : of_nodes) std::ranges::move(some, std::back_inserter(found));
    return found;
  }

  std::shared_ptr<StoredChunk> read(const ChunkLocation& location) override {
    const std::uint32_t node = node_of(location.id);
    const std::shared_ptr<const BoxedPoints> points = cache_.points(node);
    const auto first = static_cast<std::size_t>(location.id - first_chunks_[node]) * k_chunk_points;
    const std::size_t end = std::min(first + k_chunk_points, points->size());
    auto chunk = std::make_shared<StoredChunk>();
    chunk->id = location.id;
    std::vector<std::byte>& ids = chunk->blobs.emplace_back().emplace();
    for (std::size_t i = first; i < end; ++i) {
      chunk->positions.push_back(points->positions()[i]);
      const std::uint64_t id = nodes()[node].first_row + points->rows()[i];
      ids.resize(ids.size() + sizeof id);
      store(ids.data() + ids.size() - sizeof id, id);
    }
    return chunk;
  }

  const std::byte* bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) override {
    const auto number = static_cast<std::size_t>(column.blob);
    if (chunk.blobs.size() <= number) chunk.blobs.resize(number + 1);
    if (!chunk.blobs[number]) {
      const std::uint32_t node = node_of(chunk.id);
      const std::shared_ptr<const PointCloud> attributes = attributes_of(node);
      const ValueBlob blob = value_blobs(columns_of(*attributes))[number - 1];
      std::vector<std::byte>& bytes = chunk.blobs[number].emplace(chunk.positions.size() * blob.size);
      for (std::size_t i = 0; i < chunk.positions.size(); ++i) {
        const auto id = load<std::uint64_t>(chunk.blobs.front()->data() + i * sizeof(std::uint64_t));
        std::memcpy(bytes.data() + i * blob.size, blob.values + (id - nodes()[node].first_row) * blob.size,
                    blob.size);
      }
    }
    return chunk.blobs[number]->data() + row * static_cast<std::size_t>(column.size) +
           static_cast<std::size_t>(column.byte);
  }

 private:
  struct NodeAttributes {
    std::size_t byte_count;
    std::shared_ptr<const PointCloud> cloud;
  };

  const std::vector<CopcNode>& nodes() const { return file_.hierarchy().nodes; }

  std::uint64_t chunk_count_of(std::uint32_t node) const {
    return (node + 1 < first_chunks_.size() ? first_chunks_[node + 1] : chunk_count_) - first_chunks_[node];
  }

  /// The node of a chunk: the last one whose first chunk is not greater. Nodes without chunks have the first
  /// chunk of the node after them.
  std::uint32_t node_of(std::uint64_t chunk) const {
    const auto behind = std::ranges::upper_bound(first_chunks_, chunk);
    return static_cast<std::uint32_t>(behind - first_chunks_.begin() - 1);
  }

  /// Finds the nodes that may have wanted points, in the order of the hierarchy. Returns their number of
  /// points.
  std::uint64_t find_nodes(const PointFilter& filter, std::vector<std::uint32_t>& wanted) const {
    std::uint64_t points = 0;
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
      const std::uint32_t number = stack.back();
      stack.pop_back();
      const CopcNode& node = nodes()[number];
      if (!may_hold(filter, file_.bounds(node))) continue;
      if (node.chunk.point_count > 0) wanted.push_back(number);
      points += node.chunk.point_count;
      std::ranges::copy(file_.hierarchy().children_of(node), std::back_inserter(stack));
    }
    std::ranges::sort(wanted);
    return points;
  }

  /// Finds the chunks below some boxes of a level that may have wanted points.
  void visit(const BoxedPoints& points, const PointFilter& filter, int level, std::size_t begin,
             std::size_t end, std::uint64_t first_chunk, std::vector<ChunkLocation>& found) const {
    const Lattice& lattice = file_.header().lattice;
    if (level == 0) {  // the node has a single chunk, and so no level with a box for each
      LatticeExtent all;
      for (const BoxedPoints::Box& box : points.boxes(0)) all.grow(box);
      found.push_back({first_chunk, {to_world(lattice, all.low), to_world(lattice, all.high)}});
      return;
    }
    for (std::size_t i = begin; i < end; ++i) {
      const BoxedPoints::Box& steps = points.boxes(level)[i];
      const Bounds box{to_world(lattice, steps.low), to_world(lattice, steps.high)};
      if (!may_hold(filter, box)) continue;
      const std::size_t below = i * BoxedPoints::k_fan_out;
      if (level == 1) {
        found.push_back({first_chunk + i, box});
      } else {
        visit(points, filter, level - 1, below,
              std::min(below + BoxedPoints::k_fan_out, points.boxes(level - 1).size()), first_chunk, found);
      }
    }
  }

  PointCloud read_nodes(std::vector<std::uint32_t> numbers, AttributeSet attributes) const {
    const ChosenNodes chosen{&file_, std::move(numbers)};
    ReadOptions options{.attributes = attributes, .color_depth = ColorDepth::bits_16};
    options.progress = [this](std::uint64_t, std::uint64_t) { return !is_given_up_ || !is_given_up_(); };
    return read_copc_nodes(std::span(&chosen, 1), options);
  }

  /// The depth of the colours of the file.
  const ColorSpread& spread() {
    if (spread_) return *spread_;
    constexpr std::size_t k_nodes_at_once = 16;
    std::vector<ColoredRows> rows = {{.file_name = file_.name()}};
    std::vector<std::uint32_t> next;
    for (std::uint32_t node = 0; node < nodes().size(); ++node) {
      if (nodes()[node].chunk.point_count > 0) next.push_back(node);
      if (next.size() < k_nodes_at_once && node + 1 < nodes().size()) continue;
      measure_colors(read_nodes(std::exchange(next, {}), Attribute::color | Attribute::near_infrared), 0,
                     rows);
      if (rows.front().largest_color > 255) break;
    }
    std::vector<std::string> ignored;
    return spread_.emplace(choose_spread(std::move(rows), ColorDepth::automatic, ignored));
  }

  /// Attributes of all points of a node, by their rows in it.
  std::shared_ptr<const PointCloud> attributes_of(std::uint32_t node) {
    if (const NodeAttributes* const found = attributes_.find(node)) return found->cloud;
    auto cloud = std::make_shared<PointCloud>(read_nodes({node}, AttributeSet::all()));
    if (!cloud->colors.empty()) apply(spread(), *cloud);
    std::size_t size = sizeof(LatticePosition);
    for (const ValueBlob& blob : value_blobs(columns_of(*cloud))) size += blob.size;
    attributes_.add(node, {size * cloud->size(), cloud});
    attribute_bytes_ += size * cloud->size();
    while (attribute_bytes_ > k_attribute_bytes && attributes_.size() > 1)
      attribute_bytes_ -= attributes_.take_oldest().byte_count;
    return cloud;
  }

  std::function<bool()> is_given_up_;
  CopcFile file_;
  CopcCache cache_;
  std::vector<std::uint64_t> first_chunks_;  ///< of the nodes
  std::uint64_t chunk_count_ = 0;
  std::optional<ColorSpread> spread_;
  RecentlyUsed<std::uint32_t, NodeAttributes> attributes_;  ///< by node
  std::size_t attribute_bytes_ = 0;
};

FileChunks copc_chunks(const CloudInput& input, std::function<bool()> is_given_up) {
  auto source = std::make_unique<CopcChunks>(input, std::move(is_given_up));
  FileChunks chunks{.schema = source->schema(), .warnings = source->warnings()};
  chunks.source = std::move(source);
  return chunks;
}

}  // namespace

FileCloud::FileCloud(std::span<const std::filesystem::path> names, const FileTables& how) {
  const CloudInputs inputs = in_one_unit(resolve_clouds(names, index_and_file_formats()));
  for (const CloudInput& input : inputs.inputs) files_.push_back(state_of(input.name));
  const CloudInput* const copc = how.reading.partial ? nullptr : inputs.only(k_copc_format);
  if (copc != nullptr) chunks_ = copc_chunks(*copc, how.is_given_up);
  if (schema().point_count == 0) chunks_ = octree_chunks(inputs, how.reading);
  check_unchanged();
}

FileCloud::FileState FileCloud::state_of(const std::filesystem::path& file) {
  struct stat status {};
  // A missing file has the default state.
  if (is_remote_name(file.string()) || ::stat(file.c_str(), &status) != 0) return {.name = file};
  return {.name = file,
          .device = status.st_dev,
          .number = status.st_ino,
          .size = static_cast<std::uint64_t>(status.st_size),
          .seconds = status.st_mtim.tv_sec,
          .nanoseconds = status.st_mtim.tv_nsec};
}

void FileCloud::check_unchanged() const {
  for (const FileState& file : files_) {
    const FileState now = state_of(file.name);
    if (now == file) continue;
    throw file_error(file.name.string(),
                     now.number == 0 ? "the file was removed since it was opened"
                                     : "the file has changed since it was opened",
                     "the file as it was when it was opened; make the table or statement again");
  }
}

}  // namespace alidade::database
