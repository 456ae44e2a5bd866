// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <array>
#include <cassert>
#include <numbers>

#include "base/error.h"
#include "camera/formats/camera_file.h"

namespace alidade {
namespace {

constexpr std::array<ColmapModel, 18> k_models = {{{"SIMPLE_PINHOLE", 0, 3},
                                                   {"PINHOLE", 1, 4},
                                                   {"SIMPLE_RADIAL", 2, 4},
                                                   {"RADIAL", 3, 5},
                                                   {"OPENCV", 4, 8},
                                                   {"OPENCV_FISHEYE", 5, 8},
                                                   {"FULL_OPENCV", 6, 12},
                                                   {"FOV", 7, 5},
                                                   {"SIMPLE_RADIAL_FISHEYE", 8, 4},
                                                   {"RADIAL_FISHEYE", 9, 5},
                                                   {"THIN_PRISM_FISHEYE", 10, 12},
                                                   {"RAD_TAN_THIN_PRISM_FISHEYE", 11, 16},
                                                   {"SIMPLE_DIVISION", 12, 4},
                                                   {"DIVISION", 13, 5},
                                                   {"SIMPLE_FISHEYE", 14, 3},
                                                   {"FISHEYE", 15, 4},
                                                   {"EUCM", 16, 6},
                                                   {"EQUIRECTANGULAR", 17, 2}}};

/// Whether the model has one focal length for both axes.
bool has_one_focal_length(int id) {
  return id == 0 || id == 2 || id == 3 || id == 8 || id == 9 || id == 12 || id == 14;
}

/// `k`: the parameters behind focal lengths and principal point.
Lens lens_of(int id, std::span<const double> k) {
  switch (id) {
    case 0:
    case 1:
      return PinholeLens{};
    case 2:
      return BrownLens{{.radial = {k[0]}}};
    case 3:
      return BrownLens{{.radial = {k[0], k[1]}}};
    case 4:
      return BrownLens{{.radial = {k[0], k[1]}, .p1 = k[2], .p2 = k[3]}};
    case 5:
      return FisheyeLens{{.radial = {k[0], k[1], k[2], k[3]}}};
    case 6:
      return BrownLens{
          {.radial = {k[0], k[1], k[4]}, .denominator = {k[5], k[6], k[7]}, .p1 = k[2], .p2 = k[3]}};
    case 7:
      return FieldOfViewLens{k[0]};
    case 8:
      return FisheyeLens{{.radial = {k[0]}}};
    case 9:
      return FisheyeLens{{.radial = {k[0], k[1]}}};
    case 10:
      return FisheyeLens{
          {.radial = {k[0], k[1], k[4], k[5]}, .p1 = k[2], .p2 = k[3], .prism = {k[6], 0.0, k[7], 0.0}}};
    case 11:
      // Its p0 stands where all others have p2.
      return FisheyeLens{{.radial = {k[0], k[1], k[2], k[3], k[4], k[5]},
                          .p1 = k[7],
                          .p2 = k[6],
                          .prism = {k[8], k[9], k[10], k[11]},
                          .after_radial = true}};
    case 12:
    case 13:
      return DivisionLens{k[0]};
    case 16:
      return UnifiedLens{k[0], k[1]};
    default:
      return FisheyeLens{};
  }
}

}  // namespace

std::span<const ColmapModel> colmap_models() {
  return k_models;
}

void set_size(Camera& camera, std::uint64_t width, std::uint64_t height) {
  constexpr std::uint64_t k_side = k_max_image_side;
  if (width < 1 || height < 1 || width > k_side || height > k_side || width * height > k_max_pixels) {
    throw Error({.problem = "image size is out of range",
                 .expected = "1 to 65536 pixels each way, at most 2^28 in all",
                 .found = fmt::format("{} x {}", width, height)});
  }
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
}

Camera camera_of_colmap(const ColmapModel& model, std::uint64_t width, std::uint64_t height,
                        std::span<const double> parameters) {
  assert(parameters.size() == model.parameter_count);
  Camera camera;
  set_size(camera, width, height);
  if (model.id == 17) {
    camera.fx = parameters[0] / (2.0 * std::numbers::pi);
    camera.fy = parameters[1] / std::numbers::pi;
    camera.cx = 0.5 * parameters[0];
    camera.cy = 0.5 * parameters[1];
    camera.lens = EquirectangularLens{};
  } else {
    const std::size_t first = has_one_focal_length(model.id) ? 0 : 1;
    camera.fx = parameters[0];
    camera.fy = parameters[first];
    camera.cx = parameters[first + 1];
    camera.cy = parameters[first + 2];
    camera.lens = lens_of(model.id, parameters.subspan(first + 3));
  }
  check_camera_numbers(camera);
  return camera;
}

}  // namespace alidade
