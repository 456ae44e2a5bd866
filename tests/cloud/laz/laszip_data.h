// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cloud/laz/laz_layout.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade::test {

/// Data of the record "laszip encoded" 22204, field by field.
inline std::vector<std::uint8_t> laszip_data(const LazLayout& layout) {
  ByteSink sink;
  sink.add<std::uint16_t>(static_cast<std::uint16_t>(layout.compressor)).add<std::uint16_t>(0);
  sink.add<std::uint8_t>(3).add<std::uint8_t>(4).add<std::uint16_t>(3).add<std::uint32_t>(0);
  sink.add<std::uint32_t>(layout.chunk_size == 0 ? 0xffffffff : layout.chunk_size);
  sink.add<std::int64_t>(-1).add<std::int64_t>(-1);
  sink.add<std::uint16_t>(static_cast<std::uint16_t>(layout.items.size()));
  for (const LazItem& item : layout.items) {
    sink.add<std::uint16_t>(static_cast<std::uint16_t>(item.kind));
    sink.add<std::uint16_t>(item.size).add<std::uint16_t>(item.version);
  }
  const std::vector<std::byte> bytes = sink.take();
  const auto* const first = reinterpret_cast<const std::uint8_t*>(bytes.data());
  return {first, first + bytes.size()};
}

}  // namespace alidade::test
