// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/bytes.h"
#include "cloud/las/las_header.h"
#include "cloud/laz/layer.h"
#include "cloud/laz/laz_layout.h"
#include "tests/cloud/laz/laz_test_support.h"
#include "tests/support/random.h"

namespace alidade::test {

/// How records of a test are made up.
struct RecordKind {
  int point_format = 7;       ///< 6 to 10
  std::size_t extra = 0;      ///< extra bytes
  unsigned channels = 1;      ///< scanner channels that take turns, 1 to 4
  bool wild = false;          ///< any bits in any field, instead of a scanner's modest changes
  std::uint16_t version = 3;  ///< of all items

  LazLayout layout() const {
    const std::size_t base =
        static_cast<std::size_t>(k_las_point_layouts[static_cast<std::size_t>(point_format)].size);
    LazLayout layout = standard_laz_layout(point_format, base + extra);
    for (LazItem& item : layout.items) item.version = version;
    return layout;
  }
};

/// The GPS time after `last`, as bits: all kinds of changes the format has codes for.
inline std::int64_t next_time(Random& random, std::int64_t last, bool wild) {
  const auto moved = [&](std::int64_t by) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(last) + static_cast<std::uint64_t>(by));
  };
  switch (random.below(wild ? 10 : 4)) {
    case 0:
    case 1:
      return last;
    case 2:
      return moved(1000);
    case 3:
      return moved(1000 * static_cast<std::int64_t>(random.below(600)) - 15000);
    case 4:
      return std::bit_cast<std::int64_t>(1e9 * static_cast<double>(1 + random.below(5)));
    case 5:
      return std::bit_cast<std::int64_t>(-0.0);
    case 6:
      return std::bit_cast<std::int64_t>(0.0);
    case 7:
      return std::bit_cast<std::int64_t>(std::numeric_limits<double>::quiet_NaN());
    case 8:
      return moved(static_cast<std::int32_t>(random.bits()));
    default:
      return static_cast<std::int64_t>(random.bits());
  }
}

inline Bytes random_records(Random& random, const RecordKind& kind, std::size_t count) {
  using namespace point14;
  const std::size_t size = kind.layout().record_size();
  Bytes records(count * size);
  std::vector<Bytes> last(kind.channels, Bytes(size));
  for (Bytes& record : last)
    for (std::byte& byte : record) byte = static_cast<std::byte>(random.bits());
  unsigned channel = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (random.below(4) == 0) channel = static_cast<unsigned>(random.below(kind.channels));
    std::byte* const record = last[channel].data();
    for (const std::size_t axis : {k_x, k_y, k_z}) {
      const std::uint32_t change = kind.wild && random.below(4) == 0
                                       ? static_cast<std::uint32_t>(random.bits())
                                       : static_cast<std::uint32_t>(random.below(200));
      store(record + axis, load<std::uint32_t>(record + axis) + change - 100);
    }
    const std::int64_t time = load<std::int64_t>(record + k_gps_time);
    store(record + k_gps_time, next_time(random, time, kind.wild));
    // All other bytes: mostly as they were, sometimes a little different, and any if wild.
    for (std::size_t at = k_intensity; at < size; ++at) {
      if (at >= k_gps_time && at < k_size) continue;
      const std::uint64_t choice = random.below(8);
      if (choice == 0) record[at] = static_cast<std::byte>(load<std::uint8_t>(record + at) + random.below(3));
      if (choice == 1 && kind.wild) record[at] = static_cast<std::byte>(random.bits());
    }
    if (!kind.wild) {
      const unsigned returns = 1 + static_cast<unsigned>(random.below(3));
      store(record + k_returns, static_cast<std::uint8_t>(returns << 4 | (1 + random.below(returns))));
    }
    put_channel(record, channel);
    std::copy_n(record, size, records.data() + i * size);
  }
  return records;
}

}  // namespace alidade::test
