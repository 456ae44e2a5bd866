// SPDX-License-Identifier: MIT
#pragma once

#include "base/progress.h"
#include "camera/camera.h"
#include "image/film.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"
#include "renderer/world.h"

namespace alidade::renderer {

/// Depth without an image: one ray through the centre of each pixel, up to the first surface, and no light.
/// The values are those of the layers that render() fills, bit for bit.
class DepthTracer {
 public:
  /// Of the scene only the cloud's settings and the objects count. `cloud` may be null; it must outlive this.
  DepthTracer(const Scene& scene, const LoadedCloud* cloud);
  DepthTracer(const DepthTracer&) = delete;
  DepthTracer& operator=(const DepthTracer&) = delete;

  /// A film with one layer: Layer::depth or Layer::distance. Runs on as many threads as the caller's oneTBB
  /// arena allows; the values do not depend on their number. `progress` counts pixels. Requires: the camera
  /// passes check_camera() and check_camera_position(). Errors: Cancelled. Cost: one ray per pixel. Memory: 4
  /// bytes per pixel.
  image::Film trace(const camera::Camera& camera, image::Layer layer, const Progress& progress = {}) const;

 private:
  Scene geometry_;
  World world_;
};

}  // namespace alidade::renderer
