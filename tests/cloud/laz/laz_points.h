// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <vector>

#include "cloud/laz/laz_layout.h"
#include "tests/support/random.h"

namespace alidade::test {

/// How points of a test follow each other.
enum class LazPoints {
  wild,  ///< every byte is random
  near   ///< like scans: most attributes stay, coordinates move little, clocks tick, colours are alike
};

/// Puts a value into a record.
template <class T>
void put(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof(T));
}

/// Times of up to six clocks: steps of all multiples of a unit that GPS time codes know, jumps, and special
/// values.
class LazClocks {
 public:
  explicit LazClocks(Random& random) : random_(random) {
    for (std::uint64_t& time : times_) time = random_.bits();
  }

  std::uint64_t next() {
    constexpr std::array<double, 5> k_special = {0.0, -0.0, std::numeric_limits<double>::quiet_NaN(), -1e300,
                                                 1e-320};
    constexpr std::array<int, 14> k_factors = {0, 1, 1, 1, 1, 2, 9, 10, 499, 500, 800, -1, -9, -12};
    if (random_.below(300) == 0) return std::bit_cast<std::uint64_t>(k_special[random_.below(5)]);
    if (random_.below(40) == 0) clock_ = random_.below(times_.size());
    std::uint64_t& time = times_[clock_];
    if (random_.below(400) == 0) time = random_.bits();
    const std::uint64_t unit = 1000 + 100000 * clock_ + random_.below(3);
    time += unit * static_cast<std::uint64_t>(k_factors[random_.below(k_factors.size())]);
    if (random_.below(200) == 0) time += random_.below(2) == 0 ? 0x7fffffff : std::uint64_t{0} - 0x80000000;
    return time;
  }

 private:
  Random& random_;
  std::array<std::uint64_t, 6> times_{};
  std::size_t clock_ = 0;
};

/// Changes a record of formats 0 to 5 into one that could follow it in a scan.
inline void follow(Random& random, LazClocks& clocks, const LazLayout& layout, std::byte* record) {
  const auto now_and_then = [&](std::size_t at, std::uint64_t one_in) {
    if (random.below(one_in) == 0) record[at] = static_cast<std::byte>(random.bits());
  };
  for (const LazItem& item : layout.items) {
    switch (item.kind) {
      case LazItemKind::point10:
        for (std::size_t axis = 0; axis < 3; ++axis) {
          std::int32_t value;
          std::memcpy(&value, record + 4 * axis, 4);
          const std::uint64_t range = std::uint64_t{1} << random.below(12 + axis);
          put(record + 4 * axis, static_cast<std::int32_t>(static_cast<std::uint32_t>(value) +
                                                           static_cast<std::uint32_t>(random.below(range))));
        }
        for (std::size_t at = 12; at < 20; ++at) now_and_then(at, at < 15 ? 3 : 50);
        break;
      case LazItemKind::gps_time11:
        put(record, clocks.next());
        break;
      case LazItemKind::wave_packet13: {
        std::uint64_t offset;
        std::uint32_t size;
        std::memcpy(&offset, record + 1, 8);
        std::memcpy(&size, record + 9, 4);
        if (random.below(3) != 0) put(record + 1, random.below(9) == 0 ? random.bits() : offset + size);
        if (random.below(9) == 0) put(record + 1, offset - random.below(5000));
        for (std::size_t at = 9; at < item.size; ++at) now_and_then(at, 5);
        break;
      }
      case LazItemKind::rgb12: {
        const unsigned shift = static_cast<unsigned>(random.below(300));
        const bool grey = random.below(4) == 0;
        for (std::size_t at = 0; at < 6; at += 2) {
          std::uint16_t value;
          std::memcpy(&value, record + (grey ? 0 : at), 2);
          put(record + at, static_cast<std::uint16_t>(value + (grey && at > 0 ? 0 : shift)));
        }
        break;
      }
      default:
        for (std::size_t at = 0; at < item.size; ++at) now_and_then(at, 4);
    }
    record += item.size;
  }
}

/// Point data records of formats 0 to 5, one after the other.
inline std::vector<std::byte> pointwise_records(Random& random, const LazLayout& layout, std::size_t count,
                                                LazPoints points) {
  const std::size_t size = layout.record_size();
  std::vector<std::byte> records(count * size);
  LazClocks clocks(random);
  for (std::size_t i = 0; i < count; ++i) {
    std::byte* const record = records.data() + i * size;
    if (i == 0 || points == LazPoints::wild) {
      for (std::size_t at = 0; at < size; ++at) record[at] = static_cast<std::byte>(random.bits());
    } else {
      std::memcpy(record, record - size, size);
      follow(random, clocks, layout, record);
    }
  }
  return records;
}

}  // namespace alidade::test
