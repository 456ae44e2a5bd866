// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "image/color_key.h"
#include "image/point_values.h"
#include "octree/octree.h"
#include "renderer/scene.h"
#include "surface/surface_cloud.h"

namespace alidade::renderer {

/// The cloud of a scene, ready to be traced.
struct LoadedCloud {
  Octree octree;
  std::vector<Color16> colors;  ///< display-referred, one per point id; none for normals
  ColorColumn mapped_colors{};  ///< the colours instead, in an index file's map that octree keeps
  double radius = 0.0;          ///< metres, the one used; the greatest one where each point has its own
  double spacing_factor = 0.0;  ///< above 0: each point has its own, see SurfaceQuery
  double lone_radius = 0.0;     ///< of discs: spheres of points without a sheet are no wider, metres
  SurfaceCloud surfaces;        ///< of points with radii of their own, otherwise empty
  image::ColorKey color;        ///< what the colours show
  Crs crs;
  std::vector<ScannerPosition> scanner_positions;
  std::vector<CloudFile> files;
  std::vector<std::string> warnings;
  /// Of all in the index file that octree and mapped colours lie in; empty for a cloud that was built.
  std::optional<std::uint64_t> index_checksum;

  /// The colours by point id, wherever they lie.
  ColorColumn point_colors() const { return colors.empty() ? mapped_colors : ColorColumn(colors); }
};

/// Reads the clouds, whatever files the settings name, keeps only what the image needs, builds the octree,
/// measures the radius if it is "auto". `progress` is in bytes read, as read_cloud's; while the octree is
/// built it repeats the last numbers. Errors: as read_cloud. Peak memory: about 20 bytes per point, or 46 for
/// clouds that span more than 2^21 lattice steps on an axis. A single index file is used where it lies:
/// octree and rgb colours in its map, nothing is built, and the image has the same bytes. It keeps the
/// colour depth it was made with. Other colours take 6 bytes per point (image/color_points.h). `measuring` is
/// in points whose spacing was measured, if radii adapt to it and no index file has them.
LoadedCloud load_cloud(const CloudSettings& settings, const CloudInputs& inputs,
                       const Progress& progress = {}, const Progress& measuring = {});

/// load_cloud() of the files of the settings: clouds of index_and_file_formats().
LoadedCloud load_cloud(const CloudSettings& settings, const Progress& progress = {},
                       const Progress& measuring = {});

/// Box around the spheres of the cloud's points but for strays: what overview_camera should show. A stray is
/// farther from the box of all but the outermost half percent, on either side of each axis, than a quarter of
/// its diagonal. Empty for a cloud without points.
Bounds visible_bounds(const LoadedCloud& cloud);

/// Points that are no strays, some and the outermost in all directions: a view that shows them shows all.
/// Empty for a cloud without points.
std::vector<glm::dvec3> visible_positions(const LoadedCloud& cloud);

std::uint64_t stray_count(const LoadedCloud& cloud);

/// Makes points that have been read ready to be traced, but for their radii: chooses their colours, frees the
/// columns that these do not need, builds the octree. `cloud` holds attributes_for(settings.color);
/// `attributes` are all that its files have, and `name` is what it is called, for messages. Errors: as
/// choose_color().
LoadedCloud index_cloud(PointCloud&& cloud, AttributeSet attributes, const CloudSettings& settings,
                        const std::string& name, const Progress& progress = {});

/// Colours the points of loaded.octree, and takes over the description of their cloud; rgb stays in the
/// columns. `coloring` comes from choose_color(), whose warnings `loaded` has; `name` is the cloud's, for
/// messages.
void color_cloud(LoadedCloud& loaded, const image::PointColoring& coloring, const AttributeColumns& columns,
                 const PointCloud& description, const std::string& name);

/// Errors: discs with one radius for all points, of glass, of some levels, or by other neighbours than the
/// 8th.
void check_shape(const CloudSettings& settings);

/// Chooses the radii of a cloud's points by its settings: fills radius, spacing_factor, lone_radius and
/// surfaces, and measures the spacings if radii adapt to the density and the octree has none for so many
/// neighbours; surfaces of discs are fitted where rays meet them. `progress` is in points measured. Errors:
/// as check_shape(); a radius, factor or number of neighbours out of range; adapted radii of only some
/// levels.
void choose_radius(const CloudSettings& settings, LoadedCloud& cloud, const Progress& progress = {});

/// A point in whose sphere a position lies.
struct SphereAround {
  std::uint64_t point_id = 0;
  double radius = 0.0;    ///< of its sphere, metres
  double distance = 0.0;  ///< of the position from its centre
};

/// The nearest such point; max_level as in RayQuery.
std::optional<SphereAround> sphere_around(const LoadedCloud& cloud, const glm::dvec3& position,
                                          int max_level);

/// World z of every point, to be coloured by. The tree must outlive it.
image::PointValues heights(const TreeView& tree);

}  // namespace alidade::renderer
