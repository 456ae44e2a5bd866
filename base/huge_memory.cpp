// SPDX-License-Identifier: MIT
#include "base/huge_memory.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/mman.h>
#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <new>
#include <optional>
#include <string>

#include "base/error.h"
#include "base/scratch_file.h"

namespace alidade {
namespace {

constexpr std::size_t k_huge_page = std::size_t{1} << 21;
constexpr std::align_val_t k_small_alignment{64};

std::size_t whole_pages(std::size_t byte_count) {
  return (byte_count + k_huge_page - 1) / k_huge_page * k_huge_page;
}

constexpr std::uint64_t k_kibibyte = 1024;

/// The number after a key such as "MemAvailable:" in a file of the system.
std::optional<std::uint64_t> number_in(const std::string& file, const std::string& wanted) {
  std::ifstream stream(file);
  std::string key, unit;
  for (std::uint64_t value = 0; stream >> key >> value; std::getline(stream, unit)) {
    if (key == wanted) return value;
  }
  return std::nullopt;
}

/// Bytes that a control group may still take; empty without a limit. Pages of files that were not used for a
/// while count as free.
std::optional<std::uint64_t> left_in_group(const std::string& folder, const char* limit_name,
                                           const char* usage_name, const char* free_key) {
  std::uint64_t limit = 0, usage = 0;
  if (!(std::ifstream(folder + limit_name) >> limit) || !(std::ifstream(folder + usage_name) >> usage))
    return std::nullopt;
  usage -= std::min(usage, number_in(folder + "/memory.stat", free_key).value_or(0));
  return limit - std::min(limit, usage);
}

/// The least of what the control groups around this process may still take: containers and batch systems set
/// their limits on any of them.
std::optional<std::uint64_t> left_in_groups() {
  std::optional<std::uint64_t> least;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    // "4:memory:/path" of version 1, "0::/path" of version 2
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (!controllers.empty() && controllers != "memory") continue;
    for (std::string path = line.substr(second + 1); !path.empty(); path.resize(path.rfind('/'))) {
      const auto left =
          controllers.empty()
              ? left_in_group("/sys/fs/cgroup" + path, "/memory.max", "/memory.current", "inactive_file")
              : left_in_group("/sys/fs/cgroup/memory" + path, "/memory.limit_in_bytes",
                              "/memory.usage_in_bytes", "total_inactive_file");
      if (left) least = std::min(*left, least.value_or(*left));
      if (path.rfind('/') == std::string::npos) break;
    }
  }
  return least;
}

}  // namespace

std::optional<std::uint64_t> available_memory() {
  const std::optional<std::uint64_t> of_machine = number_in("/proc/meminfo", "MemAvailable:");
  const std::optional<std::uint64_t> of_group = left_in_groups();
  if (!of_machine) return of_group;
  return std::min(*of_machine * k_kibibyte, of_group.value_or(std::numeric_limits<std::uint64_t>::max()));
}

void check_memory(std::uint64_t bytes, const char* what) {
  constexpr double k_gigabyte = 1e9;
  const std::optional<std::uint64_t> available = available_memory();
  if (!available || bytes <= *available) return;
  throw Error({.problem = fmt::format("not enough memory for {}", what),
               .expected = fmt::format("{:.1f} GB", static_cast<double>(bytes) / k_gigabyte),
               .found = fmt::format("{:.1f} GB free", static_cast<double>(*available) / k_gigabyte)});
}

void* take_pages(std::size_t byte_count) {
  if (byte_count < k_huge_page) return ::operator new(byte_count, k_small_alignment);
  if (byte_count > std::numeric_limits<std::size_t>::max() / 2) throw std::bad_alloc();
  // Maps one page more, and returns the parts outside of the aligned range.
  const std::size_t kept = whole_pages(byte_count), asked = kept + k_huge_page;
  void* const mapped = mmap(nullptr, asked, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) throw std::bad_alloc();
  const auto address = reinterpret_cast<std::uintptr_t>(mapped);
  const std::size_t before = (k_huge_page - address % k_huge_page) % k_huge_page;
  const std::size_t after = asked - kept - before;
  char* const pages = static_cast<char*>(mapped) + before;
  if (before > 0) munmap(mapped, before);
  if (after > 0) munmap(pages + kept, after);
  madvise(pages, kept, MADV_HUGEPAGE);
  return pages;
}

void* take_pages(std::size_t byte_count, const std::filesystem::path& folder) {
  return byte_count < k_huge_page ? take_pages(byte_count)
                                  : map_scratch_pages(whole_pages(byte_count), folder);
}

void give_back_pages(void* pages, std::size_t byte_count) noexcept {
  if (byte_count < k_huge_page) return ::operator delete(pages, k_small_alignment);
  munmap(pages, whole_pages(byte_count));
}

void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 128 << 20);
#endif
}

void request_huge_pages(void* memory, std::size_t byte_count) noexcept {
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = whole_pages(address), end = (address + byte_count) / k_huge_page * k_huge_page;
  if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
}

PageRelease::PageRelease(void* memory, std::size_t byte_count, std::size_t block_size, bool is_scratch)
    : begin_(reinterpret_cast<std::uintptr_t>(memory)), block_size_(block_size), is_scratch_(is_scratch) {
  first_block_ = (begin_ + block_size - 1) / block_size * block_size;
  const std::uintptr_t end = (begin_ + byte_count) / block_size * block_size;
  if (end <= first_block_) return;
  block_count_ = (end - first_block_) / block_size;
  used_ = std::make_unique<std::atomic<std::size_t>[]>(block_count_);
}

void PageRelease::use_up(std::size_t first_byte, std::size_t byte_count) {
  if (block_count_ == 0) return;
  const std::uintptr_t end =
      std::min(begin_ + first_byte + byte_count, first_block_ + block_count_ * block_size_);
  std::uintptr_t here = std::max(begin_ + first_byte, first_block_);
  while (here < end) {
    const std::size_t block = (here - first_block_) / block_size_;
    const std::uintptr_t block_begin = first_block_ + block * block_size_;
    const std::size_t bytes = std::min(end, block_begin + block_size_) - here;
    // The thread that uses the last byte must see the others' reads done before it lets the block go.
    if (used_[block].fetch_add(bytes, std::memory_order_acq_rel) + bytes == block_size_) {
      auto* const memory = reinterpret_cast<std::byte*>(block_begin);
      if (is_scratch_) {
        discard_scratch_pages({memory, block_size_});
      } else {
        madvise(memory, block_size_, MADV_DONTNEED);
      }
    }
    here += bytes;
  }
}

}  // namespace alidade
