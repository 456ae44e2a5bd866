// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "cloud/laz/chunk_codec.h"
#include "cloud/laz/corrupt_chunk.h"
#include "cloud/laz/laz_points.h"

namespace alidade {

/// One reading of a LAZ file: see LazPoints::read(). What it is given must outlive it.
class ChunkUnpacker {
 public:
  ChunkUnpacker(InputFile& file, const LasHeader& header, const LazLayout& layout, const LazLayers& wanted,
                Damage damage, LazSink& sink, const Progress& progress);

  /// Unpacks chunks that lie one behind the other.
  std::vector<LostPoints> read_chunks(std::span<const LazChunk> chunks);
  /// Unpacks pointwise chunks whose ends nobody knows.
  std::vector<LostPoints> read_in_sequence();

 private:
  using Problem = std::optional<CorruptChunk>;

  void read_batch(std::span<const LazChunk> chunks, std::uint64_t point_count);
  void read_batch_and_sort_out(std::span<const LazChunk> chunks);
  void read_large(std::span<const std::byte> bytes, std::uint64_t point_count, bool ends_there,
                  std::size_t& used);
  std::span<const std::byte> bytes_of(std::span<const LazChunk> batch, std::size_t i) const;
  void meet(const CorruptChunk& problem, std::size_t chunk, std::uint64_t first_point, std::uint64_t lost);

  InputFile& file_;
  const LasHeader& header_;
  const LazLayout& layout_;
  Damage damage_;
  LazSink& sink_;
  JoinedProgress progress_;
  tbb::enumerable_thread_specific<ChunkDecoder> decoders_;
  std::vector<std::byte> bytes_;  ///< of the chunks of a batch
  std::size_t chunks_done_ = 0;
  std::uint64_t points_done_ = 0;  ///< of the file, lost ones too
  std::uint64_t rows_ = 0;
  std::vector<LostPoints> lost_;
};

}  // namespace alidade
