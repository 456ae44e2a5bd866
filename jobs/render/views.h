// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "camera/camera_set.h"
#include "jobs/camera_file.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"

namespace alidade::jobs {

/// Of a view of the whole cloud, unless another size is requested.
inline constexpr ImageSize k_overview_size{1200, 800};

/// The cameras of images: those of a file, a panorama, an orthophoto, or without any the scene's camera, else
/// a view of the whole cloud.
struct ViewsRequest : CameraFileRequest {
  std::optional<glm::dvec3> panorama;           ///< its position
  bool from_above = false;                      ///< an orthophoto
  std::optional<double> resolution;             ///< size of its pixels, metres
  std::optional<std::array<double, 4>> extent;  ///< of it: least x and y, largest x and y; empty: the cloud
  std::optional<ImageSize> size;                ///< empty: the camera's
  std::optional<double> near;                   ///< metres; empty: the camera's

  /// Whether the images are a numbered set, whose names are made from a pattern.
  bool is_set() const { return !file.empty() && names.size() != 1; }
};

/// Declares the fields; they fill `request`.
void add_views_fields(const Fields& fields, ViewsRequest& request);

/// The views that are known without the cloud: the cameras of a file, a panorama, the scene's own camera;
/// empty if the view depends on the cloud. Every camera has passed check_camera(). `warnings` gets those of
/// the file's reader. Errors: those of read_camera_file(); an orthophoto without a resolution; an empty
/// extent.
std::vector<camera::NamedCamera> requested_views(const ViewsRequest& request,
                                                 const std::optional<camera::Camera>& of_scene,
                                                 std::vector<std::string>& warnings);

/// The bounds of a cloud, which may be null, without strays, and of the scene's models near it. Errors: there
/// are no points. `scene_file`: the scene's name in messages.
Bounds seen_bounds(const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                   const std::filesystem::path& scene_file);

/// The view of a loaded cloud from above, or an overview of the whole cloud. Errors: as seen_bounds().
camera::NamedCamera view_of_cloud(const ViewsRequest& request, const renderer::Scene& scene,
                                  const renderer::LoadedCloud* cloud,
                                  const std::filesystem::path& scene_file);

/// Names of the images of a set, in its order. `pattern` holds one %d, %04d (number, from 0, with leading
/// zeros up to that width), %s (the camera's name without extension, with / and what file names cannot hold
/// as _) or %f (the name with its folders and extension); %% is a percent sign. Errors: none or several of
/// them though there is more than one view; two views that would have the same name; of %f, a name that leads
/// out of the folder.
std::vector<std::filesystem::path> image_names(const std::filesystem::path& pattern,
                                               std::span<const camera::NamedCamera> views);

/// The views of a run that see no surface.
class EmptyViews {
 public:
  /// Keeps the view unless it sees anything.
  void check(const camera::NamedCamera& view, bool sees_anything);

  /// Names of those kept.
  std::vector<std::string> names() const;

  /// Warns of the views, with a probable reason, as the job on photos does. `cloud` may be null.
  void report(const ViewsRequest& request, const renderer::LoadedCloud* cloud, Listener& listener) const;

 private:
  std::vector<camera::NamedCamera> views_;
};

}  // namespace alidade::jobs
