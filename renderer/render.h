// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/fingerprint.h"
#include "base/progress.h"
#include "image/film.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"

namespace alidade::renderer {

/// Changes whenever the same scene gives other bytes, so that no checkpoint continues with samples of another
/// kind.
inline constexpr int k_image_version = 6;

/// Small images of the unfinished render.
struct PreviewOptions {
  /// Gets colour and alpha, each pixel the mean of a square of the image's. Called by one thread at a time,
  /// while others continue; first when every pixel has a sample, last when the image is finished. What it
  /// throws ends the render.
  std::function<void(const image::Film& preview)> show;
  double interval = 3.0;    ///< seconds from the end of one to the next, >= 0
  int longest_side = 1024;  ///< pixels, >= 1
};

/// A file from which a render that was interrupted or killed resumes, and gives the same bytes.
struct CheckpointOptions {
  std::filesystem::path file;  ///< replaced completely or not at all; never removed by render()
  /// Seconds from the end of one to the next, > 0; at least ten times what writing takes.
  double interval = 60.0;
  bool resume = false;  ///< resume from the file; without it, start
  std::string image{};  ///< name of the image; a checkpoint of another one is rejected
  /// Called once the render resumes from the file.
  std::function<void()> resumed{};
  /// Called when a checkpoint cannot be written (a full disk); the render continues. Without it, that ends
  /// the render.
  std::function<void(const Error&)> failed{};
};

/// One of several parts of an image, for a machine each: of its tiles of about 16 x 16 pixels, numbered
/// along Morton's curve, every `count`-th from the `number`-th on. Tiles beside each other take about the
/// same time, so parts that hold every n-th tile take about the same time, too; stripes of sky and of trees
/// do not. Along the curve they are evenly spread in both directions for any `count`; along rows, a `count`
/// that divides the number of columns would give stripes.
struct ImagePart {
  int number = 1;  ///< from 1
  int count = 1;   ///< 1: the whole image

  bool operator==(const ImagePart&) const = default;
};

/// The most parts of an image.
inline constexpr int k_most_parts = 65536;

/// "3/20".
std::string part_text(ImagePart part);

/// Pixels of a part of an image.
std::uint64_t pixel_count(int width, int height, ImagePart part);

struct RenderOptions {
  /// In camera samples (pixels * samples per pixel); called from one thread at a time. With a time limit or a
  /// target the total is what may be expected.
  Progress progress{};
  std::optional<std::vector<image::Layer>> layers{};  ///< to be had in the film; empty = all
  /// Seconds for one image, time before a resumption included, >= 0. Every pixel gets one sample in any
  /// case; then samples are spread evenly, one tile at most having twice as many as another. Only tiles that
  /// were ahead when a render without limit was interrupted stay so. The bytes depend on the time.
  std::optional<double> time_limit{};
  /// A tile gets no more samples once it has 32 and its estimated relative error is at most this (> 0), alone
  /// and together with its up to eight neighbours; RenderSettings::samples is the most it gets. See
  /// renderer/noise.h.
  std::optional<double> target_noise{};
  std::optional<PreviewOptions> preview{};
  std::optional<CheckpointOptions> checkpoint{};
  /// What of the image is rendered; pixels of other parts are as those without samples.
  ImagePart part{};
};

/// Whether noise is added up along with the image: for the variance layer or a target.
bool keeps_noise(const RenderOptions& options);

/// Noise that is left, as relative error of a tile (renderer/noise.h); infinite if unknown, of one sample.
struct ReachedNoise {
  double median = 0.0, worst = 0.0;  ///< over tiles
};

struct RenderStatistics {
  std::uint64_t ray_count = 0;              ///< rays traced, shadow rays included
  double seconds = 0.0;                     ///< time before a resumption included
  int least_samples = 0, most_samples = 0;  ///< of any pixel
  double mean_samples = 0.0;
  std::optional<ReachedNoise> noise{};  ///< if it was added up
  std::size_t tiles = 0;                ///< of about 16 x 16 pixels
  std::size_t noisy_tiles = 0;          ///< those that have not reached the target, if there is one
  std::size_t hurried_tiles = 0;        ///< those of them, or of all, that time kept from having all samples
};

/// Errors: the camera is inside the sphere of a point (its number is reported). Cameras of parallel rays have
/// no position to check.
void check_camera_position(const camera::Camera& camera, const Scene& scene, const LoadedCloud& cloud);

/// Path-traces the scene (its camera must be set, and pass check_camera() and check_camera_position()).
/// `cloud` may be null for scenes of objects alone. Runs on as many threads as the caller's oneTBB arena
/// allows; the film's bytes do not depend on their number, nor on the instruction set.
///
/// Memory beside scene and cloud: 28 bytes per pixel, 52 with the sums for noise, then 16 for colour and
/// alpha and 12 for the variance, which replace the sums; image/film.h gives those of each further layer; and
/// some 25 MB per thread. Where malloc gives freed memory back to the system at once, pictures take up to a
/// third longer: programs call keep_freed_memory() (base/huge_memory.h) before.
///
/// Errors: no camera; a model without surfaces; a number outside its range; a part with a time limit or a
/// target, on which pixels of other parts depend; of checkpoints: damage, another image, a failed write.
/// Cancelled, if `progress` returns false; the checkpoint then holds all samples taken.
image::Film render(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options = {},
                   RenderStatistics* statistics = nullptr);

/// Where a part goes.
struct PartOutput {
  std::filesystem::path file;
  bool overwrite = false;
  Fingerprint image{};  ///< what the image holds besides its pixels: image_entries()
};

/// Renders a part as render() does, and writes it to a file for merge_parts(). The bytes depend on nothing
/// else, as those of images. Memory: the sums and the layers of the whole image. Errors: those of
/// render() and OutputFile.
void render_part(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options,
                 const PartOutput& output, RenderStatistics* statistics = nullptr);

}  // namespace alidade::renderer
