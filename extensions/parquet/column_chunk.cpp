// SPDX-License-Identifier: MIT
#include "extensions/parquet/column_chunk.h"

#include <zstd.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <memory>
#include <numeric>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "extensions/parquet/thrift_writer.h"

namespace alidade::database {
namespace {

Bytes compressed(const Bytes& bytes) {
  constexpr int k_level = 3;
  // Made once per thread: there are several calls per column and row group.
  thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                                  &ZSTD_freeCCtx);
  Bytes smaller(ZSTD_compressBound(bytes.size()));
  const std::size_t size =
      ZSTD_compressCCtx(context.get(), smaller.data(), smaller.size(), bytes.data(), bytes.size(), k_level);
  check_that(ZSTD_isError(size) == 0, std::string("cannot compress a page: ") + ZSTD_getErrorName(size));
  smaller.resize(size);
  return smaller;
}

template <class Value>
Bytes plain_bytes(std::span<const Value> values) {
  const auto bytes = std::as_bytes(values);
  return {bytes.begin(), bytes.end()};
}

/// The distinct values, and for each value its index in these.
template <class Value>
struct Dictionary {
  std::vector<Value> values;  ///< sorted by their bits, so that indices of near values are near
  std::vector<std::uint32_t> numbers;
};

/// Makes a dictionary of values with different bits; empty if more than half of all values are distinct.
template <class Value>
std::optional<Dictionary<Value>> find_dictionary(std::span<const Value> values) {
  using Bits = std::conditional_t<sizeof(Value) == 4, std::uint32_t, std::uint64_t>;
  constexpr std::uint64_t k_golden = 0x9e3779b97f4a7c15u;
  const std::size_t most = values.size() / 2;
  if (most == 0) return {};
  // Open addressing; a slot holds the number of a value plus 1.
  const int slot_bits = static_cast<int>(std::bit_width(2 * values.size()));
  std::vector<std::uint32_t> slots(std::size_t{1} << slot_bits);
  std::vector<Bits> found;
  Dictionary<Value> dictionary;
  dictionary.numbers.reserve(values.size());
  for (const Value value : values) {
    const Bits bits = std::bit_cast<Bits>(value);
    std::size_t slot = static_cast<std::size_t>(bits * k_golden >> (64 - slot_bits));
    while (slots[slot] != 0 && found[slots[slot] - 1] != bits) slot = (slot + 1) & (slots.size() - 1);
    if (slots[slot] == 0) {
      if (found.size() == most) return {};
      found.push_back(bits);
      slots[slot] = static_cast<std::uint32_t>(found.size());
    }
    dictionary.numbers.push_back(slots[slot] - 1);
  }
  std::vector<std::uint32_t> order(found.size()), rank(found.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t number) { return found[number]; });
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    rank[order[i]] = i;
    dictionary.values.push_back(std::bit_cast<Value>(found[order[i]]));
  }
  for (std::uint32_t& number : dictionary.numbers) number = rank[number];
  return dictionary;
}

/// Encoded values, and their compressed form.
struct Packed {
  PageEncoding encoding;
  Bytes raw, small;

  Packed(PageEncoding how, Bytes bytes) : encoding(how), raw(std::move(bytes)), small(compressed(raw)) {}
};

Packed packed_numbers(std::span<const std::uint32_t> numbers, int width, const Bytes& levels) {
  Bytes bytes = levels;
  bytes.push_back(static_cast<std::byte>(width));
  append_runs(numbers, width, bytes);
  return {PageEncoding::dictionary, std::move(bytes)};
}

/// The bytes of a dictionary's indices. Whole bytes per index often compress better than fewer bits.
template <class Value>
Packed smallest_numbers(const Dictionary<Value>& dictionary, const Bytes& levels) {
  const int width = std::max(1, static_cast<int>(std::bit_width(dictionary.values.size() - 1)));
  Packed exact = packed_numbers(dictionary.numbers, width, levels);
  const int whole = (width + 7) / 8 * 8;
  if (whole == width) return exact;
  Packed wide = packed_numbers(dictionary.numbers, whole, levels);
  return wide.small.size() < exact.small.size() ? std::move(wide) : std::move(exact);
}

void append_page(const Packed& page, std::size_t value_count, bool is_dictionary, ColumnChunk& chunk) {
  constexpr std::int32_t k_data_page = 0, k_dictionary_page = 2;
  const Bytes& content = chunk.is_compressed ? page.small : page.raw;
  ThriftWriter head;
  head.structure([&] {
    head.int32(1, is_dictionary ? k_dictionary_page : k_data_page);
    head.int32(2, static_cast<std::int32_t>(page.raw.size()));
    head.int32(3, static_cast<std::int32_t>(content.size()));
    head.structure(is_dictionary ? 7 : 5, [&] {
      head.int32(1, static_cast<std::int32_t>(value_count));
      head.int32(2, static_cast<std::int32_t>(page.encoding));
      if (is_dictionary) return;
      head.int32(3, static_cast<std::int32_t>(PageEncoding::runs));  // of levels
      head.int32(4, static_cast<std::int32_t>(PageEncoding::runs));
    });
  });
  chunk.uncompressed_size += head.bytes().size() + page.raw.size();
  chunk.pages.insert(chunk.pages.end(), head.bytes().begin(), head.bytes().end());
  chunk.pages.insert(chunk.pages.end(), content.begin(), content.end());
}

