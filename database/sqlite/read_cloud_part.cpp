// SPDX-License-Identifier: MIT
#include "database/sqlite/read_cloud_part.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "cloud/rows.h"
#include "database/sqlite/stored_cloud.h"

namespace alidade {
namespace {

std::vector<ChunkPlace> wanted_chunks(ChunkStore& store, std::span<const PointFilter> any_of) {
  std::vector<ChunkPlace> chunks;
  for (const PointFilter& filter : any_of)
    std::ranges::move(store.chunks(filter), std::back_inserter(chunks));
  std::ranges::sort(chunks, {}, &ChunkPlace::id);
  const auto is_same = [](const ChunkPlace& one, const ChunkPlace& other) { return one.id == other.id; };
  chunks.erase(std::unique(chunks.begin(), chunks.end(), is_same), chunks.end());
  return chunks;
}

/// Brings the rows into the order of their ids.
void sort_by_id(CloudPart& part, const StoredCloud& stored) {
  std::vector<std::uint32_t> order(part.ids.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](std::uint32_t row) { return part.ids[row]; });
  reorder_attributes(part.cloud, order);
  std::vector<LatticePosition> positions;
  std::vector<std::uint64_t> ids;
  for (const std::uint32_t row : order) {
    positions.push_back(part.cloud.positions[row]);
    if (!ids.empty() && ids.back() == part.ids[row])
      stored.refuse(stored.schema().chunk_count, "two points have one id", "each once",
                    std::to_string(ids.back()));
    ids.push_back(part.ids[row]);
  }
  part.cloud.positions = std::move(positions);
  part.ids = std::move(ids);
}

}  // namespace

CloudPart read_cloud_part(const std::string& name, std::span<const PointFilter> any_of,
                          AttributeSet attributes, const Progress& progress) {
  const StoredCloud stored(name);
  ChunkStore store = stored.chunks();
  CloudPart part;
  part.cloud.lattice = stored.schema().lattice;
  part.cloud.crs = stored.schema().crs;
  part.cloud.gps_time_is_standard = stored.schema().gps_time_is_standard;
  part.attributes = stored.attributes();
  part.chunk_count = stored.schema().chunk_count;
  const std::vector<ChunkPlace> chunks = wanted_chunks(store, any_of);
  const AttributeSet kept = part.attributes & attributes;
  for (const ChunkPlace& place : chunks) {
    const std::shared_ptr<StoredChunk> chunk = store.read(place);
    const std::size_t first = part.ids.size(), count = chunk->positions.size();
    // Rows are made ahead, as many as there are, since columns are moved when they grow.
    if (first + count > part.cloud.size()) append_rows(part.cloud, kept, std::max(first, count));
    const StoredCloud::Columns columns(stored, part.cloud, kept, first);
    for (std::size_t i = 0; i < count; ++i) {
      part.cloud.positions[first + i] = chunk->positions[i];
      part.ids.push_back(stored.id(store, *chunk, i));
      columns.copy(store, *chunk, i, i);
    }
    report(progress, ++part.chunks_read, chunks.size());
  }
  part.cloud.resize(part.ids.size());
  sort_by_id(part, stored);
  CloudFile& file = part.cloud.files.emplace_back();
  file.path = name;
  file.format = "SQLite";
  file.version = std::to_string(k_cloud_table_version);
  file.point_count = part.ids.size();
  return part;
}

}  // namespace alidade
