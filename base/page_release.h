// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace alidade {

/// Gives memory back to the system while its contents are used up, in any order and from many threads: a
/// block goes as soon as its last byte was used. So an array can move into another one without both being
/// there.
class PageRelease {
 public:
  PageRelease() = default;
  /// The memory must stay allocated while bytes are used up; its contents are lost bit by bit. `block_size`:
  /// a power of two, at least a page; larger blocks are cheaper and are kept longer.
  PageRelease(void* memory, std::size_t byte_count, std::size_t block_size);

  /// These bytes were used; each byte at most once.
  void use_up(std::size_t first_byte, std::size_t byte_count);

 private:
  std::uintptr_t begin_ = 0;        ///< of the memory
  std::uintptr_t first_block_ = 0;  ///< of the blocks that lie inside the memory as a whole
  std::size_t block_size_ = 1;
  std::size_t block_count_ = 0;
  std::unique_ptr<std::atomic<std::size_t>[]> used_;  ///< bytes, by block
};

}  // namespace alidade
