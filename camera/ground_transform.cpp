// SPDX-License-Identifier: MIT
#include "camera/ground_transform.h"

#include "base/error.h"

namespace alidade {

std::array<double, 6> ground_transform(const Camera& camera) {
  const CameraPose& pose = camera.pose;
  if (!std::holds_alternative<OrthographicLens>(camera.lens) || !(pose.forward.z < -1.0 + 1e-12)) {
    throw Error({.problem = "only a picture of parallel rays from straight above can be a GeoTIFF",
                 .expected = "--orthographic top, or an orthographic camera that looks along -z"});
  }
  const glm::dvec3 across = pose.right / camera.fx, down = pose.down / camera.fy;
  const glm::dvec3 corner = pose.position - camera.cx * across - camera.cy * down;
  return {corner.x, across.x, down.x, corner.y, across.y, down.y};
}

}  // namespace alidade
