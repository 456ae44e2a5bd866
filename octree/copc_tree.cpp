// SPDX-License-Identifier: MIT

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <bit>
#include <cassert>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/morton.h"
#include "cloud/laz/chunk_codec.h"
#include "cloud/laz/laz_layout.h"
#include "octree/check_query.h"
#include "octree/copc_tree.h"

namespace alidade {
namespace {

struct SortedPoint {
  std::uint64_t key;
  std::uint32_t index;  ///< in the list that is sorted

  bool operator<(const SortedPoint& other) const {
    return key != other.key ? key < other.key : index < other.index;
  }
};

/// Order along the curve, on the finest grid of 2^21 cells per axis that holds all points.
std::vector<SortedPoint> morton_order(const std::vector<LatticePosition>& positions) {
  LatticeExtent all;
  for (const LatticePosition& position : positions) all.grow(position);
  const auto steps = [&](const LatticePosition& to, int axis) {
    return static_cast<std::uint32_t>(to[axis]) - static_cast<std::uint32_t>(all.low[axis]);
  };
  const std::uint32_t longest = std::max({steps(all.high, 0), steps(all.high, 1), steps(all.high, 2)});
  const int shift = std::max(0, static_cast<int>(std::bit_width(longest)) - k_morton_bits);
  std::vector<SortedPoint> order(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto cell = [&](int axis) { return steps(positions[i], axis) >> shift; };
    order[i] = {morton_key(cell(0), cell(1), cell(2)), static_cast<std::uint32_t>(i)};
  }
  std::sort(order.begin(), order.end());
  return order;
}

/// A box around each `count` of the items, the last maybe around fewer.
template <class Item>
std::vector<LatticeExtent> boxes_around(const std::vector<Item>& items, std::size_t count) {
  std::vector<LatticeExtent> boxes;
  boxes.reserve((items.size() + count - 1) / count);
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i % count == 0) boxes.emplace_back();
    boxes.back().grow(items[i]);
  }
  return boxes;
}

}  // namespace

BoxedPoints::BoxedPoints(std::vector<LatticePosition> positions, std::vector<std::uint32_t> rows) {
  assert(positions.size() == rows.size());
  if (positions.empty()) return;
  positions_.reserve(positions.size());
  rows_.reserve(rows.size());
  for (const SortedPoint& point : morton_order(positions)) {
    positions_.push_back(positions[point.index]);
    rows_.push_back(rows[point.index]);
  }
  boxes_.push_back(boxes_around(positions_, k_block_points));
  while (boxes_.back().size() > k_fan_out) boxes_.push_back(boxes_around(boxes_.back(), k_fan_out));
}

std::size_t BoxedPoints::byte_count() const {
  std::size_t bytes = sizeof(BoxedPoints) + positions_.capacity() * sizeof(LatticePosition) +
                      rows_.capacity() * sizeof(std::uint32_t) + boxes_.capacity() * sizeof(boxes_[0]);
  for (const std::vector<Box>& level : boxes_) bytes += level.capacity() * sizeof(Box);
  return bytes;
}

struct CopcCache::Slot {
  std::mutex decoding;   ///< held by the thread that decodes the node
  bool was_met = false;  ///< belongs to mutex_
};

/// What threads need to decode nodes.
struct CopcCache::Workshops {
  struct Workshop {
    ChunkDecoder decoder;
    std::vector<std::byte> bytes{};
  };

  Workshops(const LazLayout& layout, const LazLayers& wanted)
      : of_threads([&layout, wanted] { return Workshop{ChunkDecoder(layout, wanted)}; }) {}

  tbb::enumerable_thread_specific<Workshop> of_threads;
};

CopcCache::CopcCache(const CopcFile& file, const Options& options)
    : file_(file), options_(options), slots_(std::make_unique<Slot[]>(file.hierarchy().nodes.size())) {
  LazLayers wanted = LazLayers::positions();
  wanted.classification = options_.classes.has_value();
  workshops_ = std::make_unique<Workshops>(file_.layout(), wanted);
}

CopcCache::~CopcCache() {
  count_kept(0, kept_bytes_);
}

