// SPDX-License-Identifier: MIT
#include "tools/render/long_render.h"

#include <fmt/format.h>
#include <cmath>

#include "base/checkpoint.h"
#include "base/output_file.h"
#include "base/shown_text.h"
#include "image/image_file.h"
#include "renderer/checkpoint.h"
#include "renderer/merge_parts.h"
#include "renderer/noise.h"

namespace alidade::tools {
namespace {

constexpr double k_most_seconds = 1e9;
/// In the metadata of every preview.
constexpr std::string_view k_preview_mark = "alidade:preview";

/// The name of an image in a checkpoint, however it was typed.
std::string image_in_checkpoint(const std::filesystem::path& image) {
  return name_in_checkpoint(std::filesystem::absolute(image).lexically_normal());
}

bool is_of_one_of(const renderer::CheckpointSummary& summary, std::span<const std::filesystem::path> images) {
  return std::ranges::find(images, summary.image, image_in_checkpoint) != images.end();
}

/// Whether a file exists and was written as a preview. Formats store texts before the pixels.
bool is_preview_of_ours(const std::filesystem::path& path) {
  constexpr std::size_t k_most_bytes = 1 << 20;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  InputFile file(path);
  const auto start = file.view_up_to(0, k_most_bytes);
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  return text.find(k_preview_mark) != std::string_view::npos;
}

/// An estimated error; of one sample there is none.
std::string error_text(double error, int digits) {
  return std::isinf(error) ? "unknown" : fmt::format("{:.{}g}", error, digits);
}

/// Shows the image under way; a preview that cannot be written is reported once and does not end the run.
class PreviewFile {
 public:
  PreviewFile(const std::filesystem::path& file, const image::OutputSettings& output,
              const renderer::ImageMetadata& metadata)
      : metadata_(metadata) {
    settings_.file = file;
    settings_.exposure = output.exposure;
    settings_.background = output.background;
    settings_.transparent = output.transparent && image::image_format(file) != image::ImageFormat::jpeg;
    const std::string text = "of an unfinished image, possibly reduced";
    metadata_.further.emplace_back(std::string(k_preview_mark), text);
    // JPEG stores no text but this one.
    metadata_.further.emplace_back("ImageDescription", fmt::format("{} {}", k_preview_mark, text));
  }

  void show(const image::Film& film) {
    try {
      image::write_image(film, settings_, renderer::image_facts(metadata_, settings_), true);
    } catch (const Error& error) {
      if (!warned_) say_warning(std::string("no preview: ") + error.what());
      warned_ = true;
    }
  }

 private:
  image::OutputSettings settings_;
  renderer::ImageMetadata metadata_;
  bool warned_ = false;
};

renderer::ImagePart parse_part(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos)
    throw UsageError("invalid value; expected I/N, such as 3/20, found '" + text + "'");
  renderer::ImagePart part;
  part.count = static_cast<int>(parse_count(text.substr(slash + 1), 1, renderer::k_most_parts));
  part.number =
      static_cast<int>(parse_count(text.substr(0, slash), 1, static_cast<std::uint64_t>(part.count)));
  return part;
}

/// Metadata about the samples and noise reached, if --samples alone did not determine them.
std::vector<std::pair<std::string, std::string>> reached_texts(const LongRenderRequest& request,
                                                               const renderer::RenderStatistics& statistics) {
  std::vector<std::pair<std::string, std::string>> texts;
  if (!request.time_limit && !request.target_noise) return texts;
  texts.emplace_back("alidade:samples_reached",
                     fmt::format("{} {:.17g} {}", statistics.least_samples, statistics.mean_samples,
                                 statistics.most_samples));
  if (statistics.noise) {
    texts.emplace_back("alidade:noise_reached", fmt::format("{} {}", error_text(statistics.noise->median, 17),
                                                            error_text(statistics.noise->worst, 17)));
  }
  return texts;
}

}  // namespace

std::filesystem::path written_file(const LongRenderRequest& request, const std::filesystem::path& image) {
  if (!request.part) return image;
  return image.string() + fmt::format(".part{}of{}", request.part->number, request.part->count);
}

