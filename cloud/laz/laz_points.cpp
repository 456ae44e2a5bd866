// SPDX-License-Identifier: MIT
#include "cloud/laz/laz_points.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "cloud/laz/chunk_codec.h"

namespace alidade {

namespace {

// Enough chunks that threads rarely wait for the last one, few enough that their memory does not matter.
constexpr std::uint64_t k_batch_bytes = 8 << 20;
constexpr std::uint64_t k_batch_points = 4 << 20;
constexpr std::uint64_t k_batch_points_sorted_out = 1 << 20;  // these are held unpacked
constexpr std::uint64_t k_batch_record_bytes = 64 << 20;      // unpacked, as the sink may hold them
constexpr const char* k_other_end = "extra bytes after the last point of the chunk";

/// Most bytes that a pointwise chunk can take: even the least likely values take less than four times the
/// size of their field.
std::uint64_t longest_chunk(const LazLayout& layout, std::uint64_t point_count) {
  const std::uint64_t record = 4 * layout.record_size() + 16;
  return point_count > UINT64_MAX / record ? UINT64_MAX : point_count * record;
}

}  // namespace

/// One pass over a LAZ file: see LazPoints::read(). The arguments must outlive it.
class LazPoints::Unpacker {
 public:
  Unpacker(const LazPoints& of, const LazLayers& wanted, LazSink& sink, const Progress& progress)
      : of_(of),
        sink_(sink),
        progress_(progress, of.file_.size()),
        decoders_([&of, wanted] { return ChunkDecoder(of.layout_, wanted); }) {
    progress_.add(of.header_.points_offset);
  }

  /// Unpacks chunks that are contiguous in the file.
  std::vector<LostPoints> read_chunks(std::span<const LazChunk> chunks) {
    const std::uint64_t most_points =
        std::min(of_.damage_ == Damage::reject ? k_batch_points : k_batch_points_sorted_out,
                 k_batch_record_bytes / of_.layout_.record_size());
    for (std::size_t begin = 0; begin < chunks.size();) {
      std::size_t end = begin;
      std::uint64_t byte_count = 0, point_count = 0;
      for (; end < chunks.size(); ++end) {
        const bool fits = byte_count + chunks[end].byte_count <= k_batch_bytes &&
                          point_count + chunks[end].point_count <= most_points;
        if (!fits && end > begin) break;
        byte_count += chunks[end].byte_count;
        point_count += chunks[end].point_count;
      }
      const std::span<const LazChunk> batch = chunks.subspan(begin, end - begin);
      const auto fetch = [&] {
        bytes_.resize(static_cast<std::size_t>(byte_count));
        of_.file_.read_at(batch[0].offset, bytes_);
      };
      if (point_count > most_points) {
        fetch();
        std::size_t used = 0;
        read_large(bytes_, point_count, true, used);
      } else if (of_.damage_ == Damage::reject) {
        sink_.make_room(point_count);
        if (sink_.has_values(point_count)) {
          rows_ += point_count;
          progress_.add(byte_count);
        } else {
          fetch();
          read_batch(batch, point_count);
        }
      } else {
        fetch();
        read_batch_and_sort_out(batch);
      }
      chunks_done_ += batch.size();
      points_done_ += point_count;
      begin = end;
    }
    return std::move(lost_);
  }

  /// Unpacks pointwise chunks whose ends are unknown.
  std::vector<LostPoints> read_in_sequence() {
    const bool one_stream = of_.layout_.compressor == LazCompressor::pointwise;
    std::uint64_t offset = of_.header_.points_offset + (one_stream ? 0 : k_laz_table_offset_bytes);
    while (points_done_ < of_.header_.point_count) {
      const std::uint64_t left = of_.header_.point_count - points_done_;
      const std::uint64_t point_count =
          one_stream ? left : std::min<std::uint64_t>(of_.layout_.chunk_size, left);
      const std::uint64_t room = of_.file_.size() - std::min(offset, of_.file_.size());
      bytes_.resize(static_cast<std::size_t>(std::min(room, longest_chunk(of_.layout_, point_count))));
      if (!bytes_.empty()) of_.file_.read_at(offset, bytes_);
      std::size_t used = 0;
      read_large(bytes_, point_count, false, used);
      ++chunks_done_;
      points_done_ += point_count;
      offset += used;
      if (lost_.empty()) continue;
      // Where the next chunk begins is known only when this one is unpacked.
      lost_.back().count += of_.header_.point_count - points_done_;
      break;
    }
    return std::move(lost_);
  }

 private:
  using Problem = std::optional<CorruptChunk>;

  /// Unpacks the chunks of a batch, each by take(chunk, records, count, first point). Returns their problems.
  template <class Take>
  std::vector<Problem> decode_at_once(std::span<const LazChunk> chunks, const Take& take) {
    std::vector<Problem> problems(chunks.size());
    in_parallel(chunks.size(), 1, [&](std::size_t i) {
      const auto bytes =
          std::span(bytes_).subspan(static_cast<std::size_t>(chunks[i].offset - chunks[0].offset),
                                    static_cast<std::size_t>(chunks[i].byte_count));
      try {
        const std::size_t used =
            decoders_.local().decode(bytes, chunks[i].point_count,
                                     [&](const std::byte* records, std::size_t count, std::uint64_t first) {
                                       take(i, records, count, first);
                                     });
        if (used != chunks[i].byte_count) throw CorruptChunk(k_other_end);
      } catch (const CorruptChunk& problem) {
        // Which one is reported must not depend on threads.
        problems[i] = problem;
      }
      progress_.add(chunks[i].byte_count);
    });
    return problems;
  }

