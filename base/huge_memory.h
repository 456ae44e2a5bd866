// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace alidade {

/// Bytes that are free without swapping, of the machine and of the control group that limits this process;
/// empty where the system does not report them.
std::optional<std::uint64_t> available_memory();

/// Lets a large task fail before it starts. Errors: this many bytes are more than the machine has available;
/// they name `what` the bytes are for. If the system reports nothing, nothing is rejected.
void check_memory(std::uint64_t bytes, const char* what);

/// Uninitialised memory, aligned to at least 64 bytes. From 2 MiB on it is aligned to 2 MiB and requests huge
/// pages from the system: an index jumps through all of its memory, and with pages of 4 KiB most of these
/// jumps would miss the table of page addresses as well. Errors: std::bad_alloc.
void* take_pages(std::size_t byte_count);
/// Memory in a scratch file in `folder` (base/scratch_file.h), which the system keeps in memory as far as
/// there is room. Less than 2 MiB is taken from memory. Errors: those of map_scratch_pages().
void* take_pages(std::size_t byte_count, const std::filesystem::path& folder);
/// `byte_count` as given to take_pages().
void give_back_pages(void* pages, std::size_t byte_count) noexcept;

/// Requests huge pages for memory of another origin, before it is first used.
void request_huge_pages(void* memory, std::size_t byte_count) noexcept;

/// Lets malloc keep what is freed, up to some 128 MB per thread, for what is taken next. For a program as a
/// whole to decide: pictures are traced in waves that take the same megabytes again and again, and without
/// this each wave gets its pages from the system, which clears them: up to a third of the time.
void keep_freed_memory();

/// Where large arrays lie: in memory, or in scratch files in a folder.
using ScratchFolder = std::optional<std::filesystem::path>;

/// A large array of plain values in such memory; values are not set. Fixed size, movable.
template <class Value>
class HugeArray {
  static_assert(std::is_trivially_copyable_v<Value> && alignof(Value) <= 64);

 public:
  HugeArray() = default;
  explicit HugeArray(std::size_t size, const ScratchFolder& scratch = {}) : size_(size) {
    if (size == 0) return;
    const std::size_t bytes = size * sizeof(Value);
    values_ = static_cast<Value*>(scratch ? take_pages(bytes, *scratch) : take_pages(bytes));
  }
  HugeArray(HugeArray&& other) noexcept
      : values_(std::exchange(other.values_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  HugeArray& operator=(HugeArray&& other) noexcept {
    std::swap(values_, other.values_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~HugeArray() {
    if (values_) give_back_pages(values_, size_ * sizeof(Value));
  }

  Value* data() { return values_; }
  const Value* data() const { return values_; }
  std::size_t size() const { return size_; }
  Value& operator[](std::size_t i) { return values_[i]; }
  const Value& operator[](std::size_t i) const { return values_[i]; }

 private:
  Value* values_ = nullptr;
  std::size_t size_ = 0;
};

/// Allocates the values of containers in such memory.
template <class Value>
class PageAllocator {
 public:
  using value_type = Value;
  using is_always_equal = std::true_type;  // give_back_pages() takes pages of any origin
  using propagate_on_container_copy_assignment = std::true_type;
  using propagate_on_container_move_assignment = std::true_type;
  using propagate_on_container_swap = std::true_type;

  PageAllocator() = default;
  // No move: an allocator that was moved from must still equal its copy.
  PageAllocator(const PageAllocator&) = default;
  PageAllocator& operator=(const PageAllocator&) = default;
  PageAllocator(const ScratchFolder& scratch)
      : scratch_(scratch ? std::make_shared<const std::filesystem::path>(*scratch) : nullptr) {}
  template <class Other>
  PageAllocator(const PageAllocator<Other>& other) : scratch_(other.scratch()) {}

  Value* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(Value);
    return static_cast<Value*>(scratch_ ? take_pages(bytes, *scratch_) : take_pages(bytes));
  }
  void deallocate(Value* values, std::size_t count) { give_back_pages(values, count * sizeof(Value)); }

  const std::shared_ptr<const std::filesystem::path>& scratch() const { return scratch_; }
  bool operator==(const PageAllocator&) const { return true; }

 private:
  std::shared_ptr<const std::filesystem::path> scratch_{};  ///< null: in memory
};

/// A vector in such memory: HugeVector<float> values(size, 0.0f, octree.scratch()).
template <class Value>
using HugeVector = std::vector<Value, PageAllocator<Value>>;

/// Returns memory to the system while its contents are consumed, in any order and from many threads: a block
/// as soon as its last byte was used. So an array can move into another one without memory for both.
class PageRelease {
 public:
  PageRelease() = default;
  /// The memory must stay allocated while bytes are used up; its contents are lost block by block.
  /// `block_size`: a power of two, at least a page; larger blocks are cheaper and are kept longer.
  /// `is_scratch`: memory of a scratch file, whose disk space is returned as well.
  PageRelease(void* memory, std::size_t byte_count, std::size_t block_size, bool is_scratch = false);

  /// Marks bytes as used; each byte at most once.
  void use_up(std::size_t first_byte, std::size_t byte_count);

 private:
  std::uintptr_t begin_ = 0;        ///< of the memory
  std::uintptr_t first_block_ = 0;  ///< of the blocks that lie inside the memory as a whole
  std::size_t block_size_ = 1;
  std::size_t block_count_ = 0;
  bool is_scratch_ = false;
  std::unique_ptr<std::atomic<std::size_t>[]> used_;  ///< bytes, by block
};

}  // namespace alidade
