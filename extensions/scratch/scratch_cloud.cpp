// SPDX-License-Identifier: MIT
#include "extensions/scratch/scratch_cloud.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/huge_memory.h"
#include "cloud/read_in_pieces.h"
#include "cloud/rows.h"
#include "cloud/select_points.h"

namespace alidade {
namespace {

/// Releases the memory of columns, which they keep when their rows are removed.
void give_back_room(PointCloud& cloud) {
  std::vector<LatticePosition>().swap(cloud.positions);
  for_each_column(cloud, []<class Column>(Attribute, Column& column) { Column().swap(column); });
  for (ExtraDimension& dimension : cloud.extra_dimensions) std::vector<std::uint8_t>().swap(dimension.values);
}

constexpr const char* k_position_file = "positions";

std::string column_name(std::size_t number) {
  return fmt::format("attribute-{}", number);
}

}  // namespace

ScratchCloud::ScratchCloud(const CloudInputs& inputs, const ReadOptions& options, const ScratchSpace& scratch,
                           ScratchCheckpoint* checkpoint)
    : scratch_(scratch),
      checkpoint_(checkpoint),
      recalled_(checkpoint ? checkpoint->rows() : 0),
      positions_(file(k_position_file, sizeof(LatticePosition))) {
  if (positions_.size() / sizeof(LatticePosition) != recalled_)
    fail_as_corrupt(k_position_file, positions_.size());
  const CloudPieces pieces{.most_bytes = scratch.memory,
                           .take = [this](PointCloud& piece) { take(piece); },
                           .recall = [this](PointCloud& piece, std::size_t first,
                                            std::size_t count) { return recall(piece, first, count); }};
  PiecewiseCloud whole;
  try {
    whole = read_in_pieces(inputs, options, pieces);
    take(whole.rest);
    if (size_ < recalled_)
      checkpoint_->fail_as_corrupt("more points than the input has", fmt::format("at most {}", size_),
                                   std::to_string(recalled_));
  } catch (...) {
    keep();
    throw;
  }
  keep();
  for (Column& column : columns_) column.file.append_zeros(size_ * column.value_bytes - column.file.size());
  facts_ = std::move(whole.rest);
  give_back_room(facts_);
  if (whole.spread.colors)
    spread_values<Color16>(Attribute::color, [&](std::span<Color16> colors, std::uint64_t row) {
      apply(whole.spread, colors, {}, row);
    });
  if (whole.spread.near_infrared)
    spread_values<std::uint16_t>(
        Attribute::near_infrared,
        [&](std::span<std::uint16_t> values, std::uint64_t row) { apply(whole.spread, {}, values, row); });
}

void ScratchCloud::fail_as_corrupt(const std::string& name, std::uint64_t bytes) const {
  checkpoint_->fail_as_corrupt(fmt::format("wrong number of bytes of {}", name),
                               fmt::format("those of {} points", recalled_), std::to_string(bytes));
}

KeptFile ScratchCloud::file(const std::string& name, std::size_t value_bytes) const {
  if (!checkpoint_) return KeptFile(scratch_.folder);
  KeptFile file = checkpoint_->file(name);
  // A shorter column has zeros behind its end.
  if (file.size() / value_bytes > recalled_) fail_as_corrupt(name, file.size());
  return file;
}

ScratchCloud::Column& ScratchCloud::column(std::size_t number, std::size_t value_bytes) {
  while (columns_.size() <= number) columns_.push_back({0, KeptFile(scratch_.folder)});
  Column& column = columns_[number];
  if (column.value_bytes == 0) column = {value_bytes, file(column_name(number), value_bytes)};
  return column;
}

void ScratchCloud::take(PointCloud& piece) {
  // The first rows of the piece may be those of the earlier run.
  const std::size_t known = size_ < recalled_ ? std::min<std::size_t>(piece.size(), recalled_ - size_) : 0;
  if (known < piece.size()) positions_.append(std::as_bytes(std::span(piece.positions).subspan(known)));
  for_each_column(piece, [&](Attribute attribute, const auto& column) {
    if (!column.empty()) add(number_of(attribute), sizeof column[0], std::as_bytes(std::span(column)), known);
  });
  std::size_t number = number_of(Attribute::extra_dimensions);
  for (const ExtraDimension& dimension : piece.extra_dimensions)
    add(number++, static_cast<std::size_t>(dimension.byte_count), std::as_bytes(std::span(dimension.values)),
        known);
  size_ += piece.size();
  piece.resize(0);
  if (checkpoint_ && checkpoint_->is_due()) keep();
}

void ScratchCloud::add(std::size_t number, std::size_t value_bytes, std::span<const std::byte> values,
                       std::size_t known) {
  KeptFile& file = column(number, value_bytes).file;
  const std::span<const std::byte> added = values.subspan(known * value_bytes);
  if (added.empty()) return;
  file.append_zeros((size_ + known) * value_bytes - file.size());
  file.append(added);
}

bool ScratchCloud::recall(PointCloud& piece, std::size_t first, std::size_t count) {
  const std::uint64_t row = size_ + first;
  if (row + count > recalled_) return false;
  const auto fill = [&](const KeptFile& file, auto& values) {
    const std::span<std::byte> bytes = std::as_writable_bytes(std::span(values).subspan(first, count));
    const std::uint64_t begin = row * sizeof values[0];
    // A shorter column has zeros behind its end.
    const std::uint64_t there = file.size() - std::min(begin, file.size());
    file.read(begin, bytes.first(std::min<std::size_t>(bytes.size(), there)));
  };
  fill(positions_, piece.positions);
  if (!piece.colors.empty()) fill(column(number_of(Attribute::color), sizeof(Color16)).file, piece.colors);
  if (!piece.near_infrared.empty())
    fill(column(number_of(Attribute::near_infrared), sizeof(std::uint16_t)).file, piece.near_infrared);
  return true;
}

/// Writes to a new file, as a checkpoint keeps the values that were read.
template <class Value>
void ScratchCloud::spread_values(Attribute attribute,
                                 const std::function<void(std::span<Value>, std::uint64_t)>& spread) {
  constexpr std::uint64_t k_block = 1 << 17;
  if (number_of(attribute) >= columns_.size()) return;
  KeptFile& file = columns_[number_of(attribute)].file;
  if (file.size() == 0) return;
  KeptFile changed(scratch_.folder);
  std::vector<Value> values;
  for (std::uint64_t row = 0; row < size_; row += k_block) {
    values.resize(static_cast<std::size_t>(std::min(k_block, size_ - row)));
    file.read(row * sizeof(Value), std::as_writable_bytes(std::span(values)));
    spread(values, row);
    changed.append(std::as_bytes(std::span(values)));
  }
  file = std::move(changed);
}

void ScratchCloud::keep() {
  if (!checkpoint_ || size_ <= checkpoint_->rows()) return;
  std::vector<ScratchCheckpoint::Kept> files;
  const auto add = [&](const std::string& name, KeptFile& file, std::size_t value_bytes) {
    files.push_back({name, &file, std::min(file.size(), size_ * value_bytes)});
  };
  add(k_position_file, positions_, sizeof(LatticePosition));
  for (std::size_t number = 0; number < columns_.size(); ++number) {
    Column& column = columns_[number];
    if (column.value_bytes > 0) add(column_name(number), column.file, column.value_bytes);
  }
  checkpoint_->keep(size_, files);
}

std::span<std::byte> ScratchCloud::bytes_of(std::size_t number) {
  return number < columns_.size() ? columns_[number].file.map() : std::span<std::byte>();
}

std::span<LatticePosition> ScratchCloud::positions() {
  const std::span<std::byte> bytes = positions_.map();
  return {reinterpret_cast<LatticePosition*>(bytes.data()), bytes.size() / sizeof(LatticePosition)};
}

AttributeColumns ScratchCloud::columns() {
  AttributeColumns columns;
  for_each_column(columns, [&](Attribute attribute, auto& column) {
    using Value = std::remove_cvref_t<decltype(column[0])>;
    column = std::span<const Value>(column_of<Value>(attribute));
  });
  std::size_t number = number_of(Attribute::extra_dimensions);
  for (const ExtraDimension& dimension : facts_.extra_dimensions) {
    const std::span<std::byte> bytes = bytes_of(number++);
    columns.extra_dimensions.push_back(
        {description_of(dimension), {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}});
  }
  return columns;
}

PointCloud ScratchCloud::rows(std::size_t first, std::size_t count) {
  PointCloud some;
  some.lattice = facts_.lattice;
  some.extra_dimensions = facts_.extra_dimensions;
  const auto positions = this->positions().subspan(first, count);
  some.positions.assign(positions.begin(), positions.end());
  const AttributeColumns all = columns();
  for_each_column(some, all, [&](Attribute, auto& column, const auto& values) {
    if (values.empty()) return;
    const auto part = values.subspan(first, count);
    column.assign(part.begin(), part.end());
  });
  for (std::size_t i = 0; i < some.extra_dimensions.size(); ++i) {
    const auto bytes = static_cast<std::size_t>(some.extra_dimensions[i].byte_count);
    const auto part = all.extra_dimensions[i].values.subspan(first * bytes, count * bytes);
    some.extra_dimensions[i].values.assign(part.begin(), part.end());
  }
  return some;
}

void ScratchCloud::keep_rows(std::span<const std::uint8_t> marks, const Progress& progress) {
  assert(!checkpoint_ && marks.size() == size());
  constexpr std::size_t k_block = std::size_t{1} << 20;
  const std::uint64_t column_count = 1 + columns_.size();
  std::uint64_t columns_done = 0;
  const auto report_row = [&](std::size_t row) {
    report(progress, (columns_done * marks.size() + row) / column_count, marks.size());
  };
  const auto close_up = [&](KeptFile& file, std::size_t value_bytes) {
    const std::span<const std::byte> all = file.map();
    if (all.empty()) return;
    KeptFile kept(scratch_.folder);
    std::vector<std::byte> block;
    for (std::size_t row = 0; row < marks.size(); ++row) {
      if (row % k_block == 0) report_row(row);
      if (marks[row] == 0) continue;
      const auto value = all.subspan(row * value_bytes, value_bytes);
      block.insert(block.end(), value.begin(), value.end());
      if (block.size() < k_block) continue;
      kept.append(block);
      block.clear();
    }
    kept.append(block);
    file = std::move(kept);
    ++columns_done;
  };
  close_up(positions_, sizeof(LatticePosition));
  for (Column& column : columns_) close_up(column.file, column.value_bytes);
  count_points(facts_.files, marks);
  size_ = positions_.size() / sizeof(LatticePosition);
  report(progress, marks.size(), marks.size());
}

void ScratchCloud::keep_every(std::uint64_t step, const Progress& progress) {
  HugeVector<std::uint8_t> marks(size(), 0, ScratchFolder(scratch_.folder));
  for (std::size_t row = 0; row < marks.size(); row += std::min<std::uint64_t>(step, marks.size() - row))
    marks[row] = 1;
  keep_rows(marks, progress);
}

void ScratchCloud::thin(double edge, const Progress& progress) {
  const ThinnedColumns columns{facts_.lattice, positions(), column_of<Color16>(Attribute::color),
                               column_of<std::uint16_t>(Attribute::near_infrared),
                               column_of<std::uint16_t>(Attribute::intensity)};
  const auto marks = mark_thinned(columns, edge, scratch_.folder, progress);
  const std::uint64_t count = marks.size();
  keep_rows(marks, [&](std::uint64_t, std::uint64_t) { return !progress || progress(count, count); });
}

std::span<glm::vec3> ScratchCloud::add_normals() {
  assert(!checkpoint_);
  KeptFile& file = column(number_of(Attribute::normal), sizeof(glm::vec3)).file;
  file.append_zeros(size_ * sizeof(glm::vec3) - file.size());
  return column_of<glm::vec3>(Attribute::normal);
}

void ScratchCloud::close() {
  positions_ = KeptFile(scratch_.folder);
  columns_.clear();
}

}  // namespace alidade
