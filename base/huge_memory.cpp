// SPDX-License-Identifier: MIT
#include "base/huge_memory.h"

#include <sys/mman.h>

#include <cstdint>
#include <limits>
#include <new>

namespace alidade {
namespace {

constexpr std::size_t k_huge_page = std::size_t{1} << 21;
constexpr std::align_val_t k_small_alignment{64};

std::size_t whole_pages(std::size_t byte_count) {
  return (byte_count + k_huge_page - 1) / k_huge_page * k_huge_page;
}

}  // namespace

void* take_pages(std::size_t byte_count) {
  if (byte_count < k_huge_page) return ::operator new(byte_count, k_small_alignment);
  if (byte_count > std::numeric_limits<std::size_t>::max() / 2) throw std::bad_alloc();
  // One page more is asked for, and what stands outside of the aligned part goes back.
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

void give_back_pages(void* pages, std::size_t byte_count) noexcept {
  if (byte_count < k_huge_page) return ::operator delete(pages, k_small_alignment);
  munmap(pages, whole_pages(byte_count));
}

}  // namespace alidade
