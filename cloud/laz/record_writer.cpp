// SPDX-License-Identifier: MIT
#include "cloud/laz/record_writer.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

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
  std::size_t record_size = layout.record_size();
  std::size_t chunk_bytes = record_size * layout.chunk_size;  ///< of records, not packed
  std::uint64_t first_offset = file.size();
  std::size_t batch_bytes;       ///< of a whole number of chunks
  std::vector<std::byte> batch;  ///< records that wait to be packed
  std::vector<LazChunk> chunks;
  tbb::enumerable_thread_specific<ChunkEncoder> encoders{[this] { return ChunkEncoder(layout); }};

  State(OutputFile& output, const LazLayout& laz) : file(output), layout(laz) {
    constexpr std::size_t k_most_bytes = 64 << 20;
    const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    batch_bytes = chunk_bytes * std::max<std::size_t>(std::min(2 * threads, k_most_bytes / chunk_bytes), 1);
    // At once, or growing would take up to three times as much; pages that no record reaches are not touched.
    batch.reserve(std::min(batch_bytes, k_most_bytes));
  }

  void write_batch() {
    const std::size_t count = (batch.size() + chunk_bytes - 1) / chunk_bytes;
    std::vector<std::vector<std::byte>> packed(count);
    const std::span<const std::byte> records(batch);
    at_once(std::size_t{0}, count, [&](std::size_t i) {
      const std::size_t begin = i * chunk_bytes;
      packed[i] =
          encoders.local().encode(records.subspan(begin, std::min(chunk_bytes, records.size() - begin)));
    });
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t bytes = std::min(chunk_bytes, batch.size() - i * chunk_bytes);
      chunks.push_back(
          {.offset = file.size(), .byte_count = packed[i].size(), .point_count = bytes / record_size});
      file.write(packed[i]);
    }
    batch.clear();
  }
};

RecordWriter::RecordWriter(OutputFile& file, const std::optional<LazLayout>& packing) : file_(file) {
  if (!packing) return;
  assert(packing->chunk_size > 0);
  state_ = std::make_unique<State>(file, *packing);
  // The offset of the table, which is known at the end.
  file.write(std::array<std::byte, 8>{});
}

RecordWriter::~RecordWriter() = default;

void RecordWriter::write(std::span<const std::byte> records) {
  if (!state_) return file_.write(records);
  State& state = *state_;
  assert(records.size() % state.record_size == 0);
  while (!records.empty()) {
    const std::size_t count = std::min(records.size(), state.batch_bytes - state.batch.size());
    state.batch.insert(state.batch.end(), records.begin(),
                       records.begin() + static_cast<std::ptrdiff_t>(count));
    records = records.subspan(count);
    if (state.batch.size() == state.batch_bytes) state.write_batch();
  }
}

void RecordWriter::finish() {
  if (!state_) return;
  State& state = *state_;
  state.write_batch();
  std::array<std::byte, 8> table_offset;
  store(table_offset.data(), state.file.size());
  state.file.write(encode_chunk_table(state.chunks, state.layout));
  state.file.write_at(state.first_offset, table_offset);
}

}  // namespace alidade
