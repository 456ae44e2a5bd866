// SPDX-License-Identifier: MIT
#include <tbb/parallel_for.h>
#include <algorithm>
#include <cstring>
#include <iterator>
#include <list>
#include <utility>

#include "base/bytes.h"
#include "cloud/las/las_records.h"
#include "cloud/read_in_pieces.h"
#include "database/point_stream.h"
#include "database/sqlite/file_chunks.h"
#include "octree/copc_tree.h"

namespace alidade::database {
namespace {

constexpr std::size_t k_chunk_points = BoxedPoints::k_block_points * BoxedPoints::k_fan_out;
constexpr std::size_t k_cache_bytes = std::size_t{512} << 20;
constexpr std::size_t k_attribute_bytes = std::size_t{256} << 20;

/// Upper bound of the memory that CopcCache takes per point.
constexpr std::uint64_t k_bytes_per_point = 20;

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
    tbb::parallel_for(std::size_t{0}, wanted.size(), [&](std::size_t i) {
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
    std::uint32_t node;
    std::size_t byte_count;
    std::shared_ptr<const PointCloud> cloud;
  };

  const std::vector<CopcNode>& nodes() const { return file_.hierarchy().nodes; }

  std::uint64_t chunk_count_of(std::uint32_t node) const {
    return (node + 1 < first_chunks_.size() ? first_chunks_[node + 1] : chunk_count_) - first_chunks_[node];
  }

  /// The node of a chunk: the last one with a first chunk not above it, since nodes without
  /// chunks begin with the next.
  std::uint32_t node_of(std::uint64_t chunk) const {
    const auto behind = std::ranges::upper_bound(first_chunks_, chunk);
    return static_cast<std::uint32_t>(behind - first_chunks_.begin() - 1);
  }

  /// Finds the nodes that may have wanted points, in the order of the hierarchy.
  /// Returns their number of points.
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
    if (level == 0) {  // no level has a box for each chunk, because there is but one
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
    const auto found = std::ranges::find(attributes_, node, &NodeAttributes::node);
    if (found != attributes_.end()) {
      attributes_.splice(attributes_.begin(), attributes_, found);
      return found->cloud;
    }
    auto cloud = std::make_shared<PointCloud>(read_nodes({node}, AttributeSet::all()));
    if (!cloud->colors.empty()) apply(spread(), *cloud);
    std::size_t size = sizeof(LatticePosition);
    for (const ValueBlob& blob : value_blobs(columns_of(*cloud))) size += blob.size;
    attributes_.push_front({node, size * cloud->size(), cloud});
    attribute_bytes_ += size * cloud->size();
    while (attribute_bytes_ > k_attribute_bytes && attributes_.size() > 1) {
      attribute_bytes_ -= attributes_.back().byte_count;
      attributes_.pop_back();
    }
    return cloud;
  }

  std::function<bool()> is_given_up_;
  CopcFile file_;
  CopcCache cache_;
  std::vector<std::uint64_t> first_chunks_;  ///< of the nodes
  std::uint64_t chunk_count_ = 0;
  std::optional<ColorSpread> spread_;
  std::list<NodeAttributes> attributes_;  ///< the last used first
  std::size_t attribute_bytes_ = 0;
};

}  // namespace

FileChunks copc_chunks(const CloudInput& input, std::function<bool()> is_given_up) {
  auto source = std::make_unique<CopcChunks>(input, std::move(is_given_up));
  FileChunks chunks{.schema = source->schema(), .warnings = source->warnings()};
  chunks.source = std::move(source);
  return chunks;
}

}  // namespace alidade::database
