// SPDX-License-Identifier: MIT
#include "octree/simd/search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/box_search.cpp"
#include <hwy/foreach_target.h>

#include "octree/candidate.h"
#include "octree/simd/box_walk-inl.h"
#include "octree/simd/choose_table.h"
#include "octree/simd/first_answers.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// The points, in the order of the leaves.
class BoxFinder {
 public:
  BoxFinder(const TreeView& tree, const Bounds& box, const PointQuery& query, std::size_t query_index)
      : tree_(tree), box_(box), query_(query), query_index_(query_index) {}

  bool is_done() const { return false; }
  bool all(const Frame&, int) const { return false; }

  void leaf(const Leaf& leaf, std::uint32_t points) {
    if (count_ + k_max_leaf_size > keys_.size()) {
      keys_.resize(2 * keys_.size() + k_first_room);
      positions_.resize(keys_.size());
    }
    if (query_.filter || (tree_.positions && leaf.first >= tree_.first_exact)) {
      for (; points != 0; points &= points - 1) {
        const std::uint32_t i = index_of_lowest_bit(points);
        const std::uint64_t id = point_id(tree_, leaf.first + i);
        const LatticePosition position = position_of(tree_, leaf, i);
        if (!query_.filter || evaluate(box_, query_, to_world(tree_.lattice, position), id, query_index_))
          add(id, position);
      }
      return;
    }
    // What position_of() does, with what is the same for all points of the leaf taken out of the loop.
    const std::uint16_t* const x = tree_.coordinates + std::size_t{3} * leaf.first;
    const std::uint16_t *const y = x + leaf.count, *const z = y + leaf.count;
    std::uint32_t corner[3];
    for (int axis = 0; axis < 3; ++axis)
      corner[axis] = static_cast<std::uint32_t>(tree_.base[axis]) + leaf.corner[axis];
    for (; points != 0; points &= points - 1) {
      const std::uint32_t i = index_of_lowest_bit(points);
      add(point_id(tree_, leaf.first + i),
          {static_cast<std::int32_t>(corner[0] + x[i]), static_cast<std::int32_t>(corner[1] + y[i]),
           static_cast<std::int32_t>(corner[2] + z[i])});
    }
  }

  /// Appends the k points with the lowest ids.
  void finish(std::size_t k, std::vector<PointHit>& answers) {
    keys_.resize(count_);
    sort_by_id(keys_, k);
    const std::size_t room = answers.size() + keys_.size();
    if (answers.capacity() < room) answers.reserve(std::max(2 * answers.capacity(), room));
    for (const IdKey key : keys_)
      answers.push_back({key >> 32, to_world(tree_.lattice, positions_[key & 0xffffffffu]), 0.0});
  }

 private:
  static constexpr std::size_t k_first_room = 256;

  void add(std::uint64_t id, const LatticePosition& position) {
    keys_[count_] = id << 32 | count_;
    positions_[count_++] = position;
  }

  const TreeView& tree_;
  const Bounds& box_;
  const PointQuery& query_;
  const std::size_t query_index_;
  std::size_t count_ = 0;
  std::vector<IdKey> keys_;  ///< longer than count_, as positions_
  std::vector<LatticePosition> positions_;
};

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

std::size_t count(const TreeView& tree, const Bounds& box, const PointQuery& query, std::size_t k,
                  std::size_t query_index) {
  const LatticeBox steps(tree, box);
  BoxCounter counter(tree, box, query, k, query_index);
  if (!steps.empty()) BoxWalk(tree, steps, query.max_level, counter).run();
  return counter.count();
}

void find(const TreeView& tree, const Bounds& box, const PointQuery& query, std::size_t k,
          std::size_t query_index, std::vector<PointHit>& answers) {
  const LatticeBox steps(tree, box);
  if (steps.empty()) return;
  BoxFinder finder(tree, box, query, query_index);
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
