// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/input_file.h"
#include "base/recently_used.h"
#include "cloud/cloud_inputs.h"
#include "cloud/crs.h"
#include "cloud/lattice.h"
#include "octree/copc_tree.h"

namespace alidade {

/// COPC files that are one cloud, each opened when a query enters its box. Thread safe.
///
/// A box is what a catalog states (CloudInput::stated); files without a stated box are opened at once. Files
/// and their points are dropped again when they exceed CopcCache::Options::byte_count, the least recently
/// entered first.
class CopcTiles {
 public:
  /// A file that is open.
  struct Tile {
    Tile(const CloudInput& input, const CopcCache::Options& options, bool rests);
    ~Tile();

    CopcFile file;
    CopcCache cache;
    std::optional<CopcTree> tree;  ///< of the points as rows of the whole cloud
    std::atomic<std::size_t>& kept_in_all;
    std::size_t byte_count;  ///< of what is no point, about
  };

  /// Opens the first file that has points. Requires one file at least. Errors: those of opening COPC files.
  CopcTiles(const CloudInputs& inputs, const CopcCache::Options& options);
  ~CopcTiles();
  CopcTiles(const CopcTiles&) = delete;
  CopcTiles& operator=(const CopcTiles&) = delete;

  std::size_t size() const { return inputs_.inputs.size(); }
  std::uint64_t point_count() const { return first_rows_.back(); }
  /// Whether any file lies on a server.
  bool is_any_remote() const { return is_any_remote_; }
  /// That of the first file that has points: the one of the cloud that read_cloud() gives.
  const Lattice& lattice() const { return lattice_; }
  const Crs& crs() const { return crs_; }
  /// About files that were opened at once.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Opens a file, or finds it open. Errors: those of opening; it is not what a catalog states
  /// (check_stated()); its lattice is not on that of the first (steps_between()); its reference system
  /// differs.
  std::shared_ptr<const Tile> tile(std::uint32_t number) const;

  /// Boxes around the files that have points: those of level 0 are files, by file_of(), and those of each
  /// level above are around 8 of the level below. The highest has one box; no levels without points.
  const std::vector<std::vector<Bounds>>& boxes() const { return boxes_; }
  std::uint32_t file_of(std::size_t box) const { return order_[box]; }

  /// Calls take(file) for the files of whose box, and of all boxes around it, `is_met` holds.
  template <class IsMet, class Take>
  void for_each_met(const IsMet& is_met, const Take& take) const {
    if (boxes_.empty()) return;
    std::vector<std::pair<std::size_t, std::size_t>> left = {{boxes_.size() - 1, 0}};  // level and box
    while (!left.empty()) {
      const auto [level, number] = left.back();
      left.pop_back();
      if (!is_met(boxes_[level][number])) continue;
      if (level == 0) {
        take(order_[number]);
        continue;
      }
      const std::size_t end = std::min((number + 1) * k_fan_out, boxes_[level - 1].size());
      for (std::size_t i = number * k_fan_out; i < end; ++i) left.push_back({level - 1, i});
    }
  }

  struct Work {
    std::size_t files_opened = 0;   ///< at least once
    std::uint64_t chunk_count = 0;  ///< nodes with points in these files
    CopcReads reads;
  };
  /// What was read so far.
  Work work() const;

  static constexpr std::size_t k_fan_out = 8;

 private:
  struct Slot;

  std::shared_ptr<const Tile> find(std::uint32_t number) const;
  void make_room() const;
  std::shared_ptr<Tile> open(std::uint32_t number) const;
  /// Makes an open file part of the cloud.
  std::shared_ptr<const Tile> join(std::uint32_t number, std::shared_ptr<Tile> tile) const;
  void build_boxes(const std::vector<Bounds>& boxes);

  CloudInputs inputs_;
  CopcCache::Options options_;
  bool is_any_remote_ = false;
  Lattice lattice_;
  Crs crs_;
  std::string first_name_;  ///< of the file that has these
  std::vector<std::string> warnings_;
  std::vector<std::uint64_t> first_rows_;  ///< of every file, and one more: the number of points
  std::vector<std::vector<Bounds>> boxes_;
  std::vector<std::uint32_t> order_;                 ///< of the files along the boxes of level 0
  mutable std::atomic<std::size_t> kept_bytes_ = 0;  ///< of points, and of what open files take
  std::unique_ptr<Slot[]> slots_;
  mutable std::mutex mutex_;                                               ///< of all that follows
  mutable RecentlyUsed<std::uint32_t, std::shared_ptr<const Tile>> open_;  ///< by file
  mutable Work work_;  ///< without the reads of files that are open
};

/// Such a cloud as tree_query.h walks it: boxes around files, the files, and in each its CopcTree. Answers
/// equal those of the loaded cloud bit for bit, provided that no point lies outside of what a catalog states
/// of its file; points that are read are checked against it, those in a pruned box are not.
class CopcTilesTree {
 public:
  /// A node of a file's tree, whose `points` also keep the file open; or a box, of this level and number.
  struct Node : CopcTree::Node {
    const CopcTiles::Tile* tile = nullptr;  ///< null: a box
  };

  /// The tiles must outlive the tree.
  explicit CopcTilesTree(const CopcTiles& tiles) : tiles_(&tiles) {}

  bool empty() const { return tiles_->boxes().empty(); }
  Node root() const { return box(static_cast<int>(tiles_->boxes().size()) - 1, 0); }
  const Bounds& bounds(const Node& node) const { return node.bounds; }

  template <class Visit>
  void for_each_point(const Node& node, const Visit& visit) const {
    if (node.tile) node.tile->tree->for_each_point(node, visit);
  }

  template <class Visit>
  void for_each_child(const Node& node, const Visit& visit) const {
    if (node.tile) {
      visit_in(node, visit);
    } else if (node.level == 0) {
      const std::shared_ptr<const CopcTiles::Tile> tile = tiles_->tile(tiles_->file_of(node.number));
      if (tile->tree->empty()) return;
      Node root{tile->tree->root(), tile.get()};
      root.points = Points(tile, nullptr);
      visit(root);
    } else {
      const std::size_t first = node.number * CopcTiles::k_fan_out;
      const std::size_t size = tiles_->boxes()[static_cast<std::size_t>(node.level) - 1].size();
      for (std::size_t i = first; i < std::min(first + CopcTiles::k_fan_out, size); ++i)
        visit(box(node.level - 1, i));
    }
  }

 private:
  using Points = std::shared_ptr<const BoxedPoints>;

  Node box(int level, std::size_t number) const {
    Node box;
    box.bounds = tiles_->boxes()[static_cast<std::size_t>(level)][number];
    box.level = static_cast<std::int8_t>(level);
    box.number = static_cast<std::uint32_t>(number);
    return box;
  }

  template <class Visit>
  static void visit_in(const Node& node, const Visit& visit) {
    Points held;  // the points below node.kind own_points, and the file
    node.tile->tree->for_each_child(node, [&](CopcTree::Node&& own) {
      Node child{std::move(own), node.tile};
      if (child.kind != CopcTree::Kind::box) {
        child.points = node.points;
      } else if (node.kind != CopcTree::Kind::box) {
        if (!held) {
          const BoxedPoints* const points = child.points.get();
          held = Points(std::make_shared<std::pair<Points, Points>>(node.points, std::move(child.points)),
                        points);
        }
        child.points = held;
      }
      visit(child);
    });
  }

  const CopcTiles* tiles_;
};

}  // namespace alidade
