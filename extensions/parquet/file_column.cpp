// SPDX-License-Identifier: MIT
#include "extensions/parquet/file_column.h"

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/bytes.h"
#include "base/words.h"
#include "cloud/lattice.h"
#include "cloud/point_table.h"

namespace alidade::database {
namespace {

/// The type in a file for one in a cloud: Parquet has integers of 32 and 64 bits.
template <class Number>
using FileNumber =
    std::conditional_t<std::floating_point<Number> || sizeof(Number) == 8, Number,
                       std::conditional_t<std::is_signed_v<Number>, std::int32_t, std::uint32_t>>;

template <class Number>
constexpr PhysicalType physical_type() {
  constexpr bool is_wide = sizeof(Number) == 8;
  if constexpr (std::floating_point<Number>) return is_wide ? PhysicalType::float64 : PhysicalType::float32;
  return is_wide ? PhysicalType::int64 : PhysicalType::int32;
}

/// A number for the file. All zeros are written without a sign: to DataFusion zeros of different signs
/// are different numbers, unlike in SQLite, PostgreSQL and DuckDB.
template <class Number, class Given>
Number written(Given number) {
  if constexpr (std::floating_point<Number>) return static_cast<Number>(number) + Number{0};
  return static_cast<Number>(number);
}

FileColumn attribute_column(StoredColumn stored) {
  FileColumn column{.name = stored.name};
  column.may_be_null = stored.type != ScalarType::bytes && stored.no_data.has_value();
  if (stored.type == ScalarType::bytes) {
    column.type = PhysicalType::fixed_bytes;
    column.fixed_size = stored.size;
  } else if (!stored.is_scaled()) {
    with_type(stored.type, [&](auto none) {
      using Number = decltype(none);
      column.type = physical_type<Number>();
      if constexpr (std::integral<Number>) {
        column.integer_bits = 8 * static_cast<int>(sizeof(Number));
        column.is_signed = std::is_signed_v<Number>;
      }
    });
  }
  column.stored = std::move(stored);
  return column;
}

std::string free_name(const std::vector<FileColumn>& columns, std::string name) {
  while (
      std::ranges::any_of(columns, [&](const FileColumn& other) { return lower_case(other.name) == name; }))
    name += '_';
  return name;
}

template <class Number>
ColumnChunk chunk_of_all(const std::vector<Number>& values) {
  return number_chunk(std::span<const Number>(values), {});
}

ColumnChunk encode_ids(const EncodedChunks& rows) {
  std::vector<std::int64_t> ids(rows.positions.size());
  std::memcpy(ids.data(), rows.blobs.front().data(), rows.blobs.front().size());
  return chunk_of_all(ids);
}

ColumnChunk encode_coordinates(const EncodedChunks& rows, const Lattice& lattice, int axis) {
  std::vector<double> values;
  values.reserve(rows.positions.size());
  for (const LatticePosition& position : rows.positions)
    values.push_back(written<double>(to_world(lattice, position)[axis]));
  return chunk_of_all(values);
}

/// Points as WKB, each after its length, as plain byte strings.
ColumnChunk encode_geometry(const EncodedChunks& rows, const Lattice& lattice) {
  constexpr std::uint32_t k_point_z = 1001;
  constexpr std::uint8_t k_little_endian = 1;
  constexpr std::uint32_t k_size = 1 + 4 + 3 * 8;
  Bytes plain;
  plain.reserve(rows.positions.size() * (sizeof k_size + k_size));
  for (const LatticePosition& position : rows.positions) {
    append_value(k_size, plain);
    append_value(k_little_endian, plain);
    append_value(k_point_z, plain);
    const glm::dvec3 world = to_world(lattice, position);
    for (int axis = 0; axis < 3; ++axis) append_value(world[axis], plain);
  }
  return byte_chunk(std::move(plain), rows.positions.size());
}

/// Encodes values that are not the stored numbers.
template <class Number>
ColumnChunk encode_meant(const StoredColumn& column, const std::byte* at, std::size_t count,
                         bool may_be_null) {
  std::vector<Number> values;
  std::vector<std::uint32_t> levels;
  for (std::size_t row = 0; row < count; ++row, at += column.size) {
    const ColumnValue value = stored_value(column, at);
    if (may_be_null) levels.push_back(std::holds_alternative<std::monostate>(value) ? 0 : 1);
    std::visit(
        [&](const auto& number) {
          if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(number)>>)
            values.push_back(written<Number>(number));
        },
        value);
  }
  return number_chunk(std::span<const Number>(values), levels);
}

ColumnChunk encode_attribute(const FileColumn& column, const EncodedChunks& rows) {
  const StoredColumn& stored = column.stored;
  const std::vector<std::byte>& blob = rows.blobs[static_cast<std::size_t>(stored.blob)];
  if (stored.type == ScalarType::bytes) return byte_chunk(blob, rows.positions.size());
  const std::byte* at = blob.data() + stored.byte;
  const std::size_t count = rows.positions.size();
  if (stored.is_scaled()) return encode_meant<double>(stored, at, count, column.may_be_null);
  return with_type(stored.type, [&](auto none) {
    using Number = decltype(none);
    if (column.may_be_null) return encode_meant<FileNumber<Number>>(stored, at, count, true);
    std::vector<FileNumber<Number>> values;
    values.reserve(count);
    for (std::size_t row = 0; row < count; ++row, at += stored.size)
      values.push_back(written<FileNumber<Number>>(load<Number>(at)));
    return chunk_of_all(values);
  });
}

}  // namespace

