// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "database/point_block.h"
#include "database/scratch_file.h"
#include "octree/morton.h"

namespace alidade {

/// Brings points along a Morton curve that come in pieces, of which memory holds one: pieces are sorted, put
/// into a file without a name, and merged. Points of one place come by id. The order depends on the points
/// alone, neither on the pieces nor on the number of threads.
class PointStream {
 public:
  /// What a point of a piece takes of memory beside its columns.
  static constexpr std::uint64_t k_bytes_beside = 36;

  /// `folder`: for the file.
  explicit PointStream(std::filesystem::path folder) : file_(std::move(folder)) {}

  /// Takes the points of a piece (CloudPieces), fewer than 2^32, whose ids follow those of the pieces before.
  /// Errors: ScratchFile's.
  void add(PointCloud& piece);

  /// Takes the last piece. If it is the only one, it stays where it is and must outlive the object.
  void finish(const PointCloud& last);

  std::uint64_t size() const { return size_; }

  /// The blobs that some piece has: their sizes and numbers, in the order of the numbers.
  const std::vector<ValueBlob>& blobs() const { return blobs_; }

  /// The next points, up to `count`; none at the end. After finish(). Blobs of their blocks are those of
  /// blobs(). Memory: of each piece two blocks of 1024 points.
  PickedPoints next(std::size_t count);

 private:
  /// A sorted piece in the file: blocks of k_block_points, the last one maybe shorter; of each the positions,
  /// the rows, then the blobs.
  struct Run {
    std::uint64_t first_id = 0, count = 0, place = 0;
    std::vector<ValueBlob> blobs;
    // Where merging is.
    std::uint64_t next_block = 0;
    std::shared_ptr<const PointBlock> block{};
    std::vector<WideMortonKey> keys{};  ///< of the block's points
    std::uint32_t at = 0;
    bool is_noted = false;  ///< its block, among those of the points picked now
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

}  // namespace alidade
