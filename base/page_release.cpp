// SPDX-License-Identifier: MIT
#include "base/page_release.h"

#include <sys/mman.h>

#include <algorithm>

namespace alidade {

PageRelease::PageRelease(void* memory, std::size_t byte_count, std::size_t block_size)
    : begin_(reinterpret_cast<std::uintptr_t>(memory)), block_size_(block_size) {
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
    if (used_[block].fetch_add(bytes, std::memory_order_acq_rel) + bytes == block_size_)
      madvise(reinterpret_cast<void*>(block_begin), block_size_, MADV_DONTNEED);
    here += bytes;
  }
}

}  // namespace alidade
