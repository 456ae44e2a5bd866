// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/concurrent_queue.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/morton.h"
#include "base/parallel.h"
#include "octree/answer_target.h"
#include "octree/check_query.h"
#include "octree/octree.h"
#include "octree/simd/ray_state.h"
#include "octree/simd/sort_keys.h"

// Many rays to `closest` or `occluded`: through the tree together, those that lanes do not answer one by one.
// And the order of targets along a curve, of points as well.

namespace alidade {

/// Brings targets, given by their numbers in the lower halves, into an order in which each is near the one
/// before. position(number): of a target; group(number): below k_groups, the groups one after another. Targets
/// at one position stay as they are.
template <std::uint64_t k_groups, class Position, class Group>
void sort_along_curve(const Position& position, const Group& group, std::vector<simd::SortKey>& numbers) {
  constexpr int k_bits = k_groups == 1 ? 10 : 9;
  static_assert(k_groups <= 1u << (32 - 3 * k_bits));
  Bounds bounds;
  for (const simd::SortKey key : numbers) bounds.grow(position(simd::number_of(key)));
  const glm::dvec3 size = bounds.size();
  const double widest = std::max({size.x, size.y, size.z});
  constexpr double k_least = 1e-290;  // its inverse times any number of cells is finite
  if (!(widest >= k_least) || std::isinf(widest)) return;
  const double cells = ((1 << k_bits) - 1) / widest;
  for (simd::SortKey& key : numbers) {
    const glm::dvec3 cell = (position(simd::number_of(key)) - bounds.min) * cells;
    const std::uint64_t along =
        morton_key(static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y),
                   static_cast<std::uint32_t>(cell.z));
    key = simd::number_of(key) | (along | std::uint64_t{group(simd::number_of(key))} << (3 * k_bits)) << 32;
  }
  simd::sort_keys(numbers);
}
template <class Position>
void sort_along_curve(const Position& position, std::vector<simd::SortKey>& numbers) {
  sort_along_curve<1>(
      position, [](std::uint32_t) { return 0u; }, numbers);
}

// Rays that go through the tree together: the more, the more often they share a node; the fewer, the longer
// their states stay in the second-level cache. Small batches are cut into smaller pieces, so that no thread
// is idle.
constexpr std::size_t k_least_stream_rays = 256, k_most_stream_rays = 12288;
constexpr std::size_t k_most_sorted = std::size_t{1} << 20;  // targets; bounds the memory for their order
inline std::size_t stream_grain(std::size_t rays) {
  const std::size_t threads = thread_count();
  return threads == 1 ? k_most_stream_rays
                      : std::clamp(rays / (16 * threads), k_least_stream_rays, k_most_stream_rays);
}

/// Rays and answers of one task. Tasks hand their memory on, since new memory costs more than what is done
/// with it.
template <class Answer>
class RoomOfTasks {
 public:
  struct Room {
    std::vector<Ray> rays;
    std::vector<Answer> answers;
  };

  /// Calls use(rays, answers) with room for so many.
  template <class Use>
  void with_room(std::size_t count, const Use& use) {
    std::unique_ptr<Room> room;
    if (!free_.try_pop(room)) room = std::make_unique<Room>();
    if (room->rays.size() < count) {
      room->rays.resize(count);
      room->answers.resize(count);
    }
    use(std::span(room->rays).first(count), std::span(room->answers).first(count));
    free_.push(std::move(room));
  }

 private:
  tbb::concurrent_queue<std::unique_ptr<Room>> free_;
};

/// An array of rays, and one for their answers.
template <class AnswerOfRay>
class RaysInMemory {
 public:
  using Answer = AnswerOfRay;

  RaysInMemory(std::span<const Ray> rays, std::span<Answer> answers) : rays_(rays), answers_(answers) {
    check_room(rays.size(), answers.size());
  }

  std::size_t size() const { return rays_.size(); }
  const glm::dvec3& origin(std::size_t number) const { return rays_[number].origin; }
  const glm::dvec3& direction(std::size_t number) const { return rays_[number].direction; }
  void check(std::size_t first, std::size_t last) const { check_range(rays_, first, last); }

  template <class Trace>
  void answer_range(std::size_t first, std::size_t last, const Trace& trace) const {
    trace(rays_.subspan(first, last - first), first, answers_.subspan(first, last - first));
  }
  void copy_rays(std::size_t begin, std::span<const simd::SortKey> numbers, std::span<Ray> rays) const {
    for (std::size_t i = 0; i < rays.size(); ++i) rays[i] = rays_[begin + simd::number_of(numbers[i])];
  }
  void put(std::size_t begin, std::span<const simd::SortKey> numbers, std::span<const Answer> answers) const {
    for (std::size_t i = 0; i < answers.size(); ++i)
      answers_[begin + simd::number_of(numbers[i])] = answers[i];
  }

