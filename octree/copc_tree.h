// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <atomic>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/bounds.h"
#include "base/progress.h"
#include "base/recently_used.h"
#include "cloud/copc/copc_file.h"
#include "cloud/lattice.h"

namespace alidade {

/// Points sorted along a Morton curve in blocks of 16 with a box around each, boxes around 8 of these, and so
/// on, so that queries test few of the many points of a node. Rows are the numbers the points had before.
class BoxedPoints {
 public:
  static constexpr std::size_t k_block_points = 16;
  static constexpr std::size_t k_fan_out = 8;

  /// positions[i] is the point of row rows[i]. Cost: n log n.
  BoxedPoints(std::vector<LatticePosition> positions, std::vector<std::uint32_t> rows);

  using Box = LatticeExtent;

  std::size_t size() const { return positions_.size(); }
  /// Levels of boxes: 0 are the blocks. None if there are no points.
  int levels() const { return static_cast<int>(boxes_.size()); }
  /// The boxes of a level; those of the highest are at most 8.
  const std::vector<Box>& boxes(int level) const { return boxes_[static_cast<std::size_t>(level)]; }
  const std::vector<LatticePosition>& positions() const { return positions_; }
  const std::vector<std::uint32_t>& rows() const { return rows_; }
  /// Memory that the object takes.
  std::size_t byte_count() const;

 private:
  std::vector<LatticePosition> positions_;
  std::vector<std::uint32_t> rows_;
  std::vector<std::vector<Box>> boxes_;
};

/// What was read of a COPC file so far.
struct CopcReads {
  std::uint64_t chunks_decoded = 0;  ///< again counts again
  std::uint64_t points_decoded = 0;
  std::uint64_t chunks_met = 0;  ///< decoded at least once

  CopcReads& operator+=(const CopcReads& more) {
    chunks_decoded += more.chunks_decoded;
    points_decoded += more.points_decoded;
    chunks_met += more.chunks_met;
    return *this;
  }
};

/// Points of a COPC file, node by node, decoded when they are requested and kept while there is room. Thread
/// safe: a thread that requests a node which another thread is decoding waits for it.
class CopcCache {
 public:
  struct Options {
    std::size_t byte_count = std::size_t{512} << 20;  ///< most to keep; what is in use may be more
    std::optional<std::bitset<256>> classes{};        ///< only points of these
    /// The box that a catalog states for all points; empty: none.
    std::optional<Bounds> stated_box{};
    /// Also counts what is kept; several caches may share it, which it must outlive.
    std::atomic<std::size_t>* kept_in_all = nullptr;
    /// Called whenever a node was decoded, by one thread at a time, in points decoded so far and points of
    /// the file; points that are decoded again count again.
    Progress progress{};
  };

  /// The file must outlive the cache.
  CopcCache(const CopcFile& file, const Options& options);
  ~CopcCache();

  const CopcFile& file() const { return file_; }

  /// The points of a node of the file's hierarchy; none if it has no chunk. Rows count within the node. The
  /// least recently used nodes are dropped for new ones. Errors: the chunk is damaged, or a point lies
  /// outside CopcFile::bounds() of its node or of Options::stated_box. Cancelled, if the progress function
  /// returns false. Cost: about 0.2 microseconds per point unless they are kept.
  std::shared_ptr<const BoxedPoints> points(std::uint32_t node) const;

  CopcReads reads() const;

 private:
  struct Slot;
  struct Workshops;

  std::shared_ptr<const BoxedPoints> decode(std::uint32_t node) const;
  std::shared_ptr<const BoxedPoints> find(std::uint32_t node) const;
  void keep(std::uint32_t node, std::shared_ptr<const BoxedPoints> points) const;
  void count_kept(std::size_t more, std::size_t less) const;

  const CopcFile& file_;
  Options options_;
  std::unique_ptr<Slot[]> slots_;
  std::unique_ptr<Workshops> workshops_;
  mutable std::mutex mutex_;                                                      ///< of all that follows
  mutable RecentlyUsed<std::uint32_t, std::shared_ptr<const BoxedPoints>> kept_;  ///< by node
  mutable std::size_t kept_bytes_ = 0;
  mutable CopcReads reads_;
};

/// A COPC file as tree_query.h walks it: an octree on disk, queried in place. Its nodes are
/// - cubes: nodes of the file's hierarchy, whose children are cubes and their own points;
/// - own points of a cube, whose chunk is decoded when this node's children are requested;
/// - boxes of these points, and blocks of some points.
/// point_id is the row in the order of the file, as in the cloud that read_cloud() gives.
///
///   CopcFile file(InputFile("big.copc.laz"));
///   CopcCache cache(file, {});
///   RayTarget target(ray, query);
///   Nearest<RayTarget> neighbors(target, 8);
///   tree_query(CopcTree(cache), target, neighbors);
///
/// Answers equal those of the loaded cloud bit for bit, provided that each point lies in the cube of its node
/// as COPC demands. Decoded points are checked against it; those in a pruned cube are not.
class CopcTree {
 public:
  enum class Kind : std::uint8_t { cube, own_points, box };

