// SPDX-License-Identifier: MIT
#include "database/point_stream.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <span>
#include <utility>

#include "database/morton_order.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_block_points = 1024;
constexpr std::size_t k_blocks_per_write = 64;

std::size_t record_size(const std::vector<ValueBlob>& blobs) {
  std::size_t size = sizeof(LatticePosition) + sizeof(std::uint32_t);
  for (const ValueBlob& blob : blobs) size += blob.size;
  return size;
}

/// The columns of these rows, one behind the other.
void put_block(const PointCloud& piece, const std::vector<ValueBlob>& blobs,
               std::span<const std::uint32_t> rows, std::byte* place) {
  const auto put = [&](const std::byte* values, std::size_t size) {
    for (const std::uint32_t row : rows) {
      std::memcpy(place, values + row * size, size);
      place += size;
    }
  };
  put(reinterpret_cast<const std::byte*>(piece.positions.data()), sizeof(LatticePosition));
  std::memcpy(place, rows.data(), rows.size_bytes());
  place += rows.size_bytes();
  for (const ValueBlob& blob : blobs) put(blob.values, blob.size);
}

}  // namespace

void PointStream::write_run(const PointCloud& piece) {
  const AttributeColumns columns = columns_of(piece);
  Run run{.first_id = size_, .count = piece.size(), .place = file_.size(), .blobs = value_blobs(columns)};
  const std::vector<std::uint32_t> order = morton_order(piece.positions);
  const std::size_t record = record_size(run.blobs);
  const std::size_t lot = k_block_points * k_blocks_per_write;
  std::vector<std::byte> bytes;
  for (std::size_t first = 0; first < order.size(); first += lot) {
    const std::size_t count = std::min(lot, order.size() - first);
    bytes.resize(count * record);
    tbb::parallel_for(std::size_t{0}, (count + k_block_points - 1) / k_block_points, [&](std::size_t block) {
      const std::size_t begin = block * k_block_points;
      put_block(piece, run.blobs,
                std::span(order).subspan(first + begin, std::min<std::size_t>(k_block_points, count - begin)),
                bytes.data() + begin * record);
    });
    file_.append(bytes);
  }
  for (ValueBlob& blob : run.blobs) blob.values = nullptr;
  runs_.push_back(std::move(run));
}

void PointStream::note_blobs(const PointCloud& piece) {
  for (const ValueBlob& blob : value_blobs(columns_of(piece))) {
    const auto known = std::ranges::lower_bound(blobs_, blob.number, {}, &ValueBlob::number);
    if (known == blobs_.end() || known->number != blob.number)
      blobs_.insert(known, {.size = blob.size, .number = blob.number});
  }
}

void PointStream::take(const PointCloud& piece) {
  note_blobs(piece);
  if (piece.size() > 0) write_run(piece);
  size_ += piece.size();
}

void PointStream::add(PointCloud& piece) {
  take(piece);
  piece.resize(0);
}

void PointStream::finish(const PointCloud& last) {
  if (!runs_.empty()) {
    take(last);
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      load_block(runs_[i]);
      heads_.push_back({runs_[i].keys[0], i});
    }
    std::ranges::make_heap(heads_, std::greater<>());
    return;
  }
  note_blobs(last);
  PointBlock block{.positions = last.positions.data(), .blobs = value_blobs(columns_of(last))};
  whole_ = std::make_shared<const PointBlock>(std::move(block));
  order_ = morton_order(last.positions);
  size_ = last.size();
}

void PointStream::load_block(Run& run) {
  const std::uint64_t first = run.next_block++ * k_block_points;
  const std::size_t count = static_cast<std::size_t>(std::min(k_block_points, run.count - first));
  const std::size_t record = record_size(run.blobs);
  auto block = std::make_shared<PointBlock>();
  block->memory.resize(count * record);
  file_.read(run.place + first * record, block->memory);
  block->first_id = run.first_id;
  const std::byte* place = block->memory.data();
  const auto take = [&](std::size_t size) { return std::exchange(place, place + size * count); };
  block->positions = reinterpret_cast<const LatticePosition*>(take(sizeof(LatticePosition)));
  block->rows = reinterpret_cast<const std::uint32_t*>(take(sizeof(std::uint32_t)));
  block->blobs = blobs_;
  auto blob = block->blobs.begin();
  for (const ValueBlob& own : run.blobs) {
    while (blob->number != own.number) ++blob;
    blob->values = take(own.size);
  }
  run.keys.resize(count);
  for (std::size_t i = 0; i < count; ++i) run.keys[i] = morton_key_of(block->positions[i]);
  run.block = std::move(block);
  run.at = 0;
  run.is_noted = false;
}

/// Picks points of a run as long as none of the others, whose first is `limit`, comes before them.
void PointStream::pick_from(Run& run, const std::optional<Head>& limit, std::size_t number, std::size_t count,
                            PickedPoints& picked) {
  while (picked.picks.size() < count) {
    if (run.at == run.keys.size()) {
      if (run.next_block * k_block_points >= run.count) return;
      load_block(run);
    }
    if (limit && Head{run.keys[run.at], number} > *limit) break;
    if (!std::exchange(run.is_noted, true)) picked.blocks.push_back(run.block);
    picked.picks.push_back({run.block.get(), run.at++});
  }
  if (run.at == run.keys.size() && run.next_block * k_block_points < run.count) load_block(run);
}

PickedPoints PointStream::next(std::size_t count) {
  PickedPoints picked;
  if (whole_) {
    const std::size_t end = std::min(order_.size(), next_ + count);
    picked.picks.reserve(end - next_);
    for (; next_ < end; ++next_) picked.picks.push_back({whole_.get(), order_[next_]});
    return picked;
  }
  picked.picks.reserve(count);
  for (Run& run : runs_) run.is_noted = false;
  while (picked.picks.size() < count && !heads_.empty()) {
    std::ranges::pop_heap(heads_, std::greater<>());
    const std::size_t number = heads_.back().run;
    heads_.pop_back();
    Run& run = runs_[number];
    pick_from(run, heads_.empty() ? std::nullopt : std::optional(heads_.front()), number, count, picked);
    if (run.at == run.keys.size()) continue;
    heads_.push_back({run.keys[run.at], number});
    std::ranges::push_heap(heads_, std::greater<>());
  }
  return picked;
}

}  // namespace alidade
