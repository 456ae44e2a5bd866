// SPDX-License-Identifier: MIT
#include "database/point_stream.h"

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>
#include <algorithm>
#include <cstring>
#include <functional>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/parallel.h"
#include "cloud/lattice.h"
#include "cloud/rows.h"
#include "cloud/sorted_points.h"

namespace alidade::database {
namespace {

/// Key of a position on the Morton curve.
WideMortonKey morton_key_of(const LatticePosition& position) {
  constexpr std::uint32_t k_lowest = 0x80000000u;
  return wide_morton_key(static_cast<std::uint32_t>(position.x) ^ k_lowest,
                         static_cast<std::uint32_t>(position.y) ^ k_lowest,
                         static_cast<std::uint32_t>(position.z) ^ k_lowest);
}

/// The rows of a cloud along that curve, which is the same for all clouds; rows at one position keep their
/// order. Requires fewer than 2^32. Memory at the peak: 36 bytes per row.
std::vector<std::uint32_t> morton_order(const std::vector<LatticePosition>& positions) {
  if (positions.empty()) return {};
  std::vector<std::uint32_t> order;
  order.reserve(positions.size());
  const KeySpace space = aligned_key_space(positions);
  const auto sort = [&]<class Entry>(const Entry&) {
    const SortedPoints<Entry> sorted = sort_points<Entry>(space, positions);
    for (std::size_t i = 0; i < sorted.size(); ++i) order.push_back(sorted[i].id);
  };
  space.is_narrow() ? sort(NarrowEntry{}) : sort(WideEntry{});
  return order;
}

constexpr std::uint64_t k_block_points = 1024;
constexpr std::size_t k_blocks_per_write = 64;

std::size_t record_size(const std::vector<ValueBlob>& blobs) {
  std::size_t size = sizeof(LatticePosition) + sizeof(std::uint32_t);
  for (const ValueBlob& blob : blobs) size += blob.size;
  return size;
}

/// Writes the columns of these rows to `out`, one after another.
void put_block(const PointCloud& piece, const std::vector<ValueBlob>& blobs,
               std::span<const std::uint32_t> rows, std::byte* out) {
  const auto put = [&](const std::byte* values, std::size_t size) {
    for (const std::uint32_t row : rows) {
      std::memcpy(out, values + row * size, size);
      out += size;
    }
  };
  put(reinterpret_cast<const std::byte*>(piece.positions.data()), sizeof(LatticePosition));
  std::memcpy(out, rows.data(), rows.size_bytes());
  out += rows.size_bytes();
  for (const ValueBlob& blob : blobs) put(blob.values, blob.size);
}

/// Copies a blob of `size` bytes per point to `out`. A k_size other than 0 is the same size as a constant,
/// for which the compiler needs no call of memcpy().
template <std::size_t k_size>
void gather(const PickedPoints& points, std::size_t blob, std::size_t size, std::byte* out) {
  if constexpr (k_size != 0) size = k_size;
  for (const auto& [block, row] : points.picks) {
    if (const std::byte* const values = block->blobs[blob].values)
      std::memcpy(out, values + row * size, size);
    out += size;
  }
}

auto gatherer(std::size_t size) {
  return size == 1   ? gather<1>
         : size == 2 ? gather<2>
         : size == 4 ? gather<4>
         : size == 6 ? gather<6>
         : size == 8 ? gather<8>
                     : gather<0>;
}

/// Spreads the colour values, `count` per point, of the points that the spread concerns.
void spread_values(const ColorSpread& spread, const PickedPoints& points, std::size_t count,
                   std::vector<std::byte>& bytes) {
  std::byte* at = bytes.data();
  for (const auto& [block, row] : points.picks) {
    const bool is_concerned = spread.concerns(block->id(row));
    for (std::size_t i = 0; i < count; ++i, at += sizeof(std::uint16_t)) {
      if (is_concerned) store(at, ColorSpread::spread(load<std::uint16_t>(at)));
    }
  }
}

}  // namespace

void PointStream::write_run(const PointCloud& piece) {
  const AttributeColumns columns = columns_of(piece);
  Run run{.first_id = size_, .count = piece.size(), .offset = file_.size(), .blobs = value_blobs(columns)};
  const std::vector<std::uint32_t> order = morton_order(piece.positions);
  const std::size_t record = record_size(run.blobs);
  const std::size_t lot = k_block_points * k_blocks_per_write;
  std::vector<std::byte> bytes;
  for (std::size_t first = 0; first < order.size(); first += lot) {
    const std::size_t count = std::min(lot, order.size() - first);
    bytes.resize(count * record);
    in_blocks(count, k_block_points, [&](std::size_t begin, std::size_t end) {
      put_block(piece, run.blobs, std::span(order).subspan(first + begin, end - begin),
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
  file_.read(run.offset + first * record, block->memory);
  block->first_id = run.first_id;
  const std::byte* cursor = block->memory.data();
  const auto take = [&](std::size_t size) { return std::exchange(cursor, cursor + size * count); };
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

/// Picks points of a run that are before `limit`, the first point of all other runs.
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

void PointStream::for_each_group(std::size_t size, std::size_t most,
                                 const std::function<void(std::size_t, PickedPoints)>& encode,
                                 const std::function<void(std::size_t)>& finish) {
  // Owned here, since the pipeline drops its contents when it is cancelled.
  std::vector<PickedPoints> picked(most);
  std::size_t begun = 0;
  const auto take = [&](tbb::flow_control& control) {
    const std::size_t slot = begun++ % most;
    picked[slot] = next(size);
    if (picked[slot].picks.empty()) control.stop();
    return slot;
  };
  const auto encode_slot = [&](std::size_t slot) {
    encode(slot, std::exchange(picked[slot], {}));
    return slot;
  };
  tbb::parallel_pipeline(
      most, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, take) &
                tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, encode_slot) &
                tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, finish));
}

EncodedChunks encode(const ChunkEncoding& encoding, const PickedPoints& points) {
  EncodedChunks chunks;
  const std::size_t count = points.picks.size();
  chunks.positions.resize(count);
  std::vector<std::byte>& ids = chunks.blobs.emplace_back(count * sizeof(std::uint64_t));
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [block, row] = points.picks[i];
    chunks.positions[i] = block->positions[row];
    const std::uint64_t id = block->id(row);
    std::memcpy(ids.data() + i * sizeof id, &id, sizeof id);
    if (i % encoding.chunk_points == 0) chunks.boxes.emplace_back();
    chunks.boxes.back().grow(to_world(encoding.lattice, chunks.positions[i]));
  }
  for (std::size_t blob = 0; blob < encoding.blobs.size(); ++blob) {
    const ValueBlob& about = encoding.blobs[blob];
    std::vector<std::byte>& bytes = chunks.blobs.emplace_back(count * about.size);
    gatherer(about.size)(points, blob, about.size, bytes.data());
    if (encoding.spread.colors && about.is(Attribute::color))
      spread_values(encoding.spread, points, 3, bytes);
    if (encoding.spread.near_infrared && about.is(Attribute::near_infrared))
      spread_values(encoding.spread, points, 1, bytes);
  }
  return chunks;
}

OrderedCloud::OrderedCloud(const std::filesystem::path& folder, const CloudInputs& inputs,
                           const ReadOptions& reading, std::uint64_t memory)
    : points(folder),
      whole(read_in_pieces(inputs, reading,
                           {.most_bytes = memory,
                            .bytes_beside = PointStream::k_bytes_beside,
                            .take = [this](PointCloud& piece) { points.add(piece); }})) {
  points.finish(whole.rest);
}

OrderedCloud::OrderedCloud(const PointCloud& cloud) {
  check_that(cloud.size() <= UINT32_MAX, "too many points in memory",
             fmt::format("at most {}, or files", UINT32_MAX), std::to_string(cloud.size()));
  points.finish(cloud);
  describe(cloud);
}

OrderedCloud::OrderedCloud(const std::filesystem::path& folder, const PointCloud& facts,
                           std::uint64_t point_count, const PointPieces& pieces)
    : points(folder) {
  while (points.size() < point_count) {
    PointCloud piece = pieces(points.size());
    points.add(piece);
  }
  points.finish(whole.rest);
  describe(facts);
}

void OrderedCloud::describe(const PointCloud& cloud) {
  whole.rest.lattice = cloud.lattice;
  whole.rest.crs = cloud.crs;
  whole.rest.gps_time_is_standard = cloud.gps_time_is_standard;
  for (const ExtraDimension& dimension : cloud.extra_dimensions)
    whole.rest.extra_dimensions.push_back(description_of(dimension));
}

std::vector<StoredColumn> OrderedCloud::columns() const {
  std::vector<ExtraDimension> dimensions;
  for (const ExtraDimension& dimension : whole.rest.extra_dimensions)
    dimensions.push_back(description_of(dimension));
  AttributeSet attributes;
  for (const ValueBlob& blob : points.blobs()) {
    if (blob.number < ValueBlob::number_of(Attribute::extra_dimensions))
      attributes.bits |= std::uint32_t{1} << blob.number;
  }
  return stored_columns(attributes, std::move(dimensions));
}

ChunkEncoding OrderedCloud::encoding(std::uint32_t chunk_points) const {
  return {.chunk_points = chunk_points,
          .lattice = whole.rest.lattice,
          .blobs = points.blobs(),
          .spread = whole.spread};
}

}  // namespace alidade::database
