// SPDX-License-Identifier: MIT
#include "cloud/sorted_points.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_reduce.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "cloud/lattice.h"

namespace alidade {

/// Key ranges of about equal numbers of points, for sorting range by range. A key that very many points of
/// the cloud have gets a range of its own.
template <class Key>
class KeyBuckets {
 public:
  /// Numbers of buckets fit well into 16 bits.
  static constexpr std::size_t k_max_count = 4096;
  static constexpr std::size_t k_samples_per_bucket = 16;

  /// `samples`: keys of evenly chosen points, k_samples_per_bucket for every wanted bucket.
  explicit KeyBuckets(std::vector<Key> samples) {
    std::ranges::sort(samples);
    std::vector<Key> limits;
    for (std::size_t i = k_samples_per_bucket; i < samples.size(); i += k_samples_per_bucket) {
      if (limits.empty() || samples[i] > limits.back()) {
        limits.push_back(samples[i]);
      } else if (samples[i] == limits.back()) {
        limits.push_back(samples[i] + 1);  // ends the bucket of this very key
      }
    }
    count_ = limits.size() + 1;
    limits.resize(std::bit_ceil(count_), ~Key{0});
    limits_ = std::move(limits);
  }

  std::size_t count() const { return count_; }

  /// The buckets of several keys at once, so that the processor overlaps the searches.
  template <std::size_t width>
  void find(const std::array<Key, width>& keys, std::uint16_t* buckets) const {
    std::array<std::size_t, width> low{};
    for (std::size_t step = limits_.size() / 2; step > 0; step /= 2) {
      for (std::size_t i = 0; i < width; ++i) low[i] += limits_[low[i] + step - 1] <= keys[i] ? step : 0;
    }
    for (std::size_t i = 0; i < width; ++i) buckets[i] = static_cast<std::uint16_t>(low[i]);
  }

 private:
  std::size_t count_ = 1;
  std::vector<Key> limits_;  ///< lower ends of all buckets but the first, then keys above all; 2^n of them
};

/// Sorts entries by key from `from` into `to`; equal keys keep their order. Uses up `from`. Radix sort from
/// the highest bit in which keys differ, with insertion sort for small groups. `k_max_digit_bits` is that of
/// the first pass; later ones use fewer, to stay small on the stack.
template <class Entry, int k_max_digit_bits = 12>
void sort_by_key(Entry* from, Entry* to, std::size_t count) {
  using Key = typename Entry::Key;
  constexpr std::size_t k_small = 24;
  if (count <= k_small) {
    for (std::size_t i = 0; i < count; ++i) {
      const Entry entry = from[i];
      const Key key = entry.key();
      std::size_t at = i;
      for (; at > 0 && key < to[at - 1].key(); --at) to[at] = to[at - 1];
      to[at] = entry;
    }
    return;
  }
  const Key first = from[0].key();
  Key difference = 0;
  for (std::size_t i = 1; i < count; ++i) difference |= from[i].key() ^ first;
  if (difference == 0) {
    std::memcpy(to, from, count * sizeof(Entry));
    return;
  }
  // Groups of about four entries where keys are evenly spread.
  const int digit_bits = std::clamp(static_cast<int>(std::bit_width(count)) - 3, 1, k_max_digit_bits);
  const int shift = std::max(0, highest_bit(difference) + 1 - digit_bits);
  const auto digit_of = [&](const Entry& entry) {
    return static_cast<std::uint32_t>(entry.key() >> shift) & ((1u << digit_bits) - 1u);
  };
  std::array<std::uint32_t, std::size_t{1} << k_max_digit_bits> end;
  const std::size_t digit_count = std::size_t{1} << digit_bits;
  std::fill_n(end.begin(), digit_count, 0u);
  for (std::size_t i = 0; i < count; ++i) ++end[digit_of(from[i])];
  std::uint32_t begin = 0;
  for (std::size_t digit = 0; digit < digit_count; ++digit) begin += std::exchange(end[digit], begin);
  for (std::size_t i = 0; i < count; ++i) to[end[digit_of(from[i])]++] = from[i];
  if (shift == 0) return;
  begin = 0;
  for (std::size_t digit = 0; digit < digit_count; ++digit) {
    const std::uint32_t group = end[digit] - begin;
    if (group > 1) {
      std::memcpy(from + begin, to + begin, group * sizeof(Entry));
      sort_by_key<Entry, 8>(from + begin, to + begin, group);
    }
    begin = end[digit];
  }
}

// Points are sorted in two steps. Chunks of the input, each small enough for the cache, are partitioned into
// some thousand key ranges (buckets) of about equal size. Then each bucket is collected from all chunks,
// sorted in the cache and written to its final position. Both steps are independent work for any number of
// threads, every point is moved through memory only twice, and the input can be released while the second
// step reads it. Both steps are stable, so equal keys are in the order of their ids.

namespace {

constexpr std::size_t k_points_per_task = std::size_t{1} << 16;
constexpr std::size_t k_max_chunk_size = std::size_t{1} << 18;
constexpr std::size_t k_min_chunk_size = std::size_t{1} << 12;
constexpr std::size_t k_bucket_size = std::size_t{1} << 15;
// Buckets are collected from all chunks at once, so each chunk has one or two blocks that are partly used up.
constexpr std::size_t k_release_block = std::size_t{1} << 16;
constexpr std::size_t k_scratch_release_block = std::size_t{1}
                                                << 21;  ///< larger, as a hole in a file costs more

std::uint32_t steps_from(std::int32_t base, std::int32_t value) {
  return static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(base);
}

template <class Entry>
class Sorter {
  using Key = typename Entry::Key;

