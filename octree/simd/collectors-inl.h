// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_COLLECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_COLLECTORS_INL_H
#undef ALIDADE_SIMD_COLLECTORS_INL_H
#else
#define ALIDADE_SIMD_COLLECTORS_INL_H
#endif

#include <algorithm>
#include <bit>
#include <vector>

#include "octree/simd/box_walk-inl.h"
#include "octree/simd/first_answers.h"
#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"
#include "octree/simd/sort_keys.h"
#include "octree/tree_walk.h"

// What a search does with the points that lanes could not discard. Lanes find out of every point whether it
// may count, whether it certainly does, and limits of its measure; a *target* (octree/query_targets.h)
// decides in double. Lanes take measures as floats, counted from a shift near the points.

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// What lanes find out about the points of a leaf.
struct TestedPoints {
  std::uint32_t possible = 0;  ///< bit per point: may count
  std::uint32_t certain = 0;   ///< of these, those that do whatever rounding did; their measure is unknown
  alignas(64) float low[k_max_leaf_size];  ///< the measure lies between
  alignas(64) float high[k_max_leaf_size];
};

/// Decides one point in double.
template <class Target>
auto decide(const TreeView& tree, const Target& target, const Leaf& leaf, std::uint32_t index) {
  return target.evaluate(to_world(tree.lattice, position_of(tree, leaf, index)),
                         point_id(tree, leaf.first + index));
}

/// The k first points. Points that certainly count wait undecided until the search is over: most fall behind
/// the cut by then. The cut is the k-th smallest upper limit of a measure, so at least k points are before
/// everything behind it. Where too many limits overlap for waiting, points are decided on the way.
template <class Target>
class NearestCollector {
 public:
  using Answer = typename Target::Answer;
  static constexpr bool k_has_cut = true;
  static constexpr bool k_counts = false;

  /// Appends to `answers`. measure_shift: what floats count from. shift_error: of the difference of a measure
  /// and the shift.
  NearestCollector(const TreeView& tree, const Target& target, std::size_t k, double measure_shift,
                   double shift_error, std::vector<Answer>& answers)
      : tree_(tree),
        target_(target),
        k_(k),
        measure_shift_(measure_shift),
        shift_error_(shift_error),
        decided_(target, k, answers) {
    if (k <= k_most_sorted) {
      std::fill_n(highs_, k_lanes, -std::numeric_limits<float>::infinity());
      std::fill_n(highs_ + k_lanes, (k + k_lanes - 1) / k_lanes * k_lanes,
                  std::numeric_limits<float>::infinity());
    }
  }
  NearestCollector(const NearestCollector&) = delete;
  NearestCollector& operator=(const NearestCollector&) = delete;

  float cut() const { return cut_; }
  bool is_done() const { return false; }

  void add(const Leaf& leaf, const TestedPoints& points) {
    if (waiting_count_ + k_max_leaf_size > room_) make_room();
    for (std::uint32_t rest = points.certain; rest != 0; rest &= rest - 1) {
      const std::uint32_t i = index_of_lowest_bit(rest);
      waiting_[waiting_count_++] = {points.low[i], points.high[i], leaf.first + i,
                                    position_of(tree_, leaf, i)};
    }
    if (points.certain != 0) note_highs(points.high, points.certain);
    for (std::uint32_t rest = points.possible & ~points.certain; rest != 0; rest &= rest - 1) {
      const std::uint32_t i = index_of_lowest_bit(rest);
      if (points.low[i] > cut_) continue;
      const auto answer = decide(tree_, target_, leaf, i);
      if (!answer) continue;
      decided_.insert(*answer);
      const float high = at_least(target_.measured(*answer) - measure_shift_ + shift_error_);
      note_highs(&high, 1u);
      cut_at_decided();
    }
  }

  /// Puts the answers in order.
  void finish() {
    decide_waiting();
    decided_.finish();
  }

 private:
  struct Waiting {
    float low, high;
    std::uint32_t index;  ///< storage index
    LatticePosition position;
    bool operator<(const Waiting& other) const { return high < other.high; }
  };
  static constexpr std::size_t k_most_sorted = 64;
  static constexpr std::size_t k_lanes = 16;  ///< at least those of PointLanes
  static constexpr std::size_t k_few = 192;

  /// Points that count for certain; their measures are not above `highs`.
  void note_highs(const float* highs, std::uint32_t points) {
    if (k_ > k_most_sorted) return;
    // In a sorted list everything above a new value moves up by one, the last drops out.
    const PointLanes d;
    const std::size_t lanes = hn::Lanes(d);
    float* const sorted = highs_ + k_lanes;
    if (k_ <= lanes) {
      auto list = hn::Load(d, sorted);
      for (; points != 0; points &= points - 1) {
        const auto value = hn::Set(d, highs[index_of_lowest_bit(points)]);
        list = hn::Min(list, hn::Max(moved_up(d, list), value));
      }
      hn::Store(list, d, sorted);
    }
    for (; points != 0; points &= points - 1) {
      const float high = highs[index_of_lowest_bit(points)];
      if (!(high < sorted[k_ - 1])) continue;
      const auto value = hn::Set(d, high);
      for (std::size_t begin = (k_ - 1) / lanes * lanes;; begin -= lanes) {
        const auto moved = hn::Max(hn::LoadU(d, sorted + begin - 1), value);
        hn::Store(hn::Min(hn::Load(d, sorted + begin), moved), d, sorted + begin);
        if (begin == 0 || sorted[begin - 1] <= high) break;
      }
    }
    cut_ = std::min(cut_, sorted[k_ - 1]);
  }

