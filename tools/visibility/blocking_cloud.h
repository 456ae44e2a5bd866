// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mesh/triangle_tree.h"
#include "octree/index_file/index_file.h"
#include "tools/command.h"
#include "visibility/raster/ground.h"
#include "visibility/sight_line.h"

namespace alidade::tools {

/// What may block sight, as it was asked for on the command line.
struct OccluderRequest {
  visibility::OccluderOptions options;        ///< without the mesh, which is still to be read
  std::vector<std::filesystem::path> meshes;  ///< --mesh
  /// Classes whose points block nothing, if the cloud has classes. At first the noise of ASPRS.
  std::bitset<256> ignored_classes = std::bitset<256>{}.set(7).set(18);
};

/// Declares the options in a group of their own; they fill `request`.
void add_occluder_options(const Options& command, OccluderRequest& request);

/// Options of all commands of `alidade visibility`.
struct VisibilityRequest : CloudRequest {
  OccluderRequest occluders;
  std::filesystem::path output;
  bool overwrite = false;

  /// The files of cloud and meshes, and what else is read.
  std::vector<std::filesystem::path> inputs(std::initializer_list<std::filesystem::path> more = {}) const;
};

/// All meshes as one.
struct BlockingMesh {
  std::shared_ptr<const TriangleTree> tree;  ///< null: no mesh
  std::uint64_t checksum = 0;                ///< of vertices and triangles
};

/// A cloud with meshes beside it, and what of them blocks sight.
struct VisibilityCloud {
  BlockingMesh mesh;
  IndexedCloud cloud;
  AttributeColumns columns;                        ///< of `cloud`, which therefore must not move
  std::optional<visibility::Occluders> occluders;  ///< empty until they are measured
  std::string what_blocks;                         ///< the same in words

  const Octree& octree() const { return occluders ? occluders->octree() : cloud.octree; }
};

/// Loads the meshes, then cloud files or an index file, and shows progress; occluders are still to be measured.
/// What classes and `attributes` say is in memory then. Errors: as read_mesh(); too many triangles in all
/// meshes; as load_indexed_cloud(); no points; coordinates in degrees (check_map_unit.h).
std::unique_ptr<VisibilityCloud> load_cloud_alone(const VisibilityRequest& request, AttributeSet attributes);

/// Measures what the cloud lacks, shows progress, and says what blocks. May take long, so what else can be
/// wrong is better found before. Errors: as Occluders.
void measure_occluders(VisibilityCloud& cloud, const OccluderRequest& request, Verbosity verbosity);

/// make_ground() below a cloud, with its progress shown. Occluders need not be measured.
visibility::Ground find_ground(const VisibilityCloud& cloud, visibility::GroundOptions options,
                               Verbosity verbosity);

}  // namespace alidade::tools