  struct Node {
    Bounds bounds;
    Kind kind = Kind::cube;
    std::int8_t level = 0;     ///< of a box
    std::uint32_t number = 0;  ///< of the node in the hierarchy
    std::size_t box = 0;
    std::shared_ptr<const BoxedPoints> points{};  ///< of a box
  };

  /// The cache must outlive the tree.
  explicit CopcTree(const CopcCache& cache) : CopcTree(cache, cache.file().header().lattice, 0) {}

  /// As a part of a cloud of this lattice, in which the file's first point is row `first_row`. Errors: those
  /// of LatticeShift.
  CopcTree(const CopcCache& cache, const Lattice& lattice, std::uint64_t first_row)
      : cache_(cache),
        hierarchy_(cache.file().hierarchy()),
        lattice_(lattice),
        shift_(cache.file().header().lattice, lattice, cache.file().name()),
        first_row_(first_row) {}

  bool empty() const { return hierarchy_.nodes.empty(); }
  Node root() const { return cube(0); }
  const Bounds& bounds(const Node& node) const { return node.bounds; }

  template <class Visit>
  void for_each_point(const Node& node, const Visit& visit) const {
    if (node.kind != Kind::box || node.level > 0) return;
    const std::uint64_t first_row = first_row_ + hierarchy_.nodes[node.number].first_row;
    const std::size_t first = node.box * BoxedPoints::k_block_points;
    const std::size_t last = std::min(first + BoxedPoints::k_block_points, node.points->size());
    for (std::size_t i = first; i < last; ++i) {
      if (!visit(first_row + node.points->rows()[i], world(node.points->positions()[i]))) return;
    }
  }

  template <class Visit>
  void for_each_child(const Node& node, const Visit& visit) const {
    if (node.kind == Kind::cube) {
      const CopcNode& cube_node = hierarchy_.nodes[node.number];
      if (cube_node.chunk.point_count > 0) {
        visit(Node{.bounds = node.bounds, .kind = Kind::own_points, .number = node.number});
      }
      for (const std::uint32_t child : hierarchy_.children_of(cube_node)) visit(cube(child));
    } else if (node.kind == Kind::own_points) {
      const std::shared_ptr<const BoxedPoints> points = cache_.points(node.number);
      const int top = points->levels() - 1;
      if (top >= 0) visit_boxes(node.number, points, top, 0, points->boxes(top).size(), visit);
    } else if (node.level > 0) {
      const int below = node.level - 1;
      const std::size_t first = node.box * BoxedPoints::k_fan_out;
      const std::size_t last = std::min(first + BoxedPoints::k_fan_out, node.points->boxes(below).size());
      visit_boxes(node.number, node.points, below, first, last, visit);
    }
  }

 private:
  glm::dvec3 world(const LatticePosition& position) const { return to_world(lattice_, shift_(position)); }

  Node cube(std::uint32_t number) const {
    return {.bounds = cache_.file().bounds(hierarchy_.nodes[number]), .kind = Kind::cube, .number = number};
  }

  template <class Visit>
  void visit_boxes(std::uint32_t number, const std::shared_ptr<const BoxedPoints>& points, int level,
                   std::size_t first, std::size_t last, const Visit& visit) const {
    for (std::size_t i = first; i < last; ++i) {
      const BoxedPoints::Box& box = points->boxes(level)[i];
      visit(Node{.bounds = {world(box.low), world(box.high)},
                 .kind = Kind::box,
                 .level = static_cast<std::int8_t>(level),
                 .number = number,
                 .box = i,
                 .points = points});
    }
  }

  const CopcCache& cache_;
  const CopcHierarchy& hierarchy_;
  Lattice lattice_;
  LatticeShift shift_;
  std::uint64_t first_row_;
};

}  // namespace alidade
