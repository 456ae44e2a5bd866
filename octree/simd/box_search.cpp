// SPDX-License-Identifier: MIT
#include "octree/simd/search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/box_search.cpp"
#include <hwy/foreach_target.h>

#include <memory>
#include <utility>

#include "octree/candidate.h"
#include "octree/simd/box_walk-inl.h"
#include "octree/simd/choose_table.h"
#include "octree/simd/first_answers.h"
#include "octree/simd/sort_keys.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// How many points, up to k.
class BoxCounter {
 public:
  BoxCounter(const TreeView& tree, const Bounds& box, const PointQuery& query, std::size_t k,
             std::size_t query_index)
      : tree_(tree), box_(box), query_(query), k_(k), query_index_(query_index) {}

  bool is_done() const { return count_ >= k_; }
  bool all(const Frame& frame, int slot) {
    const bool knows_subtrees = !query_.filter && query_.max_level == k_all_levels;
    if (knows_subtrees) count_ += subtree_count(tree_, frame, slot);
    return knows_subtrees;
  }
  void leaf(const Leaf& leaf, std::uint32_t points) {
    if (!query_.filter) {
      count_ += static_cast<std::size_t>(std::popcount(points));
      return;
    }
    for (; points != 0 && !is_done(); points &= points - 1) {
      const std::uint32_t i = index_of_lowest_bit(points);
      const glm::dvec3 position = to_world(tree_.lattice, position_of(tree_, leaf, i));
      count_ += evaluate(box_, query_, position, point_id(tree_, leaf.first + i), query_index_) ? 1 : 0;
    }
  }
  std::size_t count() const { return std::min(count_, k_); }

 private:
  const TreeView& tree_;
  const Bounds& box_;
  const PointQuery& query_;
  const std::size_t k_, query_index_;
  std::size_t count_ = 0;
};

std::size_t count_in(const TreeView& tree, const Bounds& box, const LatticeBox& steps,
                     const PointQuery& query, std::size_t k, std::size_t query_index) {
  BoxCounter counter(tree, box, query, k, query_index);
  if (!steps.empty()) BoxWalk(tree, steps, query.max_level, counter).run();
  return counter.count();
}

/// The points, in the order of the leaves.
class BoxFinder {
 public:
  BoxFinder(const TreeView& tree, const Bounds& box, const LatticeBox& steps, const PointQuery& query,
            std::size_t query_index)
      : tree_(tree), box_(box), steps_(steps), query_(query), query_index_(query_index) {}

  bool is_done() const { return false; }
  bool all(const Frame&, int) const { return false; }

  void leaf(const Leaf& leaf, std::uint32_t bits) {
    if (count_ + k_max_leaf_size + k_unpack_room > room_) grow();
    const std::size_t before = count_;
    count_ += unpack(tree_, leaf, bits, points_.get() + before);
    if (query_.filter) keep_admitted(before);
  }

  /// Appends the k points with the lowest ids.
  void finish(std::size_t k, std::vector<PointHit>& answers) {
    std::vector<SortKey> keys(count_);
    for (std::size_t i = 0; i < count_; ++i) keys[i] = point_id(tree_, points_[i].index) << 32 | i;
    if (count_ > k) {
      std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(k), keys.end());
      keys.resize(k);
    }
    sort_keys(keys);
    const std::size_t room = answers.size() + keys.size();
    if (answers.capacity() < room) answers.reserve(std::max(2 * answers.capacity(), room));
    for (const SortKey key : keys) {
      // Member by member: copying an answer from the stack would wait for its members to get there.
      PointHit& answer = answers.emplace_back();
      answer.point_id = key >> 32;
      answer.position = to_world(tree_.lattice, points_[number_of(key)].position);
    }
  }

 private:
  static constexpr std::size_t k_first_room = 512;
  static constexpr std::size_t k_many = 16384;

  /// Many points are counted, which takes far less time than moving them from one room to the next.
  void grow() {
    std::size_t room = std::max(2 * room_, k_first_room);
    if (room > k_many && !query_.filter)
      room = std::max(room_, count_in(tree_, box_, steps_, query_, k_all, query_index_)) + k_max_leaf_size +
             k_unpack_room;
    auto points = std::make_unique_for_overwrite<StoredPoint[]>(room);
    std::copy_n(points_.get(), count_, points.get());
    points_ = std::move(points);
    room_ = room;
  }

  void keep_admitted(std::size_t first) {
    const std::size_t end = std::exchange(count_, first);
    for (std::size_t i = first; i < end; ++i) {
      const StoredPoint point = points_[i];
      if (evaluate(box_, query_, to_world(tree_.lattice, point.position), point_id(tree_, point.index),
                   query_index_))
        points_[count_++] = point;
    }
  }

  const TreeView& tree_;
  const Bounds& box_;
  const LatticeBox& steps_;
  const PointQuery& query_;
  const std::size_t query_index_;
  std::size_t count_ = 0, room_ = 0;
  std::unique_ptr<StoredPoint[]> points_;
};

std::size_t count(const TreeView& tree, const Bounds& box, const PointQuery& query, std::size_t k,
                  std::size_t query_index) {
  return count_in(tree, box, LatticeBox(tree, box), query, k, query_index);
}

void find(const TreeView& tree, const Bounds& box, const PointQuery& query, std::size_t k,
          std::size_t query_index, std::vector<PointHit>& answers) {
  const LatticeBox steps(tree, box);
  if (steps.empty()) return;
  BoxFinder finder(tree, box, steps, query, query_index);
  BoxWalk(tree, steps, query.max_level, finder).run();
  finder.finish(k, answers);
}

constexpr Search<Bounds> k_box_search{find, count};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

template <>
const Search<Bounds>& search(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_box_search)
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