 public:
  /// `given` is the vector behind `positions` if it is to be used up, otherwise null; `scratch` if they lie
  /// in a scratch file that is to be used up, otherwise null.
  Sorter(const KeySpace& space, std::span<const LatticePosition> positions,
         std::vector<LatticePosition>* given, const ScratchSpace* scratch = nullptr)
      : space_(space),
        positions_(positions),
        given_(given),
        chunk_size_(chunk_size(positions.size(), scratch)),
        chunk_count_((positions.size() + chunk_size_ - 1) / chunk_size_),
        buckets_(sample_keys()) {
    if (scratch) scratch_folder_ = scratch->folder;
    if (!in_place()) chunks_ = HugeArray<Entry>(positions.size(), scratch_folder_);
    const std::size_t block = scratch ? k_scratch_release_block : k_release_block;
    chunk_release_ = PageRelease(chunk_bytes(0), positions.size() * sizeof(Entry), block, scratch != nullptr);
    if (uses_up_positions()) {
      position_release_ = PageRelease(const_cast<LatticePosition*>(positions.data()), positions.size_bytes(),
                                      block, scratch != nullptr);
    }
    run_begin_.resize(chunk_count_ * (buckets_.count() + 1));
  }

  SortedPoints<Entry> run() {
    in_parallel(chunk_count_, 1, [&](std::size_t chunk) { partition_chunk(chunk); });
    std::vector<std::size_t> bucket_begin(buckets_.count() + 1);
    for (std::size_t chunk = 0; chunk < chunk_count_; ++chunk) {
      for (std::size_t bucket = 0; bucket < buckets_.count(); ++bucket)
        bucket_begin[bucket + 1] += run_size(chunk, bucket);
    }
    for (std::size_t bucket = 0; bucket < buckets_.count(); ++bucket)
      bucket_begin[bucket + 1] += bucket_begin[bucket];
    SortedPoints<Entry> sorted(positions_.size(), scratch_folder_);
    in_parallel(buckets_.count(), 1, [&](std::size_t bucket) {
      sort_bucket(bucket, sorted.data() + bucket_begin[bucket],
                  bucket_begin[bucket + 1] - bucket_begin[bucket]);
    });
    if (given_) std::vector<LatticePosition>().swap(*given_);
    return sorted;
  }

 private:
  struct Scratch {
    HugeArray<Entry> entries;
    std::vector<std::uint16_t> buckets;

    Entry* room_for(std::size_t count) {
      if (entries.size() < count) entries = HugeArray<Entry>(count);
      return entries.data();
    }
  };