  /// Lane i takes lane i - 1; the first one -infinity.
  static HWY_INLINE hn::Vec<PointLanes> moved_up(PointLanes d, hn::Vec<PointLanes> list) {
    const auto before = hn::Set(d, -std::numeric_limits<float>::infinity());
#if HWY_TARGET == HWY_AVX3
    return hn::Vec<PointLanes>{_mm512_castsi512_ps(
        _mm512_alignr_epi32(_mm512_castps_si512(list.raw), _mm512_castps_si512(before.raw), 15))};
#else
    alignas(64) float values[2 * k_lanes];
    hn::Store(before, d, values);
    hn::Store(list, d, values + hn::Lanes(d));
    return hn::LoadU(d, values + hn::Lanes(d) - 1);
#endif
  }

  void cut_at_decided() {
    if (decided_.limit() < std::numeric_limits<double>::infinity())
      cut_ = std::min(cut_, at_least(decided_.limit() - measure_shift_ + shift_error_));
  }

  /// For the points of one more leaf.
  void make_room() {
    if (k_ > k_most_sorted && waiting_count_ >= k_) {
      const auto kth = waiting_ + (k_ - 1);
      std::nth_element(waiting_, kth, waiting_ + waiting_count_);
      cut_ = std::min(cut_, kth->high);
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < waiting_count_; ++i)
      if (waiting_[i].low <= cut_) waiting_[kept++] = waiting_[i];
    waiting_count_ = kept;
    if (kept > room_ / 4 * 3 && k_ > k_most_sorted) grow();
    if (kept > room_ / 4 * 3) {
      decide_waiting();
      cut_at_decided();
    }
  }

  /// Towards room for twice k points: among so many, the k first are found without deciding all.
  /// As points come, since k may be no more than a cap.
  void grow() {
    std::vector<Waiting> more(std::min(2 * room_, 2 * k_ + k_few));
    if (more.size() <= room_) return;
    std::copy_n(waiting_, waiting_count_, more.begin());
    many_ = std::move(more);
    waiting_ = many_.data();
    room_ = many_.size();
  }

  void decide_waiting() {
    for (std::size_t i = 0; i < waiting_count_; ++i) {
      const Waiting& point = waiting_[i];
      if (point.low > cut_) continue;
      if (const auto answer =
              target_.evaluate(to_world(tree_.lattice, point.position), point_id(tree_, point.index)))
        decided_.insert(*answer);
    }
    waiting_count_ = 0;
  }

  const TreeView& tree_;
  const Target& target_;
  const std::size_t k_;
  const double measure_shift_, shift_error_;
  FirstAnswers<Target> decided_;
  float cut_ = std::numeric_limits<float>::infinity();
  std::size_t waiting_count_ = 0, room_ = k_few;
  Waiting* waiting_ = few_;
  std::vector<Waiting> many_;
  alignas(64) float highs_[k_lanes +
                           k_most_sorted];  ///< the k smallest upper limits; what is before is -infinity
  Waiting few_[k_few];
};

/// All points. Count: counts them without collecting, or nothing (0).
template <class Target, class Count>
class AllCollector {
 public:
  using Answer = typename Target::Answer;
  static constexpr bool k_has_cut = false;
  static constexpr bool k_counts = false;

  AllCollector(const TreeView& tree, const Target& target, const Count& count, std::vector<Answer>& answers)
      : tree_(tree), target_(target), count_(count), answers_(answers), first_(answers.size()) {}

  float cut() const { return std::numeric_limits<float>::infinity(); }
  bool is_done() const { return false; }

  void add(const Leaf& leaf, const TestedPoints& points) {
    StoredPoint stored[k_max_leaf_size + k_unpack_room];
    const std::size_t count = unpack(tree_, leaf, points.possible, stored);
    for (std::size_t i = 0; i < count; ++i) {
      if (const auto answer =
              target_.evaluate(to_world(tree_.lattice, stored[i].position), point_id(tree_, stored[i].index)))
        answers_.push_back(*answer);
    }
    if (is_counted_ || answers_.size() - first_ < k_many) return;
    // Moving many answers again and again takes longer than counting them.
    is_counted_ = true;
    const std::size_t room = first_ + count_();
    if (answers_.capacity() < room) answers_.reserve(std::max(2 * answers_.capacity(), room));
  }

  void finish() { sort_answers(target_, first_, answers_); }

 private:
  static constexpr std::size_t k_many = 1024;

  const TreeView& tree_;
  const Target& target_;
  const Count& count_;
  std::vector<Answer>& answers_;
  const std::size_t first_;
  bool is_counted_ = false;
};

/// How many points, up to k.
template <class Target>
class CountCollector {
 public:
  static constexpr bool k_has_cut = false;
  static constexpr bool k_counts = true;

  CountCollector(const TreeView& tree, const Target& target, std::size_t k)
      : tree_(tree), target_(target), k_(k) {}

  float cut() const { return std::numeric_limits<float>::infinity(); }
  bool is_done() const { return count_ >= k_; }
  std::size_t count() const { return std::min(count_, k_); }

  /// Points that count for certain.
  void add(std::uint32_t count) { count_ += count; }

  void add(const Leaf& leaf, const TestedPoints& points) {
    count_ += static_cast<std::size_t>(std::popcount(points.certain));
    for (std::uint32_t rest = points.possible & ~points.certain; rest != 0 && !is_done(); rest &= rest - 1)
      count_ += decide(tree_, target_, leaf, index_of_lowest_bit(rest)) ? 1 : 0;
  }

 private:
  const TreeView& tree_;
  const Target& target_;
  const std::size_t k_;
  std::size_t count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
