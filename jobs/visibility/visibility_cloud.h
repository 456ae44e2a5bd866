// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "mesh/triangle_tree.h"
#include "octree/index_file/index_file.h"
#include "visibility/raster/ground.h"
#include "visibility/sight_line.h"

namespace alidade::jobs {

/// What blocks sight.
struct OccluderRequest {
  visibility::OccluderOptions options;        ///< without mesh and terrain, which are still to be read
  std::vector<std::filesystem::path> meshes;  ///< --mesh
  std::filesystem::path terrain;              ///< --terrain; empty: none
  /// Classes whose points block nothing, if the cloud has classes. By default the noise of ASPRS.
  std::bitset<256> ignored_classes = std::bitset<256>{}.set(7).set(18);
};

/// Declares the fields in a group of their own; they fill `request`.
void add_occluder_fields(const Fields& fields, OccluderRequest& request);

/// Declares --ignore-classes, by default noise. `effect`: what points of these classes do, as help.
void add_ignored_classes(const Fields& fields, const std::string& effect, std::bitset<256>& classes);

/// What all jobs on visibility are requested with; their add_X_fields() declare all of it.
struct VisibilityRequest : CloudRequest {
  OccluderRequest occluders;

  /// What is read and written: cloud, meshes, terrain, output, and these.
  PlannedWork work(std::initializer_list<std::filesystem::path> reads = {},
                   std::initializer_list<std::filesystem::path> writes = {}) const;
};

/// All meshes as one.
struct BlockingMesh {
  std::shared_ptr<const TriangleTree> tree;  ///< null: no mesh
  std::uint64_t checksum = 0;                ///< of vertices and triangles
};

/// An elevation raster.
struct BlockingTerrain {
  std::shared_ptr<const geo::TerrainSurface> surface;  ///< null: none
  std::uint64_t checksum = 0;                          ///< of its heights and their grid
};

/// A cloud, with meshes and a terrain beside it, or a terrain instead of points, and the occluders among
/// them.
struct VisibilityCloud {
  BlockingMesh mesh;
  BlockingTerrain terrain;
  IndexedCloud cloud;
  AttributeColumns columns;                        ///< of `cloud`, which therefore must not move
  std::optional<visibility::Occluders> occluders;  ///< empty until they are measured
  std::string what_blocks;                         ///< the occluders in words

  const Octree& octree() const { return occluders ? occluders->octree() : cloud.octree; }
  bool has_points() const { return cloud.octree.size() > 0; }
  /// Bounds of the points; without points the area of the terrain.
  Bounds area() const {
    return has_points() ? cloud.octree.bounds() : geo::area_of(terrain.surface->heights().grid);
  }
};

/// What a job accepts as its cloud.
enum class AcceptedInput {
  points,
  points_or_raster,  ///< an elevation raster instead of points, too: the cloud is empty then
};

/// Loads the meshes, the terrain, then cloud files with their classes and `attributes`, or an index file.
/// Does not measure occluders. Errors: as read_mesh(); too many triangles in all meshes; as
/// geo::read_heights(); a raster without a patch of surface, in another reference system than the cloud,
/// instead of points that are required, or beside another one; as load_indexed_cloud(); no points;
/// coordinates in degrees.
std::unique_ptr<VisibilityCloud> load_cloud_alone(const VisibilityRequest& request, AttributeSet attributes,
                                                  AcceptedInput accepted, Listener& listener);

/// A known reference system, and what has it, in messages.
struct NamedSystem {
  const Crs& crs;
  std::string name;
};

/// Errors: `different`, if the systems differ. Warns that they are assumed to be the same if that cannot be
/// decided.
void check_same_system(const NamedSystem& one, const NamedSystem& other, const Error& different,
                       Listener& listener);

/// The occluders among points; points of ignored classes, `classes` being those of all points, block nothing.
/// Measures the spacings and surfaces that the octree lacks. The listener must live as long as the result.
/// Errors: as Occluders.
visibility::Occluders measured_occluders(const Octree& octree, std::span<const std::uint8_t> classes,
                                         const std::bitset<256>& ignored, visibility::OccluderOptions options,
                                         Listener& listener);

/// measured_occluders() of a cloud; notes what blocks sight. The listener must live as long as the cloud. May
/// take long: check all else before. Errors: as Occluders.
void measure_occluders(VisibilityCloud& cloud, const OccluderRequest& request, Listener& listener);

/// make_ground() below a cloud, as one stage, raised to the terrain; the terrain's without points.
/// Occluders need not be measured.
visibility::Ground find_ground(const VisibilityCloud& cloud, visibility::GroundOptions options,
                               Listener& listener);

}  // namespace alidade::jobs
