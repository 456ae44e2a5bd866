// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "camera/camera_set.h"
#include "renderer/render.h"
#include "tools/options.h"

namespace alidade::tools {

/// The options of the camera of `alidade render`. Members that are empty leave the scene unchanged.
struct CameraRequest {
  std::filesystem::path file, lens_file;
  std::string name;
  bool original_world = false;
  std::optional<glm::dvec3> panorama;
  bool from_above = false;
  std::optional<double> resolution;
  std::optional<std::array<double, 4>> extent;  ///< least x and y, largest x and y
  std::optional<ImageSize> size;
  std::optional<double> near;
};

/// Declares the options; they fill `request`.
void add_camera_options(const Fields& render, CameraRequest& request);

/// One image to make.
struct View {
  std::string name;  ///< of the camera in its file; empty for other cameras
  camera::Camera camera;
};

/// The views to render, as far as they are known without the cloud: the cameras of a file, a panorama, the
/// scene's own camera; empty if the view depends on the cloud. Every camera has passed check_camera().
/// `warnings` gets those of the file's reader.
std::vector<View> requested_views(const CameraRequest& request, const renderer::Scene& scene,
                                  std::vector<std::string>& warnings);

/// Whether the views are a numbered set, whose images have names made from a pattern.
bool is_set(const CameraRequest& request);

/// The bounds of a cloud, without strays, and of the scene's models near it. Errors: there are no points.
/// `scene_file`: the scene's name in messages.
Bounds seen_bounds(const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                   const std::filesystem::path& scene_file);

/// The view of a loaded cloud from above, or an overview of the whole cloud. Errors: there are no points.
/// `scene_file`: the scene's name in messages.
View view_of_cloud(const CameraRequest& request, const renderer::Scene& scene,
                   const renderer::LoadedCloud* cloud, const std::filesystem::path& scene_file);

/// Names of the images of a set, in its order. `pattern` holds one %d, %04d (number, from 0, with leading
/// zeros up to that width), %s (the camera's name without extension, with / and what file names cannot hold
/// as _) or %f (the name with its folders and extension); %% is a percent sign. Errors: none or several of
/// them though there is more than one view; two views that would have the same name; of %f, a name that leads
/// out of the folder.
std::vector<std::filesystem::path> image_names(const std::filesystem::path& pattern,
                                               std::span<const View> views);

/// The views of a run that see no surface.
class EmptyViews {
 public:
  /// Keeps the view unless it sees anything.
  void check(const View& view, bool sees_anything);

  /// Returns ExitCode::no and warns of the views, with a probable reason, as 'alidade visibility photos'
  /// does; returns `done` if there are none, or the scene has no surface. `cloud` may be null.
  ExitCode report(const CameraRequest& request, const renderer::Scene& scene,
                  const renderer::LoadedCloud* cloud, Verbosity verbosity) const;

 private:
  std::vector<View> views_;
};

}  // namespace alidade::tools
