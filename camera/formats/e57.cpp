// SPDX-License-Identifier: MIT
#include "camera/formats/e57.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "base/error.h"
#include "base/input_file.h"
#include "cloud/cloud_inputs.h"

namespace alidade::camera {
namespace {

/// Limits of camera files (docs/cameras.md).
constexpr double k_least_focal_length = 1e-6, k_largest_focal_length = 1e12, k_farthest_middle = 1e9;

bool is_possible(const E57Representation& representation, const Camera& camera) {
  constexpr auto k_side = static_cast<std::uint64_t>(k_max_image_side);
  if (representation.width < 1 || representation.height < 1 || representation.width > k_side ||
      representation.height > k_side)
    return false;
  if (representation.width * representation.height > k_max_pixels) return false;
  for (const double length : {camera.fx, camera.fy})
    if (!(length >= k_least_focal_length && length <= k_largest_focal_length)) return false;
  return std::abs(camera.cx) <= k_farthest_middle && std::abs(camera.cy) <= k_farthest_middle;
}

/// Files often round the angle of a pixel: an image whose side covers a circle, or half of one, to half a
/// pixel covers it without a gap at the seam.
double pixels_per_radian(double pixel, std::uint64_t count, double whole) {
  const double side = static_cast<double>(count);
  return std::abs(pixel * side - whole) < 0.5 * pixel ? side / whole : 1.0 / pixel;
}

}  // namespace

std::optional<Camera> camera_of(const E57Image& image, const E57Representation& representation) {
  Camera camera;
  glm::dvec3 right(1, 0, 0), down(0, -1, 0), forward(0, 0, -1);
  if (representation.projection == E57Projection::pinhole) {
    camera.fx = representation.focal_length / representation.pixel_width;
    camera.fy = representation.focal_length / representation.pixel_height;
    camera.cx = representation.principal_x;
    camera.cy = representation.principal_y;
  } else if (representation.projection == E57Projection::spherical) {
    camera.lens = EquirectangularLens{};
    camera.fx = pixels_per_radian(representation.pixel_width, representation.width, 2.0 * std::numbers::pi);
    camera.fy = pixels_per_radian(representation.pixel_height, representation.height, std::numbers::pi);
    camera.cx = 0.5 * static_cast<double>(representation.width);
    camera.cy = 0.5 * static_cast<double>(representation.height);
    right = {0, -1, 0};
    down = {0, 0, -1};
    forward = {1, 0, 0};
  } else {
    return std::nullopt;
  }
  if (!is_possible(representation, camera)) return std::nullopt;
  camera.width = static_cast<int>(representation.width);
  camera.height = static_cast<int>(representation.height);
  const E57Pose pose = image.pose.value_or(E57Pose{});
  camera.pose = {.position = pose.translation,
                 .right = pose.rotation * right,
                 .down = pose.rotation * down,
                 .forward = pose.rotation * forward};
  return camera;
}

bool is_e57(const std::filesystem::path& file) {
  constexpr std::size_t k_start_bytes = 4096;
  try {
    InputFile input(file);
    return k_e57_format.is_begun_by(input.view_up_to(0, k_start_bytes));
  } catch (const Error&) {
    return false;
  }
}

std::vector<E57Photo> e57_photos(const E57Document& document, std::vector<std::string>& warnings) {
  std::vector<E57Photo> photos;
  std::set<std::string> names;
  std::map<std::string, int> counts;  // thousands of images may have one name
  std::size_t representations = 0, without_pose = 0, masks = 0;
  for (std::size_t i = 0; i < document.images.size(); ++i) {
    const E57Image& image = document.images[i];
    std::string name = image.name.empty() ? image.guid : image.name;
    if (name.empty()) name = fmt::format("image {}", i + 1);
    representations += image.representations.size();
    for (const E57Representation& representation : image.representations) {
      const std::optional<Camera> camera = camera_of(image, representation);
      if (!camera) continue;
      without_pose += image.pose ? 0 : 1;
      masks += representation.mask ? 1 : 0;
      std::string unique = name;
      for (int& count = counts[name]; !names.insert(unique).second;)
        unique = fmt::format("{}_{}", name, ++count + 1);
      photos.push_back({{unique, *camera}, representation});
    }
  }
  if (photos.size() < representations) {
    warnings.push_back(fmt::format(
        "skipped {} of {} images without a camera: visual references, cylindrical images, invalid sizes",
        representations - photos.size(), representations));
  }
  if (without_pose > 0) {
    warnings.push_back(
        fmt::format("{} of {} photos have no pose: using the axes of the file", without_pose, photos.size()));
  }
  if (masks > 0)
    warnings.push_back(fmt::format("ignored the masks of {} of {} photos", masks, photos.size()));
  return photos;
}

}  // namespace alidade::camera
