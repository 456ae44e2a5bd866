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

/// What the first record of a COPC file says: the root of an octree of chunks. Source: COPC 1.0.
struct CopcInfo {
  glm::dvec3 centre{0.0};            ///< of the root, world coordinates
  double half_size = 0.0;            ///< from the centre to each face: the root is a cube
  double spacing = 0.0;              ///< distance of points aimed at in the root; halved by every level
  std::uint64_t root_page = 0;       ///< where the hierarchy begins
  std::uint64_t root_page_size = 0;  ///< bytes
};

/// Reads the record's data. Errors: another size, numbers that are not finite or not positive, a cube whose
/// corners are no finite numbers.
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
  /// Offsets in `nodes`: one node's children behind the other's. A node is the child of the smallest cube
  /// around it that is a node: of its parent, unless the file leaves that out.
  std::vector<std::uint32_t> children;

  std::span<const std::uint32_t> children_of(const CopcNode& node) const {
    return std::span(children).subspan(node.first_child, node.child_count);
  }

  int levels() const { return nodes.empty() ? 0 : nodes.back().key.level + 1; }
};

/// Reads all pages of the hierarchy. A root that the file leaves out is added as a node without points, so
/// that every node is reached from it. `chunks` are those of the file's chunk table: the nodes must have
/// exactly these, from which follow the rows of their points. Errors: pages or chunks outside the file, pages
/// that are met twice or take more bytes than the file has, keys that no octree has, two nodes of one key,
/// nodes that are not the chunks of the file. Memory: about seven times the pages.
CopcHierarchy read_copc_hierarchy(InputFile& file, const CopcInfo& info, std::span<const LazChunk> chunks);

/// Whether a file that starts so, 589 bytes at least, is COPC.
bool is_copc(std::span<const std::byte> start);

/// A COPC file, opened: everything but its points is read. Thread safe.
class CopcFile {
 public:
  /// Errors: the file is no COPC 1.0 (LAS 1.4 with points of format 6 to 8, compressed in chunks of different
  /// sizes, behind a record of COPC); what read_las_header(), parse_laszip_record(), read_chunk_table(),
  /// parse_copc_info() and read_copc_hierarchy() reject. `rests`: whether the file is closed between reads, so that
  /// thousands can be in use. `input`, if given, says in which unit heights are wanted (InputView::has_one_unit):
  /// header, reference system, boxes and points are then those of the stretched cloud. Errors: those of
  /// InputView::change_of().
  explicit CopcFile(InputFile file, bool rests = false, const CloudInput* input = nullptr);

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
  std::vector<std::uint32_t> nodes;  ///< offsets in its hierarchy, none twice
};

/// Reads the points of these nodes, file by file in the order given, node by node: a part of what
/// read_cloud() gives. Of the options, region and partial have no meaning; progress is in points. Chunks are
/// unpacked in parallel (oneTBB); the result does not depend on the number of threads. The lattice is that of all files
/// (joined_lattice()). Errors: a damaged chunk.
PointCloud read_copc_nodes(std::span<const ChosenNodes> parts, const ReadOptions& options = {});

/// How many points read_copc_nodes() would read.
std::uint64_t point_count(std::span<const ChosenNodes> parts);

}  // namespace alidade