 private:
  const std::span<const Ray> rays_;
  const std::span<Answer> answers_;
};

/// Calls trace(rays, first_index, answers) for parts of a batch of rays whose origins are scattered. Those of
/// a part are of one octant, or of a few, and start side by side, so that they share their way through the
/// tree. The order costs some 30 ns per ray. Rays that bounce off surfaces, shuffled, take 0.6 to 0.7 of the
/// time side by side, and 0.8 to 0.9 of that by octants. Indices are those of the parts.
template <class Batch, class Trace>
void trace_side_by_side(const Bounds& bounds, const Batch& batch, const Trace& trace) {
  using Answer = typename Batch::Answer;
  in_blocks(batch.size(), k_least_stream_rays,
            [&](std::size_t first, std::size_t last) { batch.check(first, last); });
  RoomOfTasks<Answer> rooms;
  for (std::size_t begin = 0; begin < batch.size(); begin += k_most_sorted) {
    std::vector<simd::SortKey> order(std::min(k_most_sorted, batch.size() - begin));
    std::iota(order.begin(), order.end(), simd::SortKey{0});
    const auto start = [&](std::uint32_t number) {
      // NaN becomes the minimum: rays in columns are not checked yet.
      return glm::min(bounds.max, glm::max(bounds.min, batch.origin(begin + number)));
    };
    const auto octant = [&](std::uint32_t number) {
      return simd::octant_of(batch.direction(begin + number));
    };
    sort_along_curve<8>(start, octant, order);
    in_blocks(order.size(), stream_grain(order.size()), [&](std::size_t first, std::size_t last) {
      const std::span<const simd::SortKey> numbers = std::span(order).subspan(first, last - first);
      rooms.with_room(numbers.size(), [&](std::span<Ray> rays, std::span<Answer> answers) {
        batch.copy_rays(begin, numbers, rays);
        trace(std::span<const Ray>(rays), std::size_t{0}, answers);
        batch.put(begin, numbers, std::span<const Answer>(answers));
      });
    });
  }
}

/// Answers a batch of rays with stream(rays, first_index, answers), which takes those that suit_traversal(),
/// and with trace_one(ray, query_index). in_lanes: whether any may go to the stream. by_index: the query
/// goes by the index of the ray, which sorting changes.
template <class Batch, class Stream, class TraceOne>
void trace_batch(const TreeView& tree, const Batch& batch, bool in_lanes, bool by_index, const Stream& stream,
                 const TraceOne& trace_one) {
  using Answer = typename Batch::Answer;
  if (tree.point_count == 0 || !in_lanes) {
    const auto trace_each = [&](std::span<const Ray> rays, std::size_t first_index,
                                std::span<Answer> answers) {
      for (std::size_t i = 0; i < rays.size(); ++i) answers[i] = trace_one(rays[i], first_index + i);
    };
    in_blocks(batch.size(), k_least_stream_rays, [&](std::size_t first, std::size_t last) {
      batch.check(first, last);
      batch.answer_range(first, last, trace_each);
    });
    return;
  }
  // Rays that suit the traversal are valid. The others are few, and are checked one by one.
  const auto trace = [&](std::span<const Ray> rest, std::size_t first_index, std::span<Answer> room,
                         const auto& check) {
    while (!rest.empty()) {
      const auto suiting = static_cast<std::size_t>(
          std::ranges::find_if_not(rest, [](const Ray& ray) { return suits_traversal(ray); }) - rest.begin());
      if (suiting > 0) stream(rest.first(suiting), first_index, room.first(suiting));
      if (suiting == rest.size()) return;
      check(first_index + suiting);
      room[suiting] = trace_one(rest[suiting], first_index + suiting);
      rest = rest.subspan(suiting + 1);
      room = room.subspan(suiting + 1);
      first_index += suiting + 1;
    }
  };
  const auto origin = [&](std::size_t number) { return batch.origin(number); };
  if (batch.size() >= 4 * k_most_stream_rays && !by_index &&
      !simd::start_side_by_side(tree.extent, batch.size(), origin))
    return trace_side_by_side(tree.bounds, batch, [&](auto rays, std::size_t first_index, auto answers) {
      trace(rays, first_index, answers, [](std::size_t) {});
    });
  in_blocks(batch.size(), stream_grain(batch.size()), [&](std::size_t first, std::size_t last) {
    batch.answer_range(first, last, [&](auto rays, std::size_t first_index, auto answers) {
      trace(rays, first_index, answers, [&](std::size_t i) { batch.check(i, i + 1); });
    });
  });
}

}  // namespace alidade
