// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/crs.h"
#include "image/film.h"
#include "image/output_settings.h"
#include "jobs/listener.h"
#include "jobs/render/render_plan.h"
#include "renderer/render.h"

namespace alidade::jobs {

/// Fields with a value, beside those of all jobs (jobs/long_run.h), that cannot change an image.
inline constexpr std::array<std::string_view, 11> k_silent_image_options = {
    "legend",      "legend-size", "preview",    "preview-interval", "depth", "depth-format",
    "depth-scale", "depth-along", "depth-mask", "transforms-out",   "part"};

/// An image as it was rendered.
struct RenderedImage {
  camera::NamedCamera view;
  std::filesystem::path file;  ///< that was written, of a part that of the part; empty: none, or in a video
  image::Film film{};          ///< empty if it was written
  renderer::RenderStatistics statistics{};
};

struct RenderResult {
  std::vector<RenderedImage> images;
  std::vector<std::filesystem::path> files;  ///< all that were written
  image::OutputSettings output;              ///< of the images, with the exposure and background chosen
  Crs crs;                                   ///< of the cloud
  std::vector<std::string> empty_views;      ///< names of the views that see no surface, if there are any
};

/// Renders the images, depth maps and rasters of the ground, and writes them. Errors: those of
/// load_scene_cloud(), load_meshes(), load_sky() and complete_light(); a camera inside the sphere of a point;
/// a cloud without points for a view; a library for images or maps that is missing; those of
/// renderer::render() and of writing; Cancelled. Memory: that of renderer::load_cloud() and
/// renderer::render(), and all films if these are returned.
RenderResult run(const RenderPlan& plan, Listener& listener);

}  // namespace alidade::jobs