  /// Unpacks directly into the rows, for which there is room: all of them are needed.
  void read_batch(std::span<const LazChunk> chunks, std::uint64_t point_count) {
    std::vector<std::uint64_t> first_rows(chunks.size(), rows_);
    for (std::size_t i = 1; i < chunks.size(); ++i)
      first_rows[i] = first_rows[i - 1] + chunks[i - 1].point_count;
    const std::vector<Problem> problems = decode_at_once(
        chunks, [&](std::size_t i, const std::byte* records, std::size_t count, std::uint64_t first) {
          sink_.take(records, count, first_rows[i] + first);
        });
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      if (problems[i]) meet(*problems[i], chunks_done_ + i, first_rows[i], chunks[i].point_count);
    }
    rows_ += point_count;
  }

  /// Unpacks chunks that may be damaged: rows are made for the intact ones.
  void read_batch_and_sort_out(std::span<const LazChunk> chunks) {
    std::vector<std::vector<std::byte>> unpacked(chunks.size());
    const std::vector<Problem> problems = decode_at_once(
        chunks, [&](std::size_t i, const std::byte* records, std::size_t count, std::uint64_t) {
          unpacked[i].insert(unpacked[i].end(), records, records + count * of_.layout_.record_size());
        });
    std::uint64_t first_point = points_done_;
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      const std::uint64_t count = chunks[i].point_count;
      if (problems[i]) {
        meet(*problems[i], chunks_done_ + i, first_point, count);
      } else {
        sink_.make_room(count);
        sink_.take(unpacked[i].data(), static_cast<std::size_t>(count), rows_);
        rows_ += count;
      }
      first_point += count;
    }
  }

  /// Unpacks a chunk whose points are too many to make room for before they are unpacked.
  void read_large(std::span<const std::byte> bytes, std::uint64_t point_count, bool ends_there,
                  std::size_t& used) {
    const std::uint64_t rows_before = rows_;
    try {
      used = decoders_.local().decode(bytes, point_count,
                                      [&](const std::byte* records, std::size_t count, std::uint64_t) {
                                        sink_.make_room(count);
                                        sink_.take(records, count, rows_);
                                        rows_ += count;
                                        progress_.add(0);
                                      });
      if (ends_there && used != bytes.size()) throw CorruptChunk(k_other_end);
    } catch (const CorruptChunk& problem) {
      const std::uint64_t lost = point_count - (rows_ - rows_before);
      if (lost > 0 || of_.damage_ == Damage::reject) meet(problem, chunks_done_, points_done_, lost);
    }
    progress_.add(ends_there ? bytes.size() : used);
  }

  /// Throws for a chunk with `lost` unreadable points, or adds them to `lost_`.
  void meet(const CorruptChunk& problem, std::size_t chunk, std::uint64_t first_point, std::uint64_t lost) {
    std::string location = fmt::format("chunk {}", chunk);
    if (problem.point) location += fmt::format(", point {}", first_point + *problem.point);
    std::string text = fmt::format("corrupt compressed points: {}", problem.what());
    if (of_.damage_ == Damage::reject) {
      throw DamagedFile(
          {.file = of_.file_.name(), .location = std::move(location), .problem = std::move(text)});
    }
    lost_.push_back({lost, std::move(location), std::move(text)});
  }

  const LazPoints& of_;
  LazSink& sink_;
  JoinedProgress progress_;
  tbb::enumerable_thread_specific<ChunkDecoder> decoders_;
  std::vector<std::byte> bytes_;  ///< of the chunks of a batch
  std::size_t chunks_done_ = 0;
  std::uint64_t points_done_ = 0;  ///< of the file, lost ones too
  std::uint64_t rows_ = 0;
  std::vector<LostPoints> lost_;
};

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
    if (damage == Damage::reject) throw DamagedFile(error.parts());
    missing = error.parts().problem;
  }
  warnings_.push_back(fmt::format("{}: {}; reading the chunks one by one", file_.name(), missing));
  if (layout_.compressor == LazCompressor::layered) {
    walk(damage);
  } else if (layout_.chunk_size != 0) {
    in_sequence_ = true;
  } else {
    // Without the table, the file does not state where a chunk ends.
    const std::string location = fmt::format("byte {}", header_.points_offset);
    if (damage == Damage::reject) {
      throw DamagedFile({.file = file_.name(),
                         .location = location,
                         .problem = missing,
                         .expected = "a chunk table, because the chunks have variable size"});
    }
    lost_.push_back({header_.point_count, location, missing});
  }
}

void LazPoints::walk(Damage damage) {
  WalkedChunks walked = walk_layered_chunks(file_, header_, layout_);
  chunks_ = std::move(walked.chunks);
  if (!walked.problem) return;
  if (damage == Damage::reject) throw DamagedFile(walked.problem->parts());
  std::uint64_t left = header_.point_count;
  for (const LazChunk& chunk : chunks_) left -= chunk.point_count;
  lost_.push_back({left, walked.problem->parts().location, walked.problem->parts().problem});
}

std::vector<LostPoints> LazPoints::read(const LazLayers& wanted, LazSink& sink, const Progress& progress) {
  Unpacker unpacker(*this, wanted, sink, progress);
  std::vector<LostPoints> lost = in_sequence_ ? unpacker.read_in_sequence() : unpacker.read_chunks(chunks_);
  lost.insert(lost.end(), lost_.begin(), lost_.end());
  return lost;
}

}  // namespace alidade