void add_long_render_options(const Fields& render, LongRenderRequest& request) {
  const Field time_limit =
      render.number("--time-limit", "S",
                    "seconds per image: rendering stops then and reports the number of samples. At least one "
                    "sample per pixel, at most --samples. The bytes depend on the time",
                    request.time_limit, 0.0, k_most_seconds);
  const Field target_noise =
      render.number("--target-noise", "E",
                    "stop a tile of about 16x16 pixels at an estimated relative error of at most E, such as "
                    "0.02; a tile gets at least 32 samples and at most --samples",
                    request.target_noise, 1e-6, 1e6);
  const Field preview = render.value(
      "--preview", "FILE", "preview of the unfinished image, .png or .jpg, rewritten every few seconds",
      request.preview, std::identity());
  render.needs(preview).number("--preview-interval", "S", "seconds between previews (default 3)",
                               request.preview_interval, 0.0, k_most_seconds);
  render.needs(preview).count(
      "--preview-points", "N",
      "before COPC files of more than 2 N points are loaded, the preview shows N points, those the "
      "camera sees best, then 8 N and so on (default 300000; 0: only the image itself)",
      request.preview_points, 0, k_most_preview_points);
  add_checkpoint_fields(render, request.checkpoint, "rewritten every minute", "image");
  render.excludes(time_limit)
      .excludes(target_noise)
      .excludes(preview)
      .value(
          "--part", "I/N",
          "render part I of N, such as 3/20, for 'alidade merge': writes FILE.part3of20 instead of the image "
          "FILE. A part has every N-th tile of about 16x16 pixels",
          request.part, parse_part);
}

void check_long_render(const LongRenderRequest& request, Replaceable replaceable,
                       std::span<const std::filesystem::path> outputs,
                       std::span<const std::filesystem::path> inputs) {
  const auto check = [&](const std::filesystem::path& file, bool may_exist) {
    if (file.empty()) return;
    for (const std::filesystem::path& output : outputs) {
      if (same_file(file, output)) throw file_error(file, "two outputs have this name", "another name");
    }
    check_writable(file, may_exist, inputs);
  };
  if (!request.preview.empty()) {
    const std::optional<image::ImageFormat> format = image::image_format(request.preview);
    if (format != image::ImageFormat::png && format != image::ImageFormat::jpeg)
      throw file_error(request.preview, "unknown output format", "the extension .png, .jpg or .jpeg");
    if (!request.checkpoint.file.empty() && same_file(request.preview, request.checkpoint.file))
      throw file_error(request.preview, "preview and checkpoint have the same name");
  }
  std::error_code error;
  const bool keeps_checkpoint = std::filesystem::exists(request.checkpoint.file, error);
  if (keeps_checkpoint && !request.checkpoint.resume && !replaceable.any) {
    throw file_error(request.checkpoint.file, "the file exists",
                     "--resume to continue from it, or --overwrite");
  }
  check(request.preview,
        replaceable.any || (replaceable.earlier_preview && is_preview_of_ours(request.preview)));
  if (!replaceable.any) check_links(request.checkpoint.file);
  check(request.checkpoint.file, true);
  // Another file would be replaced, and removed in the end.
  if (keeps_checkpoint && !renderer::is_checkpoint(request.checkpoint.file)) {
    throw Error({.file = request.checkpoint.file.string(),
                 .location = "byte 0",
                 .problem = "not an Alidade checkpoint",
                 .expected = "a checkpoint, or the name of a file that does not exist"});
  }
}

std::optional<Resumption> find_resumption(const LongRenderRequest& request,
                                          std::span<const std::filesystem::path> images,
                                          std::span<const std::filesystem::path> finished,
                                          Verbosity verbosity) {
  if (!request.checkpoint.resume) return std::nullopt;
  const std::string file = request.checkpoint.file.string();
  std::error_code error;
  if (!std::filesystem::exists(request.checkpoint.file, error)) {
    say_note(verbosity, fmt::format("no checkpoint {}: starting from the beginning", file));
    return std::nullopt;
  }
  const renderer::CheckpointSummary summary = renderer::read_checkpoint_summary(request.checkpoint.file);
  const std::string image = images.front().string();
  if (summary.image == image_in_checkpoint(image)) {
    return Resumption{summary.samples_taken,
                      fmt::format("resuming from {}: {} has {:.0f} % of its samples after {}", file, image,
                                  100.0 * summary.share, clock_time(summary.seconds))};
  }
  if (!is_of_one_of(summary, finished)) {
    throw file_error(file, "the checkpoint belongs to another image", fmt::format("one of {}", image),
                     summary.image);
  }
  say_note(verbosity, fmt::format("{} belongs to {}, which is finished: starting from the beginning", file,
                                  summary.image));
  return std::nullopt;
}

