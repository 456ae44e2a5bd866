// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>
#include <vector>

#include "image/output_settings.h"
#include "jobs/cloud_fields.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/long_run.h"
#include "jobs/render/depth_maps.h"
#include "jobs/render/flight.h"
#include "jobs/render/ground_layers.h"
#include "jobs/render/views.h"
#include "renderer/overview.h"
#include "renderer/render.h"
#include "renderer/scene.h"

namespace alidade::jobs {

inline constexpr std::uint64_t k_most_preview_points = 50'000'000;

/// Images of a scene, or of clouds in daylight.
///
///   RenderRequest request;
///   request.scene = renderer::daylight_scene({"site.las"});
///   request.output = "site.png";
///   const RenderResult result = run(plan(request), listener);
struct RenderRequest : CloudRequest {
  /// Surfaces, light, colours, and settings of the image. Fields change it as they are read, so that a field
  /// overrides what a scene file has. The cloud's points are those of `files`, and if there are none those of
  /// the files that the scene names, in the `view`.
  renderer::Scene scene = renderer::daylight_scene({});
  /// What the scene was read from, for messages; empty: it is one in daylight, and an image of the whole
  /// cloud chooses its samples, background and light.
  std::filesystem::path scene_file;
  CloudView view{};
  bool adds_models = false;  ///< the scene got models, from --mesh or --site, that its file does not have
  bool in_view = false;      ///< of a cloud in a database, only what the cameras see is read
  /// Without an output, also of depth maps, images are returned. The output of a scene file does not count.
  bool returns_films = false;

  ViewsRequest views;
  FlightRequest flight;
  DepthRequest depth;
  GroundLayers ground;
  std::optional<int> samples;        ///< per pixel; empty: the scene's, 16 for an image of the whole cloud
  std::vector<image::Layer> layers;  ///< of an EXR; empty: the scene's
  std::optional<bool> has_auto_exposure;  ///< empty: in light, for an image of the whole cloud
  bool has_given_sun = false;             ///< the sun stays where it is, whatever the image shows
  bool has_given_shape = false;           ///< no warning about spheres that make depths too small
  std::filesystem::path legend;           ///< .png; empty: none
  std::optional<glm::ivec2> legend_size;  ///< pixels; empty: fits its text
  bool skips_existing = false;            ///< existing images stay

  std::optional<double> time_limit, target_noise;  ///< of an image: renderer::RenderOptions
  std::filesystem::path preview;                   ///< .png or .jpg; empty: none
  double preview_interval = 3.0;                   ///< seconds
  std::uint64_t preview_points = 300'000;          ///< of the first look at COPC files; 0: none
  CheckpointRequest checkpoint;
  std::optional<renderer::ImagePart> part;  ///< empty: whole images

  /// Whether the image, or the flight, shows the whole cloud: neither a scene nor a camera is given.
  bool is_overview() const {
    return scene_file.empty() && views.file.empty() && flight.keyframes.empty() && !views.panorama &&
           !views.from_above && !scene.camera;
  }
  /// Whether the scene has the exact surfaces of a site.
  bool has_site() const;

  /// All files that are read, but those of the cloud.
  std::vector<std::filesystem::path> other_inputs() const;

  /// The file that is written for an image: the image, or "IMAGE.part3of20" for a part.
  std::filesystem::path written_file(const std::filesystem::path& image) const;
};

/// Declares all fields.
void add_render_fields(const Fields& fields, RenderRequest& request);

/// Errors: the request has neither a cloud nor other surfaces.
void check_surfaces(const RenderRequest& request);

/// Errors, naming the field: the scene has no cloud that it could change. Returns the cloud's settings.
renderer::CloudSettings& cloud_settings(RenderRequest& request, const std::string& field);

}  // namespace alidade::jobs
