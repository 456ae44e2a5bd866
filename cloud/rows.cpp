// SPDX-License-Identifier: MIT
#include "cloud/rows.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <iterator>

#include "base/parallel.h"

namespace alidade {

bool same_meaning(const ExtraDimension& a, const ExtraDimension& b) {
  // Bits are compared, so that a NaN from a damaged file equals itself.
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  return a.name == b.name && a.type == b.type && a.byte_count == b.byte_count && a.has_scale == b.has_scale &&
         a.has_offset == b.has_offset && bits(a.scale) == bits(b.scale) && bits(a.offset) == bits(b.offset) &&
         a.no_data == b.no_data;
}

ExtraDimension description_of(const ExtraDimension& dimension) {
  return {.name = dimension.name,
          .description = dimension.description,
          .type = dimension.type,
          .byte_count = dimension.byte_count,
          .scale = dimension.scale,
          .offset = dimension.offset,
          .has_scale = dimension.has_scale,
          .has_offset = dimension.has_offset,
          .no_data = dimension.no_data,
          .values = {}};
}

std::uint64_t bytes_per_point(const PointCloud& cloud, AttributeSet attributes) {
  std::uint64_t bytes = sizeof(LatticePosition);
  for_each_column(cloud, [&](Attribute attribute, const auto& column) {
    if (attributes.contains(attribute)) bytes += sizeof column[0];
  });
  for (const ExtraDimension& dimension : cloud.extra_dimensions)
    bytes += static_cast<std::uint64_t>(dimension.byte_count);
  return bytes;
}

void append_rows(PointCloud& cloud, AttributeSet filled, std::size_t count) {
  // Touching the memory of this many rows takes as long as unpacking some of them, so threads share it.
  constexpr std::size_t k_rows_for_threads = 1 << 16;
  const std::size_t size = cloud.size() + count;
  const std::size_t room = std::max(size, cloud.positions.capacity());
  std::vector<std::function<void()>> columns;
  columns.emplace_back([&cloud, size] { cloud.positions.resize(size, LatticePosition(0)); });
  for_each_column(cloud, [&](Attribute attribute, auto& column) {
    if (column.empty() && !filled.contains(attribute)) return;
    columns.emplace_back([&column, size, room] {
      // A new column reserves as much room as the positions have, so that it is not moved either.
      if (column.empty()) column.reserve(room);
      column.resize(size);
    });
  });
  for (ExtraDimension& dimension : cloud.extra_dimensions) {
    columns.emplace_back([&dimension, size] {
      dimension.values.resize(size * static_cast<std::size_t>(dimension.byte_count));
    });
  }
  if (count < k_rows_for_threads) {
    for (const auto& extend : columns) extend();
  } else {
    in_parallel(columns.size(), 1, [&](std::size_t i) { columns[i](); });
  }
}

std::size_t find_extra_dimension(PointCloud& cloud, const ExtraDimension& like, std::size_t occurrence) {
  for (std::size_t i = 0; i < cloud.extra_dimensions.size(); ++i) {
    if (same_meaning(cloud.extra_dimensions[i], like) && occurrence-- == 0) return i;
  }
  ExtraDimension& added = cloud.extra_dimensions.emplace_back(description_of(like));
  const std::size_t bytes = static_cast<std::size_t>(like.byte_count);
  added.values.reserve(cloud.positions.capacity() * bytes);
  added.values.resize(cloud.size() * bytes);
  return cloud.extra_dimensions.size() - 1;
}

namespace {

/// Lengthens a column of `width` values per point from `before` points by those of `more`, or by zeros.
template <class Column>
void lengthen(Column& column, const Column& more, std::size_t before, std::size_t after, std::size_t room,
              std::size_t width = 1) {
  if (column.empty() && more.empty()) return;
  column.reserve(std::max(after, room) * width);
  column.resize(before * width);
  column.insert(column.end(), more.begin(), more.end());
  column.resize(after * width);
}

template <class Value>
void move_behind(std::vector<Value>& values, std::vector<Value>& more) {
  std::ranges::move(more, std::back_inserter(values));
}

/// The first marked row that is not before this one.
std::size_t marked_row(std::span<const std::uint8_t> marks, std::size_t row) {
  while (row < marks.size() && marks[row] == 0) ++row;
  return row;
}

/// Calls move(from, to) for every row that is kept, in order; returns their number. `next(row)` is the first
/// row behind `row` that is kept.
template <class Next, class Move>
std::size_t close_up(std::size_t first, std::size_t size, const Next& next, const Move& move) {
  std::size_t to = 0;
  for (std::size_t from = first; from < size; from = next(from)) move(from, to++);
  return to;
}

/// Counts the points of each file again, if the files have all rows of the cloud.
template <class Next>
void count_points(std::vector<CloudFile>& files, std::size_t size, std::size_t first, const Next& next) {
  std::uint64_t end = 0;
  for (const CloudFile& file : files) end += file.point_count;
  if (end != size) return;
  end = 0;
  std::size_t row = first;
  for (CloudFile& file : files) {
    end += file.point_count;
    file.point_count = 0;
    for (; row < end; row = next(row)) ++file.point_count;
  }
}

template <class Next>
void keep(PointCloud& cloud, std::size_t first, const Next& next) {
  const std::size_t size = cloud.size();
  count_points(cloud.files, size, first, next);
  const auto close_column = [&](auto& column) {
    return close_up(first, size, next, [&](std::size_t from, std::size_t to) { column[to] = column[from]; });
  };
  for_each_column(cloud, [&](Attribute, auto& column) {
    assert(column.empty() || column.size() == size);
    if (!column.empty()) close_column(column);
  });
  for (ExtraDimension& dimension : cloud.extra_dimensions) {
    const auto bytes = static_cast<std::size_t>(dimension.byte_count);
    assert(dimension.values.size() == size * bytes);
    close_up(first, size, next, [&](std::size_t from, std::size_t to) {
      std::memmove(dimension.values.data() + to * bytes, dimension.values.data() + from * bytes, bytes);
    });
  }
  cloud.resize(close_column(cloud.positions));
}

template <class Value>
void reorder(std::vector<Value>& column, std::span<const std::uint32_t> order) {
  if (column.empty()) return;
  assert(column.size() == order.size());
  std::vector<Value> ordered;
  ordered.reserve(order.size());
  for (const std::uint32_t row : order) ordered.push_back(column[row]);
  column.swap(ordered);
}

void reorder(ExtraDimension& dimension, std::span<const std::uint32_t> order) {
  const auto width = static_cast<std::size_t>(dimension.byte_count);
  assert(dimension.values.size() == order.size() * width);
  std::vector<std::uint8_t> ordered(dimension.values.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    std::memcpy(ordered.data() + i * width, dimension.values.data() + order[i] * width, width);
  dimension.values.swap(ordered);
}

}  // namespace

void append_cloud(PointCloud& cloud, PointCloud&& piece) {
  assert(cloud.lattice == piece.lattice);
  const std::size_t before = cloud.size(), after = before + piece.size();
  const std::size_t room = cloud.positions.capacity();
  for (std::size_t i = 0; i < piece.extra_dimensions.size(); ++i) {
    const ExtraDimension& own = piece.extra_dimensions[i];
    const std::size_t occurrence = occurrence_of(piece.extra_dimensions, i);
    ExtraDimension& column = cloud.extra_dimensions[find_extra_dimension(cloud, own, occurrence)];
    lengthen(column.values, own.values, before, after, room, static_cast<std::size_t>(own.byte_count));
  }
  for (ExtraDimension& dimension : cloud.extra_dimensions)
    dimension.values.resize(after * static_cast<std::size_t>(dimension.byte_count));
  for_each_column(cloud, piece, [&](Attribute, auto& column, const auto& own) {
    lengthen(column, own, before, after, room);
  });
  cloud.positions.insert(cloud.positions.end(), piece.positions.begin(), piece.positions.end());
  move_behind(cloud.records, piece.records);
  move_behind(cloud.scanner_positions, piece.scanner_positions);
  move_behind(cloud.warnings, piece.warnings);
}

void keep_rows(PointCloud& cloud, std::span<const std::uint8_t> marks) {
  assert(marks.size() == cloud.size());
  keep(cloud, marked_row(marks, 0), [&](std::size_t row) { return marked_row(marks, row + 1); });
}

void count_points(std::vector<CloudFile>& files, std::span<const std::uint8_t> marks) {
  count_points(files, marks.size(), marked_row(marks, 0),
               [&](std::size_t row) { return marked_row(marks, row + 1); });
}

void keep_every(PointCloud& cloud, std::uint64_t step) {
  assert(step >= 1);
  const std::size_t size = cloud.size();
  // A step beyond the end must not wrap around.
  keep(cloud, 0, [&](std::size_t row) { return step < size - row ? row + step : size; });
}

void reorder_attributes(PointCloud& cloud, std::span<const std::uint32_t> order) {
  for_each_column(cloud, [&](Attribute, auto& column) { reorder(column, order); });
  for (ExtraDimension& dimension : cloud.extra_dimensions) reorder(dimension, order);
}

RowIds::RowIds(std::span<const CloudFile> files) {
  std::uint64_t row = 0, before = 0;
  for (const CloudFile& file : files) {
    row += file.point_count;
    if (file.skipped_count == 0) continue;
    before += file.skipped_count;
    ++skipped_files_;
    if (!skips_.empty() && skips_.back().row == row) {
      skips_.back().before = before;
    } else {
      skips_.push_back({row, before});
    }
  }
}

std::uint64_t RowIds::operator()(std::uint64_t row) const {
  const auto next =
      std::upper_bound(skips_.begin(), skips_.end(), row,
                       [](std::uint64_t wanted, const Skip& skip) { return wanted < skip.row; });
  return next == skips_.begin() ? row : row + std::prev(next)->before;
}

}  // namespace alidade
