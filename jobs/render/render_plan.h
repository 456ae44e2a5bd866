// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "jobs/plan.h"
#include "jobs/render/render_request.h"

namespace alidade::jobs {

/// An image to make.
struct PlannedImage {
  std::size_t view = 0;        ///< index
  std::filesystem::path file;  ///< empty: the image is only returned
};

/// The image in messages: its file, or "the image".
std::string shown_name(const PlannedImage& image);

/// What the first image resumes from.
struct Resumption {
  std::optional<std::uint64_t> samples;  ///< camera samples of a checkpoint; empty: from the beginning
  std::string note;                      ///< once the checkpoint is accepted, or if no checkpoint exists
};

/// A checked request, whose scene and files are complete, and what follows from it. Made by plan().
struct RenderPlan : Plan<RenderRequest> {
  using Plan::Plan;

  std::vector<camera::NamedCamera> views;       ///< of all images; empty: chosen once the cloud is loaded
  std::vector<std::string> warnings;            ///< of the file of the cameras
  std::vector<PlannedImage> images;             ///< to be made
  std::vector<std::filesystem::path> finished;  ///< existing images, which stay
  DepthPlan depth;
  bool writes_legend = false;
  std::optional<Resumption> resumption;       ///< if the request resumes
  std::shared_ptr<const EmptyFolder> frames;  ///< of a video

  PlannedWork work() const;
  bool is_resumed() const { return resumption && resumption->samples; }
  bool is_empty() const { return images.empty() && depth.empty(); }
};

/// Checks all that can be checked before a point is read. Errors: nothing to render, or nothing to write;
/// fields that do not apply to the scene, to its mode or to the output; files that cannot be read, replaced
/// or written; those of read_camera_file(), of the head of a checkpoint, and of its belonging to another
/// image; a camera without a ground transform for a GeoTIFF.
RenderPlan plan(const RenderRequest& request);

/// Errors, naming the view: an image as GeoTIFF has no ground transform; the camera is inside the sphere of a
/// point of the cloud, which may be null.
void check_view(const camera::NamedCamera& view, const std::filesystem::path& image,
                const renderer::Scene& scene, const renderer::LoadedCloud* cloud);

/// The name of an image in a checkpoint, however it was typed.
std::string image_in_checkpoint(const std::filesystem::path& image);

/// In the metadata of every preview.
inline constexpr std::string_view k_preview_mark = "alidade:preview";

}  // namespace alidade::jobs
