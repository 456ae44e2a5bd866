// SPDX-License-Identifier: MIT
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "base/input_file.h"
#include "cloud/las/las_header.h"
#include "cloud/las/las_records.h"
#include "cloud/laz/chunk_table.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/read_cloud.h"

namespace alidade {

/// The first record of a COPC file: the root of an octree of chunks. Source: COPC 1.0.
struct CopcInfo {
  glm::dvec3 centre{0.0};            ///< of the root, world coordinates
  double half_size = 0.0;            ///< from the centre to each face: the root is a cube
  double spacing = 0.0;              ///< intended distance of points in the root; halved by every level
  std::uint64_t root_page = 0;       ///< byte where the hierarchy begins
  std::uint64_t root_page_size = 0;  ///< bytes
};

/// Parses the record's data. Errors: another size; sizes that are not positive finite numbers; a cube whose
/// corners are not finite.
CopcInfo parse_copc_info(std::span<const std::byte> data, const std::string& file_name, std::uint64_t offset);

inline constexpr int k_deepest_copc_level = 30;

/// A cube of the octree: level 0 is the root; on level L each axis has 2^L cubes.
struct CopcKey {
  int level = 0;
  std::int32_t x = 0, y = 0, z = 0;

  auto operator<=>(const CopcKey&) const = default;
  CopcKey parent() const { return {level - 1, x >> 1, y >> 1, z >> 1}; }
  /// "2-1-0-3".
  std::string name() const;
};

/// The cube of a key.
Bounds copc_cube(const CopcInfo& info, const CopcKey& key);

struct CopcNode {
  CopcKey key;
  LazChunk chunk;                 ///< point_count 0: the node has no points of its own
  std::uint64_t first_row = 0;    ///< of its points, in the order of the file
  std::uint32_t first_child = 0;  ///< of child_count, in CopcHierarchy::children
  std::uint32_t child_count = 0;
};

/// The octree of a COPC file. Every point of the file belongs to exactly one node.
struct CopcHierarchy {
  std::vector<CopcNode> nodes;  ///< level by level; the root is the first
  /// Indices of `nodes`, the children of each node contiguous. A node is the child of the smallest cube
  /// around it that is a node: of its parent, unless the file leaves that out.
  std::vector<std::uint32_t> children;

  std::span<const std::uint32_t> children_of(const CopcNode& node) const {
    return std::span(children).subspan(node.first_child, node.child_count);
  }

  int levels() const { return nodes.empty() ? 0 : nodes.back().key.level + 1; }
};

/// Reads all pages of the hierarchy. A root that the file leaves out is added as a node without points, so
/// that every node can be reached from it. `chunks` are those of the file's chunk table: the nodes must have
/// exactly these, which define the rows of their points. Errors: pages or chunks outside the file; pages that
/// are referenced twice or take more bytes than the file has; invalid keys; two nodes of one key; nodes that
/// do not match the chunks of the file. Memory: about seven times the pages.
CopcHierarchy read_copc_hierarchy(InputFile& file, const CopcInfo& info, std::span<const LazChunk> chunks);

/// Whether a file is COPC, by its first 589 bytes or more.
bool is_copc(std::span<const std::byte> start);

/// An opened COPC file: everything but the points is read. Thread safe.
class CopcFile {
 public:
  /// `rests`: whether the file is closed between reads, so that thousands can be in use. `input`, if given,
  /// has the wanted unit of heights (InputView::has_one_unit): header, reference system, boxes and points are
  /// then those of the scaled cloud. Errors: the file is not COPC 1.0 (LAS 1.4 with points of format 6 to 8,
  /// compressed in chunks of different sizes, behind a record of COPC); those of read_las_header(),
  /// parse_laszip_record(), read_chunk_table(), parse_copc_info(), read_copc_hierarchy() and
  /// InputView::change_of().
  explicit CopcFile(InputFile file, bool rests = false, const CloudInput* input = nullptr);

  const std::string& name() const { return file_.name(); }
  const LasHeader& header() const { return header_; }
  const LasRecords& records() const { return records_; }
  const LazLayout& layout() const { return layout_; }
  const CopcInfo& info() const { return info_; }
  const CopcHierarchy& hierarchy() const { return hierarchy_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Reads the bytes of a node's chunk, as in the file.
  void read_chunk(const CopcNode& node, std::vector<std::byte>& bytes) const;

  /// A box around all points of the node and of those below it: the node's cube, enlarged by a step of the
  /// lattice on every side, because coordinates are rounded after points are sorted into cubes, and by the
  /// rounding of float64 sums, so that the box of a node lies in that of its parent. Points outside of it are
  /// an error when they are read (octree/copc_tree.h).
  Bounds bounds(const CopcNode& node) const;

 private:
  mutable InputFile file_;
  mutable std::mutex mutex_;  ///< of file_
  bool rests_;
  double height_factor_ = 1.0;
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
  std::vector<std::uint32_t> nodes;  ///< indices of nodes of its hierarchy, without duplicates
};

/// Reads the points of these nodes, in the order of files and nodes: a part of the result of read_cloud().
/// Ignores the options region and partial; progress is in points. Chunks are unpacked in parallel (oneTBB);
/// the result does not depend on the number of threads. The lattice is that of all files (joined_lattice()).
/// Errors: a damaged chunk.
PointCloud read_copc_nodes(std::span<const ChosenNodes> parts, const ReadOptions& options = {});

/// The number of points that read_copc_nodes() would read.
std::uint64_t point_count(std::span<const ChosenNodes> parts);

}  // namespace alidade
