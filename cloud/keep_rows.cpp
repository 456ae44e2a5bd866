// SPDX-License-Identifier: MIT
#include "cloud/keep_rows.h"

#include <cassert>
#include <cstring>

#include "cloud/attribute_columns.h"

namespace alidade {
namespace {

/// Calls move(from, to) for every row that stays, in order; returns how many there are. `next(row)` is the
/// first row behind `row` that stays.
template <class Next, class Move>
std::size_t close_up(std::size_t first, std::size_t size, const Next& next, const Move& move) {
  std::size_t to = 0;
  for (std::size_t from = first; from < size; from = next(from)) move(from, to++);
  return to;
}

/// Counts the points of each file anew, where the files tell of all rows.
template <class Next>
void count_points(PointCloud& cloud, std::size_t first, const Next& next) {
  std::uint64_t end = 0;
  for (const CloudFile& file : cloud.files) end += file.point_count;
  if (end != cloud.size()) return;
  end = 0;
  std::size_t row = first;
  for (CloudFile& file : cloud.files) {
    end += file.point_count;
    file.point_count = 0;
    for (; row < end; row = next(row)) ++file.point_count;
  }
}

template <class Next>
void keep(PointCloud& cloud, std::size_t first, const Next& next) {
  const std::size_t size = cloud.size();
  count_points(cloud, first, next);
  const auto move_values = [&](auto& column) {
    assert(column.empty() || column.size() == size);
    if (!column.empty())
      close_up(first, size, next, [&](std::size_t from, std::size_t to) { column[to] = column[from]; });
  };
  for_each_column(cloud, cloud, [&](Attribute, auto& column, const auto&) { move_values(column); });
  for (ExtraDimension& dimension : cloud.extra_dimensions) {
    const auto bytes = static_cast<std::size_t>(dimension.byte_count);
    assert(dimension.values.size() == size * bytes);
    close_up(first, size, next, [&](std::size_t from, std::size_t to) {
      std::memmove(dimension.values.data() + to * bytes, dimension.values.data() + from * bytes, bytes);
    });
  }
  const std::size_t count = close_up(first, size, next, [&](std::size_t from, std::size_t to) {
    cloud.positions[to] = cloud.positions[from];
  });
  cloud.resize(count);
}

}  // namespace

void keep_rows(PointCloud& cloud, std::span<const std::uint8_t> marks) {
  assert(marks.size() == cloud.size());
  const auto at_or_behind = [&](std::size_t row) {
    while (row < marks.size() && marks[row] == 0) ++row;
    return row;
  };
  keep(cloud, at_or_behind(0), [&](std::size_t row) { return at_or_behind(row + 1); });
}

void keep_every(PointCloud& cloud, std::uint64_t step) {
  assert(step >= 1);
  const std::size_t size = cloud.size();
  // A step beyond the end must not wrap around.
  keep(cloud, 0, [&](std::size_t row) { return step < size - row ? row + step : size; });
}

}  // namespace alidade
