// SPDX-License-Identifier: MIT
#include "cloud/laz/write_laszip_record.h"

#include <span>

#include "base/bytes.h"
#include "cloud/laz/laszip_record.h"

namespace alidade {

VariableLengthRecord laszip_record(const LazLayout& layout) {
  constexpr std::size_t k_head = 34, k_item = 6;
  VariableLengthRecord record{.user_id = k_laszip_user_id,
                              .record_id = k_laszip_record_id,
                              .description = "how the points are packed",
                              .data = std::vector<std::uint8_t>(k_head + k_item * layout.items.size()),
                              .extended = false};
  const std::span<std::byte> data = std::as_writable_bytes(std::span(record.data));
  std::byte* const at = data.data();
  store(at, layout.compressor);
  // The version of the rules, as readers know it: 2.2. The coder at byte 2 and the options at byte 8 are 0.
  store<std::uint8_t>(at + 4, 2);
  store<std::uint8_t>(at + 5, 2);
  store(at + 12, layout.chunk_size == 0 ? UINT32_MAX : layout.chunk_size);
  store<std::int64_t>(at + 16, -1);  // no special extended records
  store<std::int64_t>(at + 24, -1);
  store(at + 32, static_cast<std::uint16_t>(layout.items.size()));
  for (std::size_t i = 0; i < layout.items.size(); ++i) {
    std::byte* const item = at + k_head + k_item * i;
    store(item, layout.items[i].kind);
    store(item + 2, layout.items[i].size);
    store(item + 4, layout.items[i].version);
  }
  return record;
}

}  // namespace alidade
