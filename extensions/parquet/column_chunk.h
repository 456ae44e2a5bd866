// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "extensions/parquet/encodings.h"

namespace alidade::database {

/// Types and encodings of Parquet, with the numbers of its specification.
enum class PhysicalType : std::int32_t {
  int32 = 1,
  int64 = 2,
  float32 = 4,
  float64 = 5,
  bytes = 6,
  fixed_bytes = 7
};
enum class PageEncoding : std::int32_t { plain = 0, runs = 3, deltas = 5, dictionary = 8 };

/// The values of one column in one row group: an optional dictionary page, then a data page.
struct ColumnChunk {
  Bytes pages{};
  PageEncoding encoding = PageEncoding::plain;  ///< of the data page
  bool is_compressed = false;                   ///< by Zstandard
  std::uint64_t uncompressed_size = 0;          ///< of the pages, including their headers
  std::uint64_t dictionary_size = 0;            ///< in `pages`; 0: there is none
  std::uint64_t null_count = 0;
  /// Least and greatest value as plain bytes; empty without values, with NaN, and for byte strings.
  std::optional<std::array<Bytes, 2>> range{};
};

/// Encodes numbers in the way that takes the fewest bytes. `levels`: for each row 1, or 0 if it has no
/// value; empty if all rows have one. Cost: a few passes, each compressed: some 40 ns per value.
template <class Value>
ColumnChunk number_chunk(std::span<const Value> values, std::span<const std::uint32_t> levels);
extern template ColumnChunk number_chunk(std::span<const std::int32_t>, std::span<const std::uint32_t>);
extern template ColumnChunk number_chunk(std::span<const std::uint32_t>, std::span<const std::uint32_t>);
extern template ColumnChunk number_chunk(std::span<const std::int64_t>, std::span<const std::uint32_t>);
extern template ColumnChunk number_chunk(std::span<const std::uint64_t>, std::span<const std::uint32_t>);
extern template ColumnChunk number_chunk(std::span<const float>, std::span<const std::uint32_t>);
extern template ColumnChunk number_chunk(std::span<const double>, std::span<const std::uint32_t>);

/// Stores byte strings, one per row, that are already encoded as plain values.
ColumnChunk byte_chunk(Bytes plain, std::size_t row_count);

}  // namespace alidade::database
