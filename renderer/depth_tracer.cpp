// SPDX-License-Identifier: MIT
#include "renderer/depth_tracer.h"

#include <tbb/task_arena.h>
#include <array>
#include <cassert>

#include "base/parallel.h"
#include "renderer/tile_tracer.h"

namespace alidade::renderer {
namespace {

/// The part of a scene that has a depth.
Scene geometry_of(const Scene& scene) {
  Scene geometry;
  geometry.objects = scene.objects;
  geometry.cloud = scene.cloud;
  // Smooth normals take memory for every point, and no depth depends on them.
  if (geometry.cloud) geometry.cloud->normals = NormalMode::sphere;
  return geometry;
}

}  // namespace

DepthTracer::DepthTracer(const Scene& scene, const LoadedCloud* cloud)
    : geometry_(geometry_of(scene)), world_(geometry_, cloud) {}

image::Film DepthTracer::trace(const camera::Camera& camera, image::Layer layer,
                               const Progress& progress) const {
  assert(layer == image::Layer::depth || layer == image::Layer::distance);
  const camera::Projection projection(camera);
  image::Film film(camera.width, camera.height, std::array{layer});
  const TileGrid grid(camera.width, camera.height);
  JoinedProgress done(progress, film.count());
  in_parallel(grid.count(), 1, [&](std::size_t tile) {
    // Threads have tiles of their own: the rays of one are not to be shared out again.
    tbb::task_arena alone(1);
    alone.execute([&] { fill_center_layers(projection, world_, grid.box(tile), film); });
    // Once per row: the watch is not to be called for every tile.
    if (grid.column_of(tile) + 1 == grid.columns()) done.add(grid.band(grid.row_of(tile)).count());
  });
  return film;
}

}  // namespace alidade::renderer
