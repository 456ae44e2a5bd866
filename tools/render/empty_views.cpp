// SPDX-License-Identifier: MIT
#include "tools/render/empty_views.h"

#include <fmt/format.h>
#include <algorithm>
#include <variant>

#include "base/error.h"
#include "tools/camera_file.h"
#include "visibility/photos/photo_visibility.h"

namespace alidade::tools {
namespace {

/// "camera 'a.jpg' sees nothing", "2 cameras see nothing: 'a.jpg', 'b.jpg'".
std::string names_of(std::span<const View> views) {
  if (views.size() == 1 && views.front().name.empty()) return "the camera sees nothing";
  if (views.size() == 1) return fmt::format("camera '{}' sees nothing", views.front().name);
  std::vector<std::string> names;
  for (const View& view : views) names.push_back(view.name);
  return fmt::format("{} cameras see nothing: {}", views.size(), some_names(names));
}

/// The reason if it is known; else empty.
std::string reason_of(std::span<const View> views, const Octree& octree) {
  std::vector<camera::NamedCamera> cameras;
  for (const View& view : views)
    if (!std::holds_alternative<camera::OrthographicLens>(view.camera.lens))
      cameras.push_back({.name = view.name, .camera = view.camera});
  if (cameras.empty() || octree.size() == 0) return "";
  try {
    visibility::check_photos(octree, cameras);
  } catch (const Error& error) {
    return error.what();
  }
  return "the frame contains points, but no pixel shows one";
}

}  // namespace

void EmptyViews::check(const View& view, bool sees_anything) {
  const bool is_known = std::ranges::find(views_, view.name, &View::name) != views_.end();
  if (!is_known && !sees_anything) views_.push_back(view);
}

ExitCode EmptyViews::report(const CameraRequest& request, const renderer::Scene& scene,
                            const renderer::LoadedCloud* cloud, Verbosity verbosity) const {
  if (views_.empty() || (!scene.cloud && scene.objects.empty())) return ExitCode::done;
  std::string text = request.extent ? "--extent contains no points of the cloud" : names_of(views_);
  const std::string reason = cloud != nullptr ? reason_of(views_, cloud->octree) : "";
  say_warnings(verbosity, {reason.empty() ? text : text + "; " + reason});
  return ExitCode::no;
}

std::string remark_on_colors(const image::ColorKey& key) {
  const std::uint64_t count = key.point_count - key.missing_count;
  if (count == 0) return "";
  if (key.scale && key.scale->extent.low == key.scale->extent.high)
    return fmt::format("--color-by {}: all values are {:g}", key.word, key.scale->extent.low);
  const bool is_one = !key.scale && key.swatches.size() == 1 && key.swatches.front().count;
  return is_one ? fmt::format("--color-by {}: all values are {}", key.word,
                              key.swatches.front().number.empty() ? key.swatches.front().label
                                                                  : key.swatches.front().number)
                : "";
}

}  // namespace alidade::tools
