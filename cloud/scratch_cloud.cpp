// SPDX-License-Identifier: MIT
#include "cloud/scratch_cloud.h"

#include <bit>
#include <type_traits>
#include <utility>

#include "cloud/read_in_pieces.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

std::size_t number_of(Attribute attribute) {
  return static_cast<std::size_t>(std::countr_zero(static_cast<std::uint32_t>(attribute)));
}

/// Columns without rows keep the memory that these took.
void give_back_room(PointCloud& cloud) {
  std::vector<LatticePosition>().swap(cloud.positions);
  for_each_column(cloud, []<class Column>(Attribute, Column& column) { Column().swap(column); });
  for (ExtraDimension& dimension : cloud.extra_dimensions) std::vector<std::uint8_t>().swap(dimension.values);
}

}  // namespace

ScratchCloud::ScratchCloud(const CloudInputs& inputs, const ReadOptions& options, const ScratchSpace& scratch)
    : folder_(scratch.folder), positions_(folder_) {
  PiecewiseCloud whole = read_in_pieces(
      inputs, options, {.most_bytes = scratch.memory, .take = [this](PointCloud& piece) { take(piece); }});
  take(whole.rest);
  for (Column& column : columns_) column.file.append_zeros(size_ * column.value_bytes - column.file.size());
  facts_ = std::move(whole.rest);
  give_back_room(facts_);
  apply(whole.spread, values<Color16>(number_of(Attribute::color)),
        values<std::uint16_t>(number_of(Attribute::near_infrared)));
}

void ScratchCloud::take(PointCloud& piece) {
  positions_.append(std::as_bytes(std::span(piece.positions)));
  for_each_column(piece, [&](Attribute attribute, const auto& column) {
    if (!column.empty()) add(number_of(attribute), sizeof column[0], std::as_bytes(std::span(column)));
  });
  std::size_t number = number_of(Attribute::extra_dimensions);
  for (const ExtraDimension& dimension : piece.extra_dimensions)
    add(number++, static_cast<std::size_t>(dimension.byte_count), std::as_bytes(std::span(dimension.values)));
  size_ += piece.size();
  piece.resize(0);
}

void ScratchCloud::add(std::size_t number, std::size_t value_bytes, std::span<const std::byte> values) {
  while (columns_.size() <= number) columns_.push_back({0, ScratchFile(folder_)});
  Column& column = columns_[number];
  column.value_bytes = value_bytes;
  column.file.append_zeros(size_ * value_bytes - column.file.size());
  column.file.append(values);
}

template <class Value>
std::span<Value> ScratchCloud::values(std::size_t number) {
  if (number >= columns_.size()) return {};
  const std::span<std::byte> bytes = columns_[number].file.map();
  return {reinterpret_cast<Value*>(bytes.data()), bytes.size() / sizeof(Value)};
}

std::span<LatticePosition> ScratchCloud::positions() {
  const std::span<std::byte> bytes = positions_.map();
  return {reinterpret_cast<LatticePosition*>(bytes.data()), bytes.size() / sizeof(LatticePosition)};
}

AttributeColumns ScratchCloud::columns() {
  AttributeColumns columns;
  for_each_column(columns, [&]<class Column>(Attribute attribute, Column& column) {
    column = values<std::remove_const_t<typename Column::element_type>>(number_of(attribute));
  });
  std::size_t number = number_of(Attribute::extra_dimensions);
  for (const ExtraDimension& dimension : facts_.extra_dimensions)
    columns.extra_dimensions.push_back({description_of(dimension), values<std::uint8_t>(number++)});
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

}  // namespace alidade
