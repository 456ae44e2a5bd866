// SPDX-License-Identifier: MIT
#include "cloud/laz/laz_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "base/error.h"
#include "cloud/laz/unpack_chunks.h"

namespace alidade {

LazPoints::LazPoints(InputFile& file, const LasHeader& header, const LazLayout& layout, Damage damage)
    : file_(file), header_(header), layout_(layout), damage_(damage) {
  if (layout_.compressor == LazCompressor::pointwise) {
    in_sequence_ = true;
    return;
  }
  std::string missing;
  try {
    if (std::optional<std::vector<LazChunk>> chunks = read_chunk_table(file_, header_, layout_, missing)) {
      chunks_ = std::move(*chunks);
      return;
    }
  } catch (const Error& error) {
    if (damage == Damage::refuse) throw DamagedFile(error.parts());
    missing = error.parts().problem;
  }
  warnings_.push_back(fmt::format("{}: {}; the chunks are read one after another", file_.name(), missing));
  if (layout_.compressor == LazCompressor::layered) {
    walk(damage);
  } else if (layout_.chunk_size != 0) {
    in_sequence_ = true;
  } else {
    // Nothing in the file says where a chunk of points ends.
    const std::string place = fmt::format("byte {}", header_.points_place);
    if (damage == Damage::refuse) {
      throw DamagedFile({.file = file_.name(),
                         .place = place,
                         .problem = missing,
                         .expected = "a chunk table, because the chunks have different sizes"});
    }
    lost_.push_back({header_.point_count, place, missing});
  }
}

void LazPoints::walk(Damage damage) {
  WalkedChunks walked = walk_layered_chunks(file_, header_, layout_);
  chunks_ = std::move(walked.chunks);
  if (!walked.problem) return;
  if (damage == Damage::refuse) throw DamagedFile(walked.problem->parts());
  std::uint64_t left = header_.point_count;
  for (const LazChunk& chunk : chunks_) left -= chunk.point_count;
  lost_.push_back({left, walked.problem->parts().place, walked.problem->parts().problem});
}

std::vector<LostPoints> LazPoints::read(const LazLayers& wanted, LazSink& sink, const Progress& progress) {
  ChunkUnpacker unpacker(file_, header_, layout_, wanted, damage_, sink, progress);
  std::vector<LostPoints> lost;
  if (in_sequence_) {
    lost = unpacker.read_in_sequence();
  } else {
    lost = unpacker.read_chunks(chunks_);
  }
  lost.insert(lost.end(), lost_.begin(), lost_.end());
  return lost;
}

}  // namespace alidade
