// SPDX-License-Identifier: MIT
#include "cloud/laz/layer.h"

#include <cstring>

namespace alidade {

bool Layer::needed(std::span<const std::byte> records, std::size_t record_size) const {
  const std::byte* const first = records.data() + field_.offset;
  for (std::size_t at = record_size; at < records.size(); at += record_size)
    if (std::memcmp(first, first + at, field_.size) != 0) return true;
  return false;
}

}  // namespace alidade
