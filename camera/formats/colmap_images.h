// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "camera/camera_set.h"

namespace alidade {

/// What the binary and the text file say about an image of a COLMAP model.
struct ColmapImage {
  std::uint32_t id = 0;
  std::array<double, 4> quaternion{};   ///< w, x, y, z; world to camera
  std::array<double, 3> translation{};  ///< world to camera
  std::uint32_t camera_id = 0;
  std::string name;
};

/// Joins the images of a COLMAP model with their cameras. Errors, without file and place: an id that stands
/// twice, an image of an absent camera, a rotation or translation that is none, a name that is empty.
class ColmapImages {
 public:
  void add_camera(std::uint32_t id, const Camera& camera);
  void add_image(const ColmapImage& image);
  CameraSet take() { return std::move(set_); }

 private:
  std::unordered_map<std::uint32_t, Camera> cameras_;
  std::unordered_set<std::uint32_t> image_ids_;
  CameraSet set_;
};

}  // namespace alidade
