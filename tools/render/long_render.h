// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "renderer/image_metadata.h"
#include "renderer/render.h"
#include "tools/options.h"

// Renders that take long: they stop by time or by noise, show previews, and can be resumed.

namespace alidade::tools {

inline constexpr std::uint64_t k_most_preview_points = 50'000'000;

struct LongRenderRequest {
  std::optional<double> time_limit, target_noise;
  std::filesystem::path preview;  ///< empty = none
  double preview_interval = 3.0;
  std::uint64_t preview_points = 300'000;  ///< of the first look at COPC files; 0 = none
  CheckpointRequest checkpoint;
  std::optional<renderer::ImagePart> part;  ///< empty: whole images
};

/// The file that is written for an image: the image, or "IMAGE.part3of20" for a part.
std::filesystem::path written_file(const LongRenderRequest& request, const std::filesystem::path& image);

/// Declares the options; they fill `request`.
void add_long_render_options(const Fields& render, LongRenderRequest& request);

/// Which existing files may be replaced. A file at the checkpoint's name must be a checkpoint even then.
struct Replaceable {
  bool any = false;
  bool earlier_preview = false;  ///< an image whose metadata marks it as a preview
};

/// Lets a render fail before it starts. `outputs` and `inputs`: the images and all that is read. Errors: a
/// preview or checkpoint that is one of them, exists and may not be replaced, or cannot be written; a preview
/// that is neither PNG nor JPEG. A checkpoint to resume from is always replaceable.
void check_long_render(const LongRenderRequest& request, Replaceable replaceable,
                       std::span<const std::filesystem::path> outputs,
                       std::span<const std::filesystem::path> inputs);

/// A checkpoint of the first image to make.
struct Resumption {
  std::uint64_t samples = 0;  ///< camera samples that are in it
  std::string note;           ///< to be printed once the checkpoint has been accepted
};

/// What to resume from. `images` are those to make, `finished` existing ones of the set. Empty, with a
/// note, if the first image starts from the beginning. Errors: those of the checkpoint's head; it belongs
/// to an image that is neither finished nor the first.
std::optional<Resumption> find_resumption(const LongRenderRequest& request,
                                          std::span<const std::filesystem::path> images,
                                          std::span<const std::filesystem::path> finished,
                                          Verbosity verbosity);

/// Warns of a target of noise if so many samples per pixel are too few to test it.
void warn_of_few_samples(const LongRenderRequest& request, int samples);

/// The options for one image, without progress.
renderer::RenderOptions render_options(const LongRenderRequest& request, const image::OutputSettings& output,
                                       bool resume, const renderer::ImageMetadata& metadata);

/// Renders the scene's image and writes it, with metadata about samples and noise, or renders and writes a
/// part. Returns the image; empty for a part.
std::optional<image::Film> render_to_file(const LongRenderRequest& request, const renderer::Scene& scene,
                                          const renderer::LoadedCloud* cloud,
                                          const renderer::RenderOptions& options,
                                          renderer::ImageMetadata metadata, bool overwrite,
                                          renderer::RenderStatistics& statistics);

/// The samples and noise reached, for people, and what stopped the render if it was not the requested limit;
/// empty if --samples alone determined them.
std::string describe_reached(const LongRenderRequest& request, const renderer::RenderStatistics& statistics);

/// Removes the checkpoint of an image that has been written.
void remove_checkpoint(const LongRenderRequest& request);

/// Removes the checkpoint of a finished image, which is left if the program was killed before.
void remove_finished_checkpoint(const LongRenderRequest& request,
                                std::span<const std::filesystem::path> finished);

}  // namespace alidade::tools