std::vector<FileColumn> file_columns(const std::vector<StoredColumn>& stored, bool geometry) {
  using Content = FileColumn::Content;
  std::vector<FileColumn> columns = {{.name = "id", .content = Content::id, .type = PhysicalType::int64}};
  for (int axis = 0; axis < 3; ++axis)
    columns.push_back({.name = std::string(1, "xyz"[axis]), .content = Content::coordinate, .axis = axis});
  for (const StoredColumn& column : stored)
    if (column.blob != 0) columns.push_back(attribute_column(column));
  if (geometry) {
    columns.push_back(
        {.name = free_name(columns, "geometry"), .content = Content::geometry, .type = PhysicalType::bytes});
  }
  return columns;
}

void write_schema_element(const FileColumn& column, ThriftWriter& writer) {
  constexpr std::int32_t k_required = 0, k_optional = 1, k_uint_8 = 11, k_int_8 = 15;
  writer.structure([&] {
    writer.int32(1, static_cast<std::int32_t>(column.type));
    if (column.fixed_size > 0) writer.int32(2, column.fixed_size);
    writer.int32(3, column.may_be_null ? k_optional : k_required);
    writer.text(4, column.name);
    if (column.integer_bits == 0) return;
    // Both forms: readers support the older one, the newer one, or both.
    const int step = std::countr_zero(static_cast<unsigned>(column.integer_bits)) - 3;
    writer.int32(6, (column.is_signed ? k_int_8 : k_uint_8) + step);
    writer.structure(10, [&] {
      writer.structure(10, [&] {
        writer.byte(1, static_cast<std::int8_t>(column.integer_bits));
        writer.boolean(2, column.is_signed);
      });
    });
  });
}

ColumnChunk encode_column(const FileColumn& column, const EncodedChunks& rows, const Lattice& lattice) {
  switch (column.content) {
    case FileColumn::Content::id:
      return encode_ids(rows);
    case FileColumn::Content::coordinate:
      return encode_coordinates(rows, lattice, column.axis);
    case FileColumn::Content::geometry:
      return encode_geometry(rows, lattice);
    case FileColumn::Content::attribute:
      break;
  }
  return encode_attribute(column, rows);
}

}  // namespace alidade::database
