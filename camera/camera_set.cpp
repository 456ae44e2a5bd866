// SPDX-License-Identifier: MIT
#include "camera/camera_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/json.h"
#include "base/words.h"
#include "camera/camera_json.h"
#include "camera/formats/camera_file.h"
#include "camera/formats/e57.h"

namespace alidade::camera {
namespace {

namespace fs = std::filesystem;

/// Keys in files of other programs that are skipped: they hold most of the bytes, and no cameras.
constexpr std::array<std::string_view, 4> k_unread{"points", "structure", "control_points", "biases"};

/// Most programs write coefficients of 0 for cameras that do not distort.
Lens simplest(const Lens& lens) {
  const auto* brown = std::get_if<BrownLens>(&lens);
  return brown != nullptr && brown->distortion == Distortion{} ? Lens(PinholeLens{}) : lens;
}

/// Sorts the cameras and applies the checks common to all formats.
CameraSet finished(CameraSet set, const std::string& file, bool sort) {
  if (set.cameras.empty()) {
    throw Error({.file = file,
                 .problem = "contains no camera with a pose",
                 .found = fmt::format("{}", fmt::join(set.warnings, ", "))});
  }
  for (NamedCamera& each : set.cameras) each.camera.lens = simplest(each.camera.lens);
  if (sort) std::ranges::stable_sort(set.cameras, {}, &NamedCamera::name);
  std::set<std::string_view> names;
  for (const NamedCamera& each : set.cameras) {
    if (!names.insert(each.name).second)
      throw file_error(file, fmt::format("duplicate camera '{}'", each.name), "unique names");
  }
  return set;
}

CameraSet parse_json_cameras(std::string text, const fs::path& name, const CameraFileOptions& options) {
  const JsonDocument document = parse_json(std::move(text), name.string(), k_unread);
  const JsonNode top(document);
  if (top.is_array()) return read_opensfm(top);
  if (top.find("frames")) return read_transforms(top, name, options.original_world);
  if (top.find("sfm_data_version")) return read_openmvg(top);
  if (top.find("model")) {
    CameraSet set;
    set.cameras.push_back({name.filename().string(), parse_camera(document.text, name)});
    return set;
  }
  top.fail("unknown camera file format",
           "a camera (\"model\"), transforms.json (\"frames\"), OpenSfM's reconstruction.json (an array) or "
           "openMVG's sfm_data.json (\"sfm_data_version\")",
           "an object without these keys");
}

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error);
}

CameraSet read_colmap_folder(const fs::path& folder) {
  // In a folder with both kinds the binary files are the newer ones.
  const fs::path cameras = folder / "cameras.bin", images = folder / "images.bin";
  if (is_there(cameras) && is_there(images)) return read_colmap_binary(InputFile(cameras), InputFile(images));
  const fs::path cameras_text = folder / "cameras.txt", images_text = folder / "images.txt";
  if (is_there(cameras_text) && is_there(images_text)) {
    return read_colmap_text(read_text_file(cameras_text, k_largest_camera_file), cameras_text.string(),
                            read_text_file(images_text, k_largest_camera_file), images_text.string());
  }
  throw file_error(folder, "no COLMAP model in this folder",
                   "cameras.bin and images.bin, or cameras.txt and images.txt (often in sparse/0)");
}

CameraSet read_e57_cameras(const fs::path& file) {
  const E57File e57{InputFile(file)};
  if (e57.document().images.empty()) throw file_error(file, "the E57 file has no photos");
  CameraSet set;
  for (E57Photo& photo : e57_photos(e57.document(), set.warnings))
    set.cameras.push_back(std::move(photo.camera));
  return set;
}

std::string without_folder(const std::string& name) {
  return name.substr(name.find_last_of('/') + 1);
}
std::string without_extension(const std::string& name) {
  return name.substr(0, name.find_last_of('.'));
}

}  // namespace

CameraSet parse_cameras(std::string text, const fs::path& name, const CameraFileOptions& options) {
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool json = first != std::string::npos && (text[first] == '{' || text[first] == '[');
  const std::string start = text.substr(0, 4096);
  try {
    if (json) return finished(parse_json_cameras(std::move(text), name, options), name.string(), true);
    return finished(read_trajectory(text, name.string(), options.lens), name.string(), false);
  } catch (const Error&) {
    reject_known_export(start, name);
    throw;
  }
}

CameraSet read_cameras(const fs::path& path, const CameraFileOptions& options) {
  std::error_code error;
  if (fs::is_directory(path, error)) return finished(read_colmap_folder(path), path.string(), true);
  if (is_e57(path)) return finished(read_e57_cameras(path), path.string(), true);
  return parse_cameras(read_text_file(path, k_largest_camera_file), path, options);
}

const NamedCamera& camera_called(const CameraSet& set, const std::string& name, const std::string& source) {
  const auto matches = [&](auto shorten) {
    std::vector<const NamedCamera*> found;
    for (const NamedCamera& each : set.cameras) {
      if (shorten(each.name) == name) found.push_back(&each);
    }
    return found;
  };
  std::vector<const NamedCamera*> found = matches([](const std::string& each) { return each; });
  if (found.empty()) found = matches(without_folder);
  if (found.empty())
    found = matches([](const std::string& each) { return without_extension(without_folder(each)); });
  if (found.size() == 1) return *found.front();

  std::vector<std::string_view> names;
  for (const NamedCamera& each : set.cameras) names.push_back(each.name);
  const std::string_view nearest = nearest_word(name, names);
  throw file_error(
      source, fmt::format("{} named '{}'", found.empty() ? "no camera" : "several cameras", name),
      fmt::format("one of {} names such as '{}'", names.size(), nearest.empty() ? names.front() : nearest));
}

}  // namespace alidade::camera
