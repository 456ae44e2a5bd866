// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/morton.h"
#include "base/scratch_file.h"
#include "cloud/point_cloud.h"
#include "cloud/read_in_pieces.h"
#include "cloud/written_column.h"
#include "database/stored_column.h"

namespace alidade::database {

/// Some points of a cloud, by columns.
struct PointBlock {
  const LatticePosition* positions = nullptr;
  std::uint64_t first_id = 0;
  const std::uint32_t* rows = nullptr;  ///< the id of a point is first_id + its row; null: + its index
  std::vector<ValueBlob> blobs{};       ///< those without values represent zeros
  std::vector<std::byte> memory{};      ///< of the columns, if the block owns them

  std::uint64_t id(std::uint32_t index) const { return first_id + (rows == nullptr ? index : rows[index]); }
};

/// Points of several blocks, in some order.
struct PickedPoints {
  struct Pick {
    const PointBlock* block;
    std::uint32_t index;  ///< in the block
  };
  std::vector<Pick> picks;
  std::vector<std::shared_ptr<const PointBlock>> blocks;  ///< that the picks point to
};

/// Sorts points that come in pieces along a Morton curve, with one piece in memory: pieces are sorted,
/// written to a file without a name, and merged. Points of one position are in the order of their ids. The
/// order does not depend on the pieces or the number of threads.
class PointStream {
 public:
  /// Memory per point of a piece, beside its columns.
  static constexpr std::uint64_t k_bytes_beside = 36;

  /// `folder`: where the file is made, unless there is a single piece.
  explicit PointStream(std::filesystem::path folder = {}) : file_(std::move(folder)) {}

  /// Adds the points of a piece (CloudPieces), fewer than 2^32, whose ids follow those of the pieces before.
  /// Errors: ScratchFile's.
  void add(PointCloud& piece);

  /// Adds the last piece. If it is the only one, it is not copied and must outlive the object.
  void finish(const PointCloud& last);

  std::uint64_t size() const { return size_; }

  /// The sizes and numbers of all blobs that any piece has, in the order of the numbers.
  const std::vector<ValueBlob>& blobs() const { return blobs_; }

  /// The next points, up to `count`; none at the end. Requires finish(). The blobs of their blocks are those
  /// of blobs(). Memory: two blocks of 1024 points per piece.
  PickedPoints next(std::size_t count);

  /// Takes all points in groups of up to `size`: encode(slot, points) in parallel, then finish(slot) for one
  /// group after the other, in their order. Slots are numbers below `most`, the number of groups at once; one
  /// that is used again has been finished.
  void for_each_group(std::size_t size, std::size_t most,
                      const std::function<void(std::size_t slot, PickedPoints points)>& encode,
                      const std::function<void(std::size_t slot)>& finish);

 private:
  /// A sorted piece in the file: blocks of k_block_points, except for the last one, which may be shorter. A
  /// block has the positions, the rows, then the blobs.
  struct Run {
    std::uint64_t first_id = 0, count = 0;
    std::uint64_t offset = 0;  ///< of the first block in the file
    std::vector<ValueBlob> blobs;
    // The state of merging.
    std::uint64_t next_block = 0;
    std::shared_ptr<const PointBlock> block{};
    std::vector<WideMortonKey> keys{};  ///< of the block's points
    std::uint32_t at = 0;
    bool is_noted = false;  ///< whether its block is among those of the current picks
  };
  struct Head {
    WideMortonKey key;
    std::size_t run;
    bool operator>(const Head& other) const { return key != other.key ? key > other.key : run > other.run; }
  };

  void take(const PointCloud& piece);
  void note_blobs(const PointCloud& piece);
  void write_run(const PointCloud& piece);
  void load_block(Run& run);
  void pick_from(Run& run, const std::optional<Head>& limit, std::size_t number, std::size_t count,
                 PickedPoints& picked);

  ScratchFile file_;
  std::uint64_t size_ = 0;
  std::vector<ValueBlob> blobs_;
  std::vector<Run> runs_;
  std::vector<Head> heads_;  ///< a heap with the least on top
  // If there is only one piece:
  std::shared_ptr<const PointBlock> whole_;
  std::vector<std::uint32_t> order_;
  std::size_t next_ = 0;
};

/// Points of consecutive chunks in their stored form.
struct EncodedChunks {
  std::vector<LatticePosition> positions;
  std::vector<std::vector<std::byte>> blobs;  ///< the ids, then those of PointStream::blobs()
  std::vector<Bounds> boxes;                  ///< of each chunk
};

/// The encoding of points as chunks.
struct ChunkEncoding {
  std::uint32_t chunk_points = 1024;
  Lattice lattice{};
  std::vector<ValueBlob> blobs{};  ///< their sizes
  ColorSpread spread{};
};

/// Cost: linear.
EncodedChunks encode(const ChunkEncoding& encoding, const PickedPoints& points);

/// Facts about cloud files that were stored.
struct StoredFiles {
  std::uint64_t point_count = 0;
  std::vector<std::string> warnings;  ///< PointCloud::warnings
  std::vector<CloudFile> files;       ///< likewise
};

/// A cloud along the Morton curve, to be written to a database.
struct OrderedCloud {
  /// Reads cloud files; `memory`: bytes for points. Those of a larger cloud are kept in a file without a name
  /// in `folder`, which takes the size of their columns and 4 bytes per point. Errors: those of
  /// read_in_pieces(); no space left. Cancelled. Memory: `memory`, two blocks of 1024 points for each time
  /// that it was full, and that of CloudReader::read().
  OrderedCloud(const std::filesystem::path& folder, const CloudInputs& inputs, const ReadOptions& reading,
               std::uint64_t memory);
  /// The cloud must outlive it. Errors: more than 2^32 - 1 points. Memory: 36 bytes per point at the peak.
  explicit OrderedCloud(const PointCloud& cloud);
  /// A cloud of so many points that comes in pieces. `facts`: its lattice, reference system and extra
  /// dimensions. Memory: two pieces, 36 bytes per point of one, and two blocks of 1024 points for each.
  OrderedCloud(const std::filesystem::path& folder, const PointCloud& facts, std::uint64_t point_count,
               const PointPieces& pieces);

  /// stored_columns() of all attributes that any piece has.
  std::vector<StoredColumn> columns() const;
  ChunkEncoding encoding(std::uint32_t chunk_points) const;
  StoredFiles stored() && {
    return {points.size(), std::move(whole.rest.warnings), std::move(whole.rest.files)};
  }

  PointStream points;
  PiecewiseCloud whole;

 private:
  void describe(const PointCloud& cloud);
};

}  // namespace alidade::database