/// `dictionary`: null if there is none.
ColumnChunk chunk_of(const Packed* dictionary, std::size_t dictionary_count, const Packed& data,
                     std::size_t row_count) {
  ColumnChunk chunk{.encoding = data.encoding};
  const std::size_t raw = data.raw.size() + (dictionary != nullptr ? dictionary->raw.size() : 0);
  const std::size_t small = data.small.size() + (dictionary != nullptr ? dictionary->small.size() : 0);
  chunk.is_compressed = small < raw;
  if (dictionary != nullptr) append_page(*dictionary, dictionary_count, true, chunk);
  chunk.dictionary_size = chunk.pages.size();
  append_page(data, row_count, false, chunk);
  return chunk;
}

template <class Value>
std::optional<std::array<Bytes, 2>> range_of(std::span<const Value> values) {
  if (values.empty()) return {};
  Value least = values.front(), greatest = values.front();
  for (const Value value : values) {
    if constexpr (std::floating_point<Value>) {
      if (std::isnan(value)) return {};
    }
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  if constexpr (std::floating_point<Value>) {
    // There may be zeros of both signs; the specification requires these limits.
    if (least == Value{0}) least = -Value{0};
    if (greatest == Value{0}) greatest = Value{0};
  }
  return std::array{plain_bytes(std::span<const Value>(&least, 1)),
                    plain_bytes(std::span<const Value>(&greatest, 1))};
}

/// Levels as a data page begins with them: their length, then bits. Empty if there are no levels.
Bytes level_bytes(std::span<const std::uint32_t> levels) {
  if (levels.empty()) return {};
  Bytes bytes(sizeof(std::uint32_t));
  append_runs(levels, 1, bytes);
  const auto length = static_cast<std::uint32_t>(bytes.size() - sizeof(std::uint32_t));
  std::ranges::copy(std::as_bytes(std::span(&length, 1)), bytes.begin());
  return bytes;
}

}  // namespace

template <class Value>
ColumnChunk number_chunk(std::span<const Value> values, std::span<const std::uint32_t> levels) {
  const std::size_t row_count = levels.empty() ? values.size() : levels.size();
  const Bytes head = level_bytes(levels);
  Bytes plain = head;
  const auto bytes = std::as_bytes(values);
  plain.insert(plain.end(), bytes.begin(), bytes.end());
  Packed best(PageEncoding::plain, std::move(plain));
  if constexpr (std::integral<Value>) {
    using Unsigned = std::make_unsigned_t<Value>;
    Bytes deltas = head;
    append_deltas(std::span(reinterpret_cast<const Unsigned*>(values.data()), values.size()), deltas);
    Packed packed(PageEncoding::deltas, std::move(deltas));
    if (packed.small.size() < best.small.size()) best = std::move(packed);
  }
  std::optional<ColumnChunk> chunk;
  if (const auto dictionary = find_dictionary(values)) {
    const Packed different(PageEncoding::plain, plain_bytes(std::span<const Value>(dictionary->values)));
    const Packed numbers = smallest_numbers(*dictionary, head);
    if (different.small.size() + numbers.small.size() < best.small.size())
      chunk = chunk_of(&different, dictionary->values.size(), numbers, row_count);
  }
  if (!chunk) chunk = chunk_of(nullptr, 0, best, row_count);
  chunk->null_count = row_count - values.size();
  chunk->range = range_of(values);
  return *std::move(chunk);
}

template ColumnChunk number_chunk(std::span<const std::int32_t>, std::span<const std::uint32_t>);
template ColumnChunk number_chunk(std::span<const std::uint32_t>, std::span<const std::uint32_t>);
template ColumnChunk number_chunk(std::span<const std::int64_t>, std::span<const std::uint32_t>);
template ColumnChunk number_chunk(std::span<const std::uint64_t>, std::span<const std::uint32_t>);
template ColumnChunk number_chunk(std::span<const float>, std::span<const std::uint32_t>);
template ColumnChunk number_chunk(std::span<const double>, std::span<const std::uint32_t>);

ColumnChunk byte_chunk(Bytes plain, std::size_t row_count) {
  return chunk_of(nullptr, 0, Packed(PageEncoding::plain, std::move(plain)), row_count);
}

}  // namespace alidade::database
