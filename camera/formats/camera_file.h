// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/input_file.h"
#include "base/json.h"
#include "camera/camera_set.h"
#include "camera/projection.h"

// How the readers of camera files are split, and what they share.

namespace alidade {

/// Largest camera file, without a COLMAP model's points: 1 GiB.
inline constexpr std::uintmax_t k_largest_camera_file = std::uintmax_t{1} << 30;

/// Digits that rotations in files may lack.
inline constexpr double k_file_rotation_tolerance = 1e-3;

/// Image size from a file that says it in whole pixels. Errors: 0, or larger than pictures may be.
void set_size(Camera& camera, std::uint64_t width, std::uint64_t height);

CameraSet read_transforms(const JsonNode& top, const std::filesystem::path& file, bool original_world);
CameraSet read_opensfm(const JsonNode& top);
CameraSet read_openmvg(const JsonNode& top);
CameraSet read_trajectory(std::string_view text, const std::string& name, const std::optional<Camera>& lens);

/// A COLMAP model: its two files, both binary or both text.
CameraSet read_colmap_binary(InputFile cameras, InputFile images);
CameraSet read_colmap_text(std::string_view cameras, const std::string& cameras_name, std::string_view images,
                           const std::string& images_name);

/// The lens and focal lengths of a COLMAP model by the id in binary files, and how many parameters it has.
struct ColmapModel {
  std::string_view name;
  int id;
  std::size_t parameter_count;
};
std::span<const ColmapModel> colmap_models();
/// Requires: as many parameters as the model has. Errors: as check_camera_numbers().
Camera camera_of_colmap(const ColmapModel& model, std::uint64_t width, std::uint64_t height,
                        std::span<const double> parameters);

/// A camera's JSON with the error of `work` told at its place.
template <typename Work>
auto at_node(const JsonNode& node, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    if (!error.parts().file.empty()) throw;
    node.fail(error.parts().problem, error.parts().expected, error.parts().found);
  }
}

}  // namespace alidade
