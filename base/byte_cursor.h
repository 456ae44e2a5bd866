// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/input_file.h"

namespace alidade {

/// Walks forward through the bytes of a file. Errors: those of InputFile, when the file ends early.
class ByteCursor {
 public:
  ByteCursor(InputFile& file, std::uint64_t place) : file_(file), window_place_(place) {}

  /// Byte that comes next.
  std::uint64_t place() const { return window_place_ + used_; }

  /// The next `count` bytes, valid until the next call.
  const std::byte* take(std::size_t count) {
    if (count > window_.size() - used_) refill(count);
    const std::byte* const bytes = window_.data() + used_;
    used_ += count;
    return bytes;
  }

  /// Leaves out `count` bytes. Cost: constant.
  void skip(std::uint64_t count) {
    if (count <= window_.size() - used_) {
      used_ += static_cast<std::size_t>(count);
      return;
    }
    const std::uint64_t from = place();
    if (count > file_.size() - std::min(from, file_.size())) file_.view(from, count);
    window_ = {};
    used_ = 0;
    window_place_ = from + count;
  }

 private:
  void refill(std::size_t count) {
    constexpr std::size_t k_window = 1 << 20;
    window_place_ += used_;
    used_ = 0;
    window_ = {};
    const auto bytes = file_.view_up_to(window_place_, std::max(count, k_window));
    window_ = bytes.size() < count ? file_.view(window_place_, count) : bytes;
  }

  InputFile& file_;
  std::uint64_t window_place_;
  std::span<const std::byte> window_;
  std::size_t used_ = 0;
};

}  // namespace alidade
