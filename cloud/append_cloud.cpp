// SPDX-License-Identifier: MIT
#include "cloud/append_cloud.h"

#include <algorithm>
#include <cassert>
#include <iterator>

#include "cloud/append_rows.h"
#include "cloud/attribute_columns.h"

namespace alidade {
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

}  // namespace

void append_cloud(PointCloud& cloud, PointCloud&& piece) {
  assert(cloud.lattice == piece.lattice);
  const std::size_t before = cloud.size(), after = before + piece.size();
  const std::size_t room = cloud.positions.capacity();
  for (std::size_t i = 0; i < piece.extra_dimensions.size(); ++i) {
    const ExtraDimension& own = piece.extra_dimensions[i];
    const auto equal = std::count_if(
        piece.extra_dimensions.begin(), piece.extra_dimensions.begin() + static_cast<std::ptrdiff_t>(i),
        [&](const ExtraDimension& earlier) { return same_meaning(earlier, own); });
    ExtraDimension& column =
        cloud.extra_dimensions[find_extra_dimension(cloud, own, static_cast<std::size_t>(equal))];
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

}  // namespace alidade
