// SPDX-License-Identifier: MIT
#include "cloud/laz/write_chunk_table.h"

#include <cassert>
#include <cstdint>

#include "base/bytes.h"
#include "cloud/laz/arithmetic_encoder.h"
#include "cloud/laz/integer_compressor.h"

namespace alidade {

std::vector<std::byte> encode_chunk_table(std::span<const LazChunk> chunks, const LazLayout& layout) {
  assert(chunks.size() <= UINT32_MAX);
  std::vector<std::byte> table(8);  // version 0, number of chunks
  store(table.data() + 4, static_cast<std::uint32_t>(chunks.size()));
  if (chunks.empty()) return table;

  constexpr int k_point_counts = 0, k_byte_counts = 1;  // contexts
  ArithmeticEncoder encoder;
  IntegerCompressor numbers(32, 2);
  std::int32_t points = 0, bytes = 0;  // of the chunk before
  const auto encode = [&](std::int32_t& before, std::uint64_t number, int context) {
    assert(number <= UINT32_MAX);
    const auto value = static_cast<std::int32_t>(static_cast<std::uint32_t>(number));
    numbers.encode(encoder, before, value, context);
    before = value;
  };
  for (const LazChunk& chunk : chunks) {
    if (layout.chunk_size == 0) encode(points, chunk.point_count, k_point_counts);
    encode(bytes, chunk.byte_count, k_byte_counts);
  }
  const std::vector<std::byte> stream = encoder.finish();
  table.insert(table.end(), stream.begin(), stream.end());
  return table;
}

}  // namespace alidade