void CopcCache::count_kept(std::size_t more, std::size_t less) const {
  kept_bytes_ += more - less;
  if (options_.kept_in_all != nullptr) *options_.kept_in_all += more - less;
}

std::shared_ptr<const BoxedPoints> CopcCache::points(std::uint32_t node) const {
  if (auto points = find(node)) return points;
  const std::lock_guard decoding(slots_[node].decoding);
  if (auto points = find(node)) return points;
  auto points = decode(node);
  keep(node, points);
  return points;
}

CopcReads CopcCache::reads() const {
  const std::lock_guard lock(mutex_);
  return reads_;
}

std::shared_ptr<const BoxedPoints> CopcCache::find(std::uint32_t node) const {
  const std::lock_guard lock(mutex_);
  const auto* const points = kept_.find(node);
  return points != nullptr ? *points : nullptr;
}

void CopcCache::keep(std::uint32_t node, std::shared_ptr<const BoxedPoints> points) const {
  const std::uint64_t decoded = file_.hierarchy().nodes[node].chunk.point_count;
  const std::lock_guard lock(mutex_);
  if (decoded > 0) {
    ++reads_.chunks_decoded;
    reads_.points_decoded += decoded;
    if (!std::exchange(slots_[node].was_met, true)) ++reads_.chunks_met;
    report(options_.progress, reads_.points_decoded, file_.header().point_count);
  }
  count_kept(points->byte_count(), 0);
  kept_.add(node, std::move(points));
  while (kept_bytes_ > options_.byte_count && kept_.size() > 1)
    count_kept(0, kept_.take_oldest()->byte_count());
}

std::shared_ptr<const BoxedPoints> CopcCache::decode(std::uint32_t number) const {
  const CopcNode& node = file_.hierarchy().nodes[number];
  std::vector<LatticePosition> positions;
  std::vector<std::uint32_t> rows;
  if (node.chunk.point_count == 0)
    return std::make_shared<BoxedPoints>(std::move(positions), std::move(rows));
  const Bounds bounds = file_.bounds(node);
  const Lattice& lattice = file_.header().lattice;
  const std::size_t point_size = file_.header().point_size;
  constexpr std::size_t k_classification_offset = 16;  // of formats 6 to 8
  const auto fail = [&](std::optional<std::uint64_t> row, std::string problem, std::string expected,
                        std::string found) {
    const std::string chunk = fmt::format("COPC node {}", node.key.name());
    throw Error(file_.name(), row ? fmt::format("{}, point {}", chunk, node.first_row + *row) : chunk,
                std::move(problem), std::move(expected), std::move(found));
  };
  Workshops::Workshop& workshop = workshops_->of_threads.local();
  file_.read_chunk(node, workshop.bytes);
  try {
    workshop.decoder.decode(
        workshop.bytes, node.chunk.point_count,
        [&](const std::byte* records, std::size_t count, std::uint64_t first) {
          positions.reserve(count);
          rows.reserve(count);
          for (std::size_t i = 0; i < count; ++i, records += point_size) {
            const LatticePosition position = load<LatticePosition>(records);
            const glm::dvec3 world = to_world(lattice, position);
            if (!bounds.contains(world)) {
              fail(first + i, "the point is outside the cube of its node",
                   "a position from " + text_of(bounds.min) + " to " + text_of(bounds.max), text_of(world));
            }
            if (options_.stated_box && !options_.stated_box->contains(world)) {
              fail(
                  first + i,
                  "the point is outside the box that a catalog states; make the catalog again with --measure",
                  "a position from " + text_of(options_.stated_box->min) + " to " +
                      text_of(options_.stated_box->max),
                  text_of(world));
            }
            const auto point_class = load<std::uint8_t>(records + k_classification_offset);
            if (options_.classes && !options_.classes->test(point_class)) continue;
            positions.push_back(position);
            rows.push_back(static_cast<std::uint32_t>(first + i));
          }
        });
  } catch (const CorruptChunk& problem) {
    fail(problem.point, fmt::format("corrupt compressed points: {}", problem.what()), "", "");
  }
  return std::make_shared<BoxedPoints>(std::move(positions), std::move(rows));
}

}  // namespace alidade
