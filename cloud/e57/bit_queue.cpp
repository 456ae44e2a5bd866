// SPDX-License-Identifier: MIT
#include "cloud/e57/bit_queue.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "base/bytes.h"

namespace alidade {
namespace {

/// The `width` bits from bit `shift` (0 to 7) of the nine bytes at `at`.
std::uint64_t bits_at(const std::byte* at, unsigned shift, unsigned width) {
  std::uint64_t value = load<std::uint64_t>(at) >> shift;
  if (shift + width > 64) value |= load<std::uint8_t>(at + 8) * (std::uint64_t{1} << (64 - shift));
  return width == 64 ? value : value & ((std::uint64_t{1} << width) - 1);
}

}  // namespace

void BitQueue::add(std::span<const std::byte> piece) {
  const std::size_t used = static_cast<std::size_t>(next_bit_ / 8);
  // Moving what is left only when at least as much was used keeps the cost linear.
  if (used > 0 && used >= bytes_.size() - used) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(used));
    next_bit_ %= 8;
  }
  bytes_.insert(bytes_.end(), piece.begin(), piece.end());
}

bool BitQueue::restart() {
  if (width_ == 0) return true;
  // What fills up a byte looks like numbers if they are narrow.
  const bool is_filling = width_ < 8 && bit_count() < 8;
  if (available(1) > 0 && !is_filling)
    return width_ >= 8 && bit_count() % static_cast<std::uint64_t>(width_) == 0;
  bytes_.clear();
  next_bit_ = 0;
  return true;
}

std::size_t BitQueue::available(std::size_t most) const {
  if (width_ == 0) return most;
  return static_cast<std::size_t>(
      std::min<std::uint64_t>(bit_count() / static_cast<std::uint64_t>(width_), most));
}

void BitQueue::take(std::span<std::uint64_t> numbers) {
  if (width_ == 0) {
    std::ranges::fill(numbers, 0);
    return;
  }
  const unsigned width = static_cast<unsigned>(width_);
  for (std::uint64_t& number : numbers) {
    const std::size_t byte = static_cast<std::size_t>(next_bit_ / 8);
    const unsigned shift = static_cast<unsigned>(next_bit_ % 8);
    if (bytes_.size() - byte >= 9) {
      number = bits_at(bytes_.data() + byte, shift, width);
    } else {
      std::array<std::byte, 9> last{};
      std::memcpy(last.data(), bytes_.data() + byte, bytes_.size() - byte);
      number = bits_at(last.data(), shift, width);
    }
    next_bit_ += width;
  }
}

}  // namespace alidade
