// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octree/cloud/point_cloud.h"
#include "octree/octree.h"
#include "octree/progress.h"
#include "renderer/color/color_key.h"
#include "renderer/film.h"
#include "renderer/scene.h"

namespace alidade {

/// The cloud of a scene, ready to be traced.
struct LoadedCloud {
  Octree octree;
  std::vector<Color16> colors;               ///< display-referred, one per point id; none for normals
  std::span<const Color16> mapped_colors{};  ///< the same instead, in an index file's map that octree keeps
  double radius = 0.0;          ///< metres, the one used; the greatest one where each point has its own
  double spacing_factor = 0.0;  ///< above 0: each point has its own, see RayQuery::spacing_factor
  ColorKey color;               ///< what the colours show
  Crs crs;
  std::vector<CloudFile> files;
  std::vector<std::string> warnings;

  /// The colours by point id, wherever they lie.
  std::span<const Color16> point_colors() const { return colors.empty() ? mapped_colors : colors; }
};

/// Reads the files, keeps only what the picture needs, builds the octree, measures the radius if it is
/// "auto". `progress` is in bytes read, as read_cloud's; while the octree is built it repeats the last
/// numbers. Errors: as read_cloud. Peak memory: about 20 bytes per point, or 46 for clouds that span more
/// than 2^21 lattice steps on an axis.
/// A single index file is used where it lies: octree and rgb colours in its map, nothing is built, and the
/// picture has the same bytes. It keeps the colour depth it was made with. Other colours take 6 bytes per
/// point (renderer/color/color_points.h).
/// `measuring` is in points whose spacing was measured, if radii adapt to it and no index file has them.
LoadedCloud load_cloud(const CloudSettings& settings, const Progress& progress = {},
                       const Progress& measuring = {});

/// Box around the spheres of the cloud's points but for strays (the outermost half percent on either side of
/// an axis, where they lie far out): what overview_camera should show. Empty for a cloud without points.
Bounds visible_bounds(const LoadedCloud& cloud);

struct RenderOptions {
  Progress progress;  ///< in camera samples (pixels * samples per pixel); called from one thread at a time
};

struct RenderStatistics {
  std::uint64_t ray_count = 0;  ///< rays traced, shadow rays included
  double seconds = 0.0;
};

/// Errors: the camera stands inside the sphere of a point (its number is told). Parallel rays have no such
/// place.
void check_camera_place(const Camera& camera, const Scene& scene, const LoadedCloud& cloud);

/// Path-traces the scene (its camera must be set, and pass check_camera() and check_camera_place()). `cloud`
/// may be null for scenes of objects alone. Runs on as many threads as the caller's oneTBB arena allows; the
/// film's bytes do not depend on their number, nor on the instruction set.
Film render(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options = {},
            RenderStatistics* statistics = nullptr);

}  // namespace alidade
