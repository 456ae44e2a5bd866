// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "renderer/scene.h"
#include "tools/command.h"
#include "tools/render/depth_maps.h"
#include "tools/render/flight.h"
#include "tools/render/ground_layers.h"
#include "tools/render/light_and_color.h"
#include "tools/render/long_render.h"
#include "tools/render/views.h"

namespace alidade::tools {

/// The options of the radii of points. Members that are empty leave the scene unchanged; any of the last
/// three makes radii adapted.
struct RadiusRequest {
  enum class Kind { automatic, length, adapted };
  std::optional<Kind> kind;
  double length = 0.0;  ///< metres, of that kind
  std::optional<double> factor;
  std::optional<int> neighbours;
  std::optional<std::optional<double>> max;  ///< metres; an empty length in it is "auto"
};

/// The command line of `alidade render`. Members that are empty leave the scene unchanged.
struct RenderCommand : CloudRequest {
  std::filesystem::path scene_file;
  CloudView view;                             ///< of the clouds, also those of a scene
  std::vector<std::filesystem::path> meshes;  ///< in world coordinates
  bool exact_site = false;                    ///< the courtyard itself instead of a scan
  bool in_view = false;                       ///< of a cloud in a database, only what the cameras see is read
  std::filesystem::path output;
  CameraRequest camera;
  FlightRequest flight;
  DepthRequest depth;
  LightRequest light;
  std::optional<int> samples, max_bounces;
  std::optional<std::uint64_t> seed;
  RadiusRequest radius;
  std::optional<ColorDepth> color_depth;
  ColorRequest color;
  std::optional<renderer::HitMode> hits;
  std::optional<renderer::NormalMode> normals;
  std::optional<renderer::PointShape> shape;
  std::optional<int> max_level;
  std::optional<std::optional<double>> exposure;  ///< an empty one in it is "auto"
  bool transparent = false;
  GroundLayers ground;
  std::vector<image::Layer> layers;
  LongRenderRequest long_render;
  bool overwrite = false, skip_existing = false;

  /// Whether the image, or the flight, shows the whole cloud: neither a scene nor a camera is given.
  bool is_overview() const {
    return scene_file.empty() && camera.file.empty() && flight.keyframes.empty() && !camera.panorama &&
           !camera.from_above;
  }
};

/// Declares the command's options; they fill what is returned.
std::shared_ptr<RenderCommand> add_render_options(const Fields& render);

/// The scene to render: read from its file, or a default one around the clouds, with all options applied but
/// those of the camera. Errors: options that contradict each other or do not fit the scene.
renderer::Scene requested_scene(const RenderCommand& command);

}  // namespace alidade::tools
