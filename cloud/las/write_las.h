// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cloud/point_cloud.h"

namespace alidade {

struct LasWriteOptions {
  bool overwrite = false;  ///< otherwise an existing file is an Error
  Progress progress{};     ///< in points
  /// Creation date for the header, given by the caller so that equal input makes equal files: day of the year
  /// (1 = 1 January) and year; 0 = unknown.
  std::uint16_t creation_day = 0, creation_year = 0;
  std::uint64_t expected_points = 0;  ///< of all pieces, for `progress`; 0: no piece follows the current one
  std::uint64_t memory = std::uint64_t{1} << 30;  ///< bytes to sort in, for COPC
  /// Receives a sentence, which names the file, if names of extra dimensions are longer than the 32 bytes
  /// that LAS keeps; those that would become equal get a number.
  std::function<void(const std::string& warning)> warn{};
};

/// Writes LAS 1.4 piece by piece in bounded memory, or LAZ by its name: is_laz_name(). LAZ is packed in
/// chunks of 50000 points, in parallel; its bytes do not depend on the number of threads. The file appears
/// under its name only in finish(): until then it has another one beside it, and is removed if the writer is
/// destroyed.
///
/// Writes COPC 1.0 by its name: is_copc_name(). Its points have an order of their own
/// (cloud/copc/plan_copc.h), so all of them lie in scratch files beside the output until finish(): their
/// records, which are written twice if LasWriteOptions::memory does not hold them, and 12 to 40 B per point.
class LasWriter {
 public:
  /// `like` has everything but the points: lattice, CRS, records, encoding and the columns to come, those of
  /// its attributes(), extra dimensions and `attributes` (for columns that are empty in `like`). The point
  /// format is the smallest of 6, 7, 8 that holds them; normals become extra bytes NormalX/Y/Z (float32).
  /// Errors: the file exists and may not be replaced; the folder cannot be written; extra dimensions that are
  /// too long for the format.
  LasWriter(const std::filesystem::path& path, const PointCloud& like, AttributeSet attributes,
            const LasWriteOptions& options = {});
  ~LasWriter();
  LasWriter(const LasWriter&) = delete;
  LasWriter& operator=(const LasWriter&) = delete;

  /// Appends all points of `batch`, which has the lattice of `like`. Missing columns are written as zeros;
  /// extra dimensions match if name, type, scale, offset and "no value" mark do.
  void write(const PointCloud& batch);

  /// Completes the header (counts, bounds, counts by return), writes EVLRs, moves the file to its name.
  /// Errors: no space, or any write that failed.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether a file of this name is written as LAZ: it ends in .laz, in upper or lower case.
bool is_laz_name(const std::filesystem::path& path);

/// Whether a file of this name is written as COPC: it ends in .copc.laz, in upper or lower case.
bool is_copc_name(const std::filesystem::path& path);

/// Writes a whole cloud: all its attributes, scale, offset, CRS, records, extra dimensions. Keeps the order
/// of the points.
void write_las(const std::filesystem::path& path, const PointCloud& cloud,
               const LasWriteOptions& options = {});

}  // namespace alidade
