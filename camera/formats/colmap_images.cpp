// SPDX-License-Identifier: MIT
#include "camera/formats/colmap_images.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "camera/rotation.h"

namespace alidade {

void ColmapImages::add_camera(std::uint32_t id, const Camera& camera) {
  if (!cameras_.emplace(id, camera).second)
    throw Error({.problem = fmt::format("camera {} stands twice", id), .expected = "every id once"});
}

void ColmapImages::add_image(const ColmapImage& image) {
  const auto camera = cameras_.find(image.camera_id);
  if (camera == cameras_.end()) {
    throw Error({.problem = fmt::format("image {} was taken by camera {}, which is not there", image.id,
                                        image.camera_id)});
  }
  if (!image_ids_.insert(image.id).second)
    throw Error({.problem = fmt::format("image {} stands twice", image.id), .expected = "every id once"});
  if (image.name.empty()) throw Error({.problem = fmt::format("image {} has no name", image.id)});
  const auto rotation = rotation_from_quaternion(image.quaternion);
  if (!rotation) {
    throw Error({.problem = fmt::format("rotation of image {} is none", image.id),
                 .expected = "a finite quaternion that is not zero"});
  }
  const auto& [x, y, z] = image.translation;
  if (!(std::fabs(x) <= 1e12 && std::fabs(y) <= 1e12 && std::fabs(z) <= 1e12)) {
    throw Error({.problem = fmt::format("translation of image {} is out of range", image.id),
                 .expected = "numbers within +-1e12"});
  }
  NamedCamera& named = set_.cameras.emplace_back(NamedCamera{image.name, camera->second});
  named.camera.pose = pose_from_world_to_camera(*rotation, {x, y, z});
}

}  // namespace alidade