  static std::size_t chunk_size(std::size_t count, const ScratchSpace* scratch) {
    const std::size_t usual = std::clamp(std::bit_ceil(count / 64 + 1), k_min_chunk_size, k_max_chunk_size);
    if (!scratch) return usual;
    // Fewer chunks have longer runs for each bucket, which are faster to read from disk. A thread has the
    // entries of a chunk in its scratch memory and in the file, and the positions.
    const std::size_t threads = thread_count();
    const std::size_t bytes_of_point = 2 * sizeof(Entry) + sizeof(std::uint16_t) + sizeof(LatticePosition);
    return std::clamp(std::bit_floor(scratch->memory / threads / bytes_of_point), usual,
                      std::max(usual, std::bit_ceil(count / threads + 1)));
  }

  /// Whether entries replace the positions that they are made of, as narrow ones do.
  bool in_place() const { return given_ && sizeof(Entry) == sizeof(LatticePosition); }
  bool uses_up_positions() const { return (given_ && !in_place()) || scratch_folder_; }

  /// Memory of the partitioned chunks. Only bytes are copied to and from it, as it may be that of the
  /// positions.
  std::byte* chunk_bytes(std::size_t first_entry) {
    std::byte* const bytes = in_place() ? reinterpret_cast<std::byte*>(given_->data())
                                        : reinterpret_cast<std::byte*>(chunks_.data());
    return bytes + first_entry * sizeof(Entry);
  }

  std::uint32_t* run_begins(std::size_t chunk) { return run_begin_.data() + chunk * (buckets_.count() + 1); }
  std::uint32_t run_size(std::size_t chunk, std::size_t bucket) {
    return run_begins(chunk)[bucket + 1] - run_begins(chunk)[bucket];
  }

  Entry entry_of(std::size_t row) const {
    return Entry::make(Steps(positions_[row]) - Steps(space_.base), static_cast<std::uint32_t>(row));
  }

  std::vector<Key> sample_keys() const {
    const std::size_t count = positions_.size();
    const std::size_t sample_count =
        std::clamp<std::size_t>(count / k_bucket_size, 1, KeyBuckets<Key>::k_max_count) *
        KeyBuckets<Key>::k_samples_per_bucket;
    std::vector<Key> samples;
    if (count <= sample_count) return samples;
    for (std::size_t i = 0; i < sample_count; ++i)
      samples.push_back(entry_of(count / sample_count * i).key());
    return samples;
  }

  void partition_chunk(std::size_t chunk) {
    const std::size_t first_row = chunk * chunk_size_;
    const std::size_t count = std::min(chunk_size_, positions_.size() - first_row);
    Scratch& scratch = scratch_.local();
    Entry* const entries = scratch.room_for(count);
    std::uint32_t* const begins = run_begins(chunk);

    constexpr std::size_t k_width = 8;
    scratch.buckets.resize(count + k_width);
    for (std::size_t i = 0; i < count; i += k_width) {
      std::array<Key, k_width> keys{};
      const std::size_t width = std::min(k_width, count - i);
      for (std::size_t k = 0; k < width; ++k) {
        entries[i + k] = entry_of(first_row + i + k);
        keys[k] = entries[i + k].key();
      }
      buckets_.find(keys, scratch.buckets.data() + i);
      for (std::size_t k = 0; k < width; ++k) ++begins[scratch.buckets[i + k] + 1];
    }
    if (uses_up_positions())
      position_release_.use_up(first_row * sizeof(LatticePosition), count * sizeof(LatticePosition));

    for (std::size_t bucket = 0; bucket < buckets_.count(); ++bucket) begins[bucket + 1] += begins[bucket];
    std::vector<std::uint32_t> next(begins, begins + buckets_.count());
    for (std::size_t i = 0; i < count; ++i)
      std::memcpy(chunk_bytes(first_row + next[scratch.buckets[i]]++), entries + i, sizeof(Entry));
  }

  void sort_bucket(std::size_t bucket, Entry* target, std::size_t count) {
    if (count == 0) return;
    // A bucket too large for the scratch memory has one key (KeyBuckets), rarely a few. Sort it in place.
    const bool is_large = count > 8 * std::max(k_bucket_size, positions_.size() / buckets_.count());
    Entry* const collected = is_large ? target : scratch_.local().room_for(count);
    std::size_t filled = 0;
    for (std::size_t chunk = 0; chunk < chunk_count_; ++chunk) {
      const std::size_t first = chunk * chunk_size_ + run_begins(chunk)[bucket],
                        run = run_size(chunk, bucket);
      if (run == 0) continue;
      std::memcpy(collected + filled, chunk_bytes(first), run * sizeof(Entry));
      filled += run;
      chunk_release_.use_up(first * sizeof(Entry), run * sizeof(Entry));
    }
    const auto less = [](const Entry& a, const Entry& b) {
      const Key key_a = a.key(), key_b = b.key();
      return key_a != key_b ? key_a < key_b : a.id < b.id;
    };
    if (!is_large) {
      sort_by_key(collected, target, count);
    } else if (!std::is_sorted(target, target + count, less)) {
      std::sort(target, target + count, less);
    }
  }