renderer::RenderOptions render_options(const LongRenderRequest& request, const image::OutputSettings& output,
                                       bool resume, const renderer::ImageMetadata& metadata) {
  renderer::RenderOptions options;
  options.layers = image::image_format(output.file) == image::ImageFormat::exr
                       ? output.layers
                       : std::vector{image::Layer::color};
  options.time_limit = request.time_limit;
  options.target_noise = request.target_noise;
  options.part = request.part.value_or(renderer::ImagePart());
  if (!request.preview.empty()) {
    const auto file = std::make_shared<PreviewFile>(request.preview, output, metadata);
    options.preview = {.show = [file](const image::Film& film) { file->show(film); },
                       .interval = request.preview_interval};
  }
  if (!request.checkpoint.file.empty()) {
    options.checkpoint = {.file = request.checkpoint.file,
                          .interval = request.checkpoint.interval,
                          .resume = resume,
                          .image = image_in_checkpoint(output.file),
                          .failed = checkpoint_warning()};
  }
  return options;
}

std::optional<image::Film> render_to_file(const LongRenderRequest& request, const renderer::Scene& scene,
                                          const renderer::LoadedCloud* cloud,
                                          const renderer::RenderOptions& options,
                                          renderer::ImageMetadata metadata, bool overwrite,
                                          renderer::RenderStatistics& statistics) {
  if (request.part) {
    renderer::render_part(scene, cloud, options,
                          {written_file(request, scene.output.file), overwrite,
                           renderer::image_entries(scene.output, metadata)},
                          &statistics);
    return std::nullopt;
  }
  image::Film film = renderer::render(scene, cloud, options, &statistics);
  for (auto& text : reached_texts(request, statistics)) metadata.further.push_back(std::move(text));
  image::write_image(film, scene.output, renderer::image_facts(metadata, scene.output), overwrite);
  return film;
}

std::string describe_reached(const LongRenderRequest& request, const renderer::RenderStatistics& statistics) {
  if (!request.time_limit && !request.target_noise) return {};
  std::string text = fmt::format("samples per pixel: {} to {}, mean {:.1f}", statistics.least_samples,
                                 statistics.most_samples, statistics.mean_samples);
  if (statistics.noise) {
    text += fmt::format("; estimated error of a tile: median {}, worst {}",
                        error_text(statistics.noise->median, 2), error_text(statistics.noise->worst, 2));
  }
  const bool is_noisy = statistics.noisy_tiles > 0, is_hurried = statistics.hurried_tiles > 0;
  if (is_noisy) {
    text += fmt::format("; target not reached in {} of {} tiles: raise {}", statistics.noisy_tiles,
                        statistics.tiles, is_hurried ? "--time-limit" : "--samples");
  }
  if (request.time_limit && !is_hurried) {
    const bool by_target = request.target_noise && !is_noisy;
    text += fmt::format("; stopped by {}, not by time", by_target ? "--target-noise" : "--samples");
  }
  return text;
}

void warn_of_few_samples(const LongRenderRequest& request, int samples) {
  const std::uint32_t fewest = renderer::StopRule::k_fewest_samples;
  if (!request.target_noise || samples >= static_cast<int>(fewest)) return;
  say_warning(fmt::format("--target-noise tests tiles from {} samples on, but they get {}: raise --samples",
                          fewest, samples));
}

void remove_checkpoint(const LongRenderRequest& request) {
  std::error_code error;
  if (!request.checkpoint.file.empty()) std::filesystem::remove(request.checkpoint.file, error);
}

void remove_finished_checkpoint(const LongRenderRequest& request,
                                std::span<const std::filesystem::path> finished) {
  std::error_code error;
  if (!request.checkpoint.resume || !std::filesystem::exists(request.checkpoint.file, error)) return;
  if (is_of_one_of(renderer::read_checkpoint_summary(request.checkpoint.file), finished))
    remove_checkpoint(request);
}

}  // namespace alidade::tools
