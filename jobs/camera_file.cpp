// SPDX-License-Identifier: MIT
#include "jobs/camera_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "camera/camera_json.h"
#include "camera/projection.h"

namespace alidade::jobs {
namespace {

/// Adds the camera and file to an error of check_camera().
void check(const camera::Camera& camera, const std::string& file, const std::string& name) {
  try {
    camera::check_camera(camera);
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    parts.file = file;
    if (!name.empty()) parts.problem = fmt::format("camera '{}': {}", name, parts.problem);
    throw Error(parts);
  }
}

}  // namespace

void add_camera_reading(const Fields& fields, const std::string& lens_default, CameraFileRequest& request) {
  fields.file("--lens", "FILE.json", "camera file with the size and lens of a trajectory" + lens_default,
              request.lens);
  fields.flag("--original-world", "transforms.json: undo applied_transform and applied_scale",
              request.original_world);
}

camera::CameraSet read_camera_file(const CameraFileRequest& request, std::optional<camera::Camera> lens) {
  const std::filesystem::path& file = request.file;
  const std::vector<std::string>& names = request.names;
  if (!request.lens.empty()) lens = camera::read_camera(request.lens);
  camera::CameraSet set =
      camera::read_cameras(file, {.lens = lens, .original_world = request.original_world});
  if (!names.empty()) {
    std::vector<camera::NamedCamera> chosen;
    for (const std::string& name : names) {
      const camera::NamedCamera& called = camera::camera_called(set, name, file.string());
      if (std::ranges::find(chosen, called.name, &camera::NamedCamera::name) != chosen.end())
        throw file_error(file, fmt::format("duplicate camera '{}'", called.name), "each --camera-name once");
      chosen.push_back(called);
    }
    set.cameras = std::move(chosen);
  }
  for (const camera::NamedCamera& each : set.cameras) check(each.camera, file.string(), each.name);
  return set;
}

std::string some_names(std::span<const std::string> names) {
  constexpr std::size_t k_most = 10;
  std::string text;
  for (const std::string& name : names.first(std::min(names.size(), k_most)))
    text += fmt::format("{}'{}'", text.empty() ? "" : ", ", name);
  return names.size() > k_most ? text + ", ..." : text;
}

}  // namespace alidade::jobs
