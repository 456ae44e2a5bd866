// SPDX-License-Identifier: MIT
// Any bytes as a file of cameras, of whatever kind: an Error, or cameras that can be used.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/error.h"
#include "camera/camera.h"
#include "camera/camera_set.h"
#include "camera/projection.h"

namespace alidade {

using namespace camera;

namespace {

/// Rays and positions that come out of a camera are numbers, whatever its parameters.
void use(const Camera& camera) {
  const Projection projection(camera);
  for (const glm::dvec2& film : {glm::dvec2(0.5, 0.5), glm::dvec2(camera.width, camera.height)}) {
    const auto ray = projection.ray(film);
    if (ray && !(ray->direction.x * ray->direction.x <= 1.1)) std::abort();
  }
  projection.project(camera.pose.position + camera.pose.forward);
  check_camera(camera);
}

}  // namespace
}  // namespace alidade

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const CameraFileOptions options{.lens = pinhole_from_fov(60, 40, 50.0, {}),
                                  .original_world = size % 2 == 0};
  try {
    const CameraSet set = parse_cameras(std::string(reinterpret_cast<const char*>(data), size),
                                        "/nonexistent/cameras.json", options);
    for (const NamedCamera& each : set.cameras) {
      try {
        use(each.camera);
      } catch (const Error&) {
      }
    }
  } catch (const Error&) {
  }
  return 0;
}
