// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "cloud/copc/copc_hierarchy.h"
#include "cloud/las/las_header.h"
#include "cloud/las/las_records.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/read_cloud.h"

namespace alidade {

/// Whether a file that starts so, 589 bytes at least, is COPC.
bool is_copc(std::span<const std::byte> start);

/// A COPC file, opened: everything but its points is read. Thread safe.
class CopcFile {
 public:
  /// Errors: the file is no COPC 1.0 (LAS 1.4 with points of format 6 to 8, compressed in chunks of different
  /// sizes, behind a record of COPC); what read_las_header(), parse_laszip_record(), read_chunk_table(),
  /// parse_copc_info() and read_copc_hierarchy() reject.
  explicit CopcFile(InputFile file);

  const std::string& name() const { return file_.name(); }
  const LasHeader& header() const { return header_; }
  const LasRecords& records() const { return records_; }
  const LazLayout& layout() const { return layout_; }
  const CopcInfo& info() const { return info_; }
  const CopcHierarchy& hierarchy() const { return hierarchy_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// The bytes of a node's chunk, as in the file.
  void read_chunk(const CopcNode& node, std::vector<std::byte>& bytes) const;

  /// No point of the node or of those below it lies outside: the node's cube, enlarged by a step of the
  /// lattice on every side, because coordinates are rounded after points are sorted into cubes, and by what
  /// sums of float64 cost, so that the box of a node lies in that of its parent. Points are held to it when
  /// they are read (octree/copc_tree.h).
  Bounds bounds(const CopcNode& node) const;

 private:
  mutable InputFile file_;
  mutable std::mutex mutex_;  ///< of file_
  std::vector<std::string> warnings_;
  LasHeader header_;
  LasRecords records_;
  LazLayout layout_;
  CopcInfo info_;
  CopcHierarchy hierarchy_;
};

/// Some nodes of a COPC file.
struct ChosenNodes {
  const CopcFile* file = nullptr;
  std::vector<std::uint32_t> nodes;  ///< offsets in its hierarchy, none twice
};

/// Reads the points of these nodes, file by file in the order given, node by node: a part of what
/// read_cloud() gives. Of the options, region and partial have no meaning; progress is in points. Chunks are
/// unpacked in parallel (oneTBB); the result does not depend on the number of threads. Errors: files of
/// different lattices; a damaged chunk.
PointCloud read_copc_nodes(std::span<const ChosenNodes> parts, const ReadOptions& options = {});

/// How many points read_copc_nodes() would read.
std::uint64_t point_count(std::span<const ChosenNodes> parts);

}  // namespace alidade
