// SPDX-License-Identifier: MIT
#include "cloud/laz/record_writer.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include "base/bytes.h"
#include "base/parallel.h"
#include "cloud/laz/chunk_codec.h"
#include "cloud/laz/chunk_table.h"

namespace alidade {
struct RecordWriter::State {
  OutputFile& file;
  LazLayout layout;
  std::vector<std::uint32_t> counts;  ///< of points of the chunks, if layout.chunk_size is 0
  std::size_t record_size = layout.record_size();
  std::uint64_t first_offset = file.size();
  std::size_t batch_bytes;       ///< enough records to pack chunks at once
  std::vector<std::byte> batch;  ///< records that wait to be packed
  std::vector<LazChunk> chunks;
  tbb::enumerable_thread_specific<ChunkEncoder> encoders{[this] { return ChunkEncoder(layout); }};

  State(OutputFile& output, const LazLayout& laz, std::vector<std::uint32_t> of_chunks)
      : file(output), layout(laz), counts(std::move(of_chunks)) {
    constexpr std::size_t k_most_bytes = 64 << 20;
    const std::size_t usual = record_size * (layout.chunk_size > 0 ? layout.chunk_size : k_laz_chunk_size);
    const std::size_t threads = thread_count();
    batch_bytes = usual * std::max<std::size_t>(std::min(2 * threads, k_most_bytes / usual), 1);
    // Reserved at once, as growing would take up to three times as much; unused pages are never touched.
    batch.reserve(std::min(batch_bytes, k_most_bytes));
  }

  /// Bytes of the records of a chunk.
  std::size_t chunk_bytes(std::size_t number) const {
    return record_size * (layout.chunk_size > 0 ? layout.chunk_size : counts.at(number));
  }

  /// Packs the whole chunks of the batch, at the end also the last one of fixed size, which may be shorter.
  void write_batch(bool is_last) {
    std::vector<std::span<const std::byte>> records;
    std::size_t begin = 0;
    while (begin < batch.size()) {
      const std::size_t wanted = chunk_bytes(chunks.size() + records.size());
      if (batch.size() - begin < wanted && !is_last) break;
      records.push_back(std::span(batch).subspan(begin, std::min(wanted, batch.size() - begin)));
      begin += records.back().size();
    }
    std::vector<std::vector<std::byte>> packed(records.size());
    in_parallel(records.size(), 1, [&](std::size_t i) { packed[i] = encoders.local().encode(records[i]); });
    for (std::size_t i = 0; i < records.size(); ++i) {
      chunks.push_back({.offset = file.size(),
                        .byte_count = packed[i].size(),
                        .point_count = records[i].size() / record_size});
      file.write(packed[i]);
    }
    batch.erase(batch.begin(), batch.begin() + static_cast<std::ptrdiff_t>(begin));
  }
};

RecordWriter::RecordWriter(OutputFile& file, const std::optional<LazLayout>& packing,
                           std::vector<std::uint32_t> counts)
    : file_(file) {
  if (!packing) return;
  state_ = std::make_unique<State>(file, *packing, std::move(counts));
  // The offset of the table is known at the end only.
  file.write(std::array<std::byte, 8>{});
}

RecordWriter::~RecordWriter() = default;

void RecordWriter::write(std::span<const std::byte> records) {
  if (!state_) return file_.write(records);
  State& state = *state_;
  assert(records.size() % state.record_size == 0);
  while (!records.empty()) {
    // A chunk that is larger than a batch needs room for all of it.
    const std::size_t room = std::max(state.batch_bytes, state.chunk_bytes(state.chunks.size()));
    const std::size_t count = std::min(records.size(), room - state.batch.size());
    state.batch.insert(state.batch.end(), records.begin(),
                       records.begin() + static_cast<std::ptrdiff_t>(count));
    records = records.subspan(count);
    if (state.batch.size() == room) state.write_batch(false);
  }
}

void RecordWriter::finish() {
  if (!state_) return;
  State& state = *state_;
  state.write_batch(true);
  std::array<std::byte, 8> table_offset;
  store(table_offset.data(), state.file.size());
  state.file.write(encode_chunk_table(state.chunks, state.layout));
  state.file.write_at(state.first_offset, table_offset);
}

std::span<const LazChunk> RecordWriter::chunks() const {
  if (!state_) return {};
  return state_->chunks;
}

}  // namespace alidade