  const KeySpace space_;
  const std::span<const LatticePosition> positions_;
  std::vector<LatticePosition>* const given_;
  ScratchFolder scratch_folder_;
  PageRelease position_release_;  ///< if the chunks are not in the memory of the positions
  PageRelease chunk_release_;
  const std::size_t chunk_size_;
  const std::size_t chunk_count_;
  const KeyBuckets<Key> buckets_;
  HugeArray<Entry> chunks_;
  /// The begin of each bucket's run in each chunk, from the chunk's begin, and the end of the last.
  std::vector<std::uint32_t> run_begin_;
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

LatticeExtent extent_of(std::span<const LatticePosition> positions) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, positions.size(), k_points_per_task), LatticeExtent{},
      [&](const tbb::blocked_range<std::size_t>& range, LatticeExtent part) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) part.grow(positions[i]);
        return part;
      },
      [](LatticeExtent a, const LatticeExtent& b) {
        a.grow(b.low);
        a.grow(b.high);
        return a;
      });
}

}  // namespace

KeySpace key_space(std::span<const LatticePosition> positions) {
  if (positions.empty()) return {};
  const LatticeExtent extent = extent_of(positions);
  std::uint32_t largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max(largest, steps_from(extent.low[axis], extent.high[axis]));
  return {extent.low, static_cast<int>(std::bit_width(largest))};
}

KeySpace aligned_key_space(const std::vector<LatticePosition>& positions) {
  if (positions.empty()) return {};
  const LatticeExtent extent = extent_of(positions);
  constexpr std::int32_t k_lowest = -2147483647 - 1;
  std::uint32_t differing = 0;
  for (int axis = 0; axis < 3; ++axis)
    differing |= steps_from(k_lowest, extent.low[axis]) ^ steps_from(k_lowest, extent.high[axis]);
  KeySpace space{LatticePosition(k_lowest), static_cast<int>(std::bit_width(differing))};
  const std::uint32_t kept = space.extent_bits == 32 ? 0 : ~std::uint32_t{0} << space.extent_bits;
  // Bits above are equal in all positions.
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint32_t common = steps_from(k_lowest, extent.low[axis]) & kept;
    space.base[axis] = static_cast<std::int32_t>(common + static_cast<std::uint32_t>(k_lowest));
  }
  return space;
}

template <class Entry>
SortedPoints<Entry> sort_points(const KeySpace& space, const std::vector<LatticePosition>& positions) {
  return Sorter<Entry>(space, positions, nullptr).run();
}

template <class Entry>
SortedPoints<Entry> sort_points(const KeySpace& space, std::vector<LatticePosition>&& positions) {
  return Sorter<Entry>(space, positions, &positions).run();
}

template <class Entry>
SortedPoints<Entry> sort_points(const KeySpace& space, std::span<LatticePosition> positions,
                                const ScratchSpace& scratch) {
  return Sorter<Entry>(space, positions, nullptr, &scratch).run();
}

template SortedPoints<NarrowEntry> sort_points(const KeySpace&, const std::vector<LatticePosition>&);
template SortedPoints<WideEntry> sort_points(const KeySpace&, const std::vector<LatticePosition>&);
template SortedPoints<NarrowEntry> sort_points(const KeySpace&, std::vector<LatticePosition>&&);
template SortedPoints<WideEntry> sort_points(const KeySpace&, std::vector<LatticePosition>&&);
template SortedPoints<NarrowEntry> sort_points(const KeySpace&, std::span<LatticePosition>,
                                               const ScratchSpace&);
template SortedPoints<WideEntry> sort_points(const KeySpace&, std::span<LatticePosition>,
                                             const ScratchSpace&);

}  // namespace alidade
