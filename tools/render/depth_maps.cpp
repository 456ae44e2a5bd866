// SPDX-License-Identifier: MIT
#include "tools/render/depth_maps.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "base/input_file.h"
#include "base/output_file.h"
#include "base/shown_text.h"
#include "base/words.h"
#include "image/image_file.h"
#include "renderer/depth_tracer.h"

namespace alidade::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;  // keeps the order of keys

constexpr double k_least_scale = 1e-6, k_largest_scale = 1e9;

image::DepthFormat format_of(const DepthRequest& request) {
  const image::DepthFormat by_name = image::depth_format(request.file);
  if (request.format.value_or(by_name) == by_name) return by_name;
  const auto& wanted = image::k_depth_formats[static_cast<std::size_t>(*request.format)];
  throw file_error(request.file, fmt::format("--depth-format {} and the extension disagree", wanted.name),
                   fmt::format("the extension {}", wanted.extensions.front()),
                   request.file.extension().string());
}

/// One name per view; one if there are no views yet.
std::vector<fs::path> names_of(const fs::path& pattern, const CameraRequest& camera,
                               std::span<const View> views) {
  return is_set(camera) ? image_names(pattern, views) : std::vector{pattern};
}

/// The name; empty if the file exists and may stay.
fs::path due(const fs::path& file, ExistingFiles existing) {
  std::error_code error;
  return existing.skip && fs::exists(file, error) ? fs::path() : file;
}

/// Errors: two names are those of one file; as check_writable.
void check_names(const DepthPlan& plan, std::span<const fs::path> inputs, std::span<const fs::path> outputs) {
  std::set<fs::path> taken;
  const auto take = [&](const fs::path& file) {
    std::error_code error;
    return taken.insert(fs::weakly_canonical(fs::absolute(file, error), error)).second;
  };
  for (const fs::path& output : outputs)
    if (!output.empty()) take(output);
  std::vector<fs::path> names;
  for (const DepthJob& job : plan.jobs) {
    names.push_back(job.file);
    names.push_back(job.mask);
  }
  if (plan.transforms) names.push_back(plan.transforms->output);
  for (const fs::path& name : names) {
    if (name.empty()) continue;
    if (!take(name)) throw file_error(name, "two outputs have this name", "different names");
    check_writable(name, plan.overwrite, inputs);
  }
}

/// The metadata of an image without the settings of light.
std::vector<std::pair<std::string, std::string>> texts_of(const renderer::ImageMetadata& metadata,
                                                          const DepthPlan& plan) {
  auto texts = renderer::metadata_texts(metadata);
  std::erase_if(texts, [](const auto& text) {
    constexpr std::array<std::string_view, 5> light{"alidade:samples", "alidade:max_bounces", "alidade:seed",
                                                    "alidade:mode", "alidade:ao_distance"};
    return std::ranges::find(light, text.first) != light.end();
  });
  texts.emplace_back("alidade:depth", fmt::format("{}, {:.17g} units per metre, 0: none",
                                                  plan.layer == image::Layer::depth ? "along the optical axis"
                                                                                    : "along the ray",
                                                  plan.scale));
  return texts;
}

/// The largest number of three digits for which a depth fits into 16 bits.
double fitting_scale(double depth) {
  const double scale = image::k_largest_depth_code / depth;
  const double unit = std::pow(10.0, std::floor(std::log10(scale)) - 2.0);
  return std::floor(scale / unit) * unit;
}

std::vector<std::string> warnings_about(const image::DepthLoss& loss, const DepthPlan& plan) {
  std::vector<std::string> warnings;
  if (loss.too_far > 0) {
    warnings.push_back(fmt::format(
        "{} pixels are deeper than the {:.6g} m that 16 bits hold with --depth-scale {:g}, and are 0; the "
        "deepest, {:.6g} m, requires --depth-scale {:.3g} or another format",
        loss.too_far, image::k_largest_depth_code / plan.scale, plan.scale, loss.farthest,
        fitting_scale(loss.farthest)));
  }
  if (loss.behind > 0) {
    warnings.push_back(fmt::format(
        "{} pixels are 90 degrees or more off the optical axis, and are 0; they require --depth-along ray",
        loss.behind));
  }
  return warnings;
}

std::string photo_of(const Json& frame) {
  std::string name = frame.at("file_path").get<std::string>();
  std::ranges::replace(name, '\\', '/');
  return name;
}

fs::path folder_of(const fs::path& file) {
  return fs::weakly_canonical(fs::absolute(file).parent_path());
}

/// Empty unless the text is an object with frames that name photographs.
Json parse_transforms(const std::string& text) {
  Json top = Json::parse(text, nullptr, false);
  if (!top.is_object() || !top.contains("frames") || !top["frames"].is_array()) return {};
  for (const Json& frame : top["frames"])
    if (!frame.is_object() || !frame.contains("file_path") || !frame["file_path"].is_string()) return {};
  return top;
}

/// Reads the input. Errors: it is not a transforms.json; the output would be in another folder, but names of
/// photographs are relative to the input's.
DepthTransforms read_depth_transforms(const fs::path& input, const fs::path& output) {
  constexpr std::uintmax_t k_largest = 1u << 30;
  std::error_code error;
  DepthTransforms transforms{input, output, {}};
  if (!fs::is_directory(input, error)) transforms.text = read_text_file(input, k_largest);
  const Json top = parse_transforms(transforms.text);
  if (top.is_null())
    throw file_error(input, "--transforms-out requires the cameras of a transforms.json",
                     "a JSON file with \"frames\" and \"file_path\"");
  if (folder_of(input) == folder_of(output)) return transforms;
  for (const Json& frame : top["frames"]) {
    if (fs::path(photo_of(frame)).is_absolute()) continue;
    throw file_error(output, "photographs have names relative to the folder of " + input.string(),
                     "a file in that folder");
  }
  return transforms;
}

/// Writes the output: every frame gets `depth_file_path`, relative to the output's folder; all other keys and
/// their values stay, in their order. `files[i]` is the depth map of `views[i]`; the views are all frames.
/// The file is written completely or not at all. Errors: it exists and `overwrite` is false; write failures.
void write_depth_transforms(const DepthTransforms& transforms, std::span<const View> views,
                            std::span<const fs::path> files, bool overwrite) {
  assert(views.size() == files.size());
  const fs::path folder = folder_of(transforms.output);
  std::map<std::string, fs::path> depth_of;
  for (std::size_t i = 0; i < views.size(); ++i)
    depth_of[views[i].name] = (folder_of(files[i]) / files[i].filename()).lexically_relative(folder);
  Json top = parse_transforms(transforms.text);
  for (Json& frame : top["frames"]) frame["depth_file_path"] = depth_of.at(photo_of(frame)).generic_string();
  constexpr int k_indent = 2;
  write_text_file(transforms.output, json_text(top, k_indent) + "\n", overwrite);
}

}  // namespace

void add_depth_options(const Fields& render, DepthRequest& request) {
  const Field depth = render.file(
      "--depth", "FILE",
      "depth map: .png (16 bit), .exr, .npy, .tif or .bin (COLMAP); 0 where there is no point. Without -o no "
      "image is rendered. For a set of cameras with %04d, %s or %f, as -o",
      request.file);
  const Fields more = render.needs(depth);
  more.choice("--depth-format", "format, for a name with its extension (default: by the extension)",
              request.format,
              {{"exr", image::DepthFormat::exr},
               {"png16", image::DepthFormat::png16},
               {"npy", image::DepthFormat::npy},
               {"tiff", image::DepthFormat::tiff},
               {"colmap", image::DepthFormat::colmap}});
  more.number("--depth-scale", "N",
              "units per metre (default 1000 for .png, which holds up to 65.535 m then; 1 for all others)",
              request.scale, k_least_scale, k_largest_scale);
  more.choice("--depth-along", "depth along the optical axis (default), or distance along the ray",
              request.layer, {{"axis", image::Layer::depth}, {"ray", image::Layer::distance}});
  more.file("--depth-mask", "FILE.png", "image with 255 where the depth is that of a surface, 0 elsewhere",
            request.mask);
  more.file("--transforms-out", "FILE.json",
            "the transforms.json of --camera again, with the depth_file_path of each frame",
            request.transforms);
}

DepthPlan plan_depth_maps(const DepthRequest& request, const CameraRequest& camera,
                          std::span<const View> views, ExistingFiles existing,
                          std::span<const fs::path> inputs, std::span<const fs::path> outputs) {
  DepthPlan plan;
  if (request.file.empty()) return plan;
  plan.format = format_of(request);
  plan.scale = request.scale.value_or(image::default_depth_scale(plan.format));
  plan.layer = request.layer;
  plan.overwrite = existing.overwrite;
  plan.views.assign(views.begin(), views.end());
  plan.files = names_of(request.file, camera, views);
  std::vector<fs::path> masks;
  if (!request.mask.empty()) {
    if (!has_extension(request.mask, {".png"}))
      throw file_error(request.mask, "unknown format of masks", "the extension .png");
    masks = names_of(request.mask, camera, views);
  }
  for (std::size_t i = 0; i < plan.files.size(); ++i) {
    const DepthJob job{i < views.size() ? views[i] : View(), due(plan.files[i], existing),
                       masks.empty() ? fs::path() : due(masks[i], existing)};
    if (!job.file.empty() || !job.mask.empty()) plan.jobs.push_back(job);
  }
  if (!request.transforms.empty()) {
    if (!is_set(camera))
      throw file_error(request.transforms, "--transforms-out requires all cameras of a transforms.json",
                       "--camera FILE without --camera-name");
    DepthTransforms transforms = read_depth_transforms(camera.file, request.transforms);
    if (!due(request.transforms, existing).empty()) plan.transforms = std::move(transforms);
  }
  check_names(plan, inputs, outputs);
  return plan;
}

void warn_of_spheres(const renderer::Scene& scene, const renderer::LoadedCloud& cloud, Verbosity verbosity) {
  if (scene.cloud->shape != renderer::PointShape::sphere) return;
  say_warnings(verbosity, {fmt::format("spheres of radius {:.3g} m make depths too small, at grazing angles "
                                       "by several radii; --surface disc, without --radius, avoids this",
                                       cloud.radius)});
}

void write_depth_maps(const DepthPlan& plan, const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                      const std::function<renderer::ImageMetadata(const View&)>& metadata, EmptyViews& empty,
                      Verbosity verbosity) {
  const std::size_t count = plan.jobs.size();
  if (count > 0) {
    const renderer::DepthTracer tracer(scene, cloud);
    std::uint64_t total = 0, done = 0;
    for (const DepthJob& job : plan.jobs)
      total += static_cast<std::uint64_t>(job.view.camera.width) *
               static_cast<std::uint64_t>(job.view.camera.height);
    ProgressLine line(count == 1 ? "tracing depth" : fmt::format("tracing depth of {} images", count), "rays",
                      verbosity);
    const Progress progress = line.callback();
    image::DepthLoss loss;
    for (const DepthJob& job : plan.jobs) {
      const image::Film film =
          tracer.trace(job.view.camera, plan.layer,
                       [&](std::uint64_t rays, std::uint64_t) { return progress(done + rays, total); });
      const std::vector<float>& depths = plan.layer == image::Layer::depth ? film.depth : film.distance;
      done += film.count();
      bool sees_anything = film.sees_anything();
      if (!job.file.empty()) {
        const std::vector<float> values = image::depth_values(depths, plan.format, plan.scale, loss);
        sees_anything = std::ranges::any_of(values, [](float depth) { return depth != 0.0f; });
        image::write_depth_map(values, film.width, film.height, plan.format,
                               texts_of(metadata(job.view), plan), job.file, plan.overwrite);
      }
      if (!job.mask.empty())
        image::write_depth_mask(depths, film.width, film.height, job.mask, plan.overwrite);
      empty.check(job.view, sees_anything);
    }
    line.finish();
    say_warnings(verbosity, warnings_about(loss, plan));
    const auto written = [](const DepthJob& job) {
      return (job.file.empty() ? job.mask : job.file).string();
    };
    say_note(verbosity, count == 1 ? fmt::format("wrote {}", written(plan.jobs.front()))
                                   : fmt::format("wrote {} to {}", written(plan.jobs.front()),
                                                 written(plan.jobs.back())));
  }
  if (!plan.transforms) return;
  write_depth_transforms(*plan.transforms, plan.views, plan.files, plan.overwrite);
  say_note(verbosity, fmt::format("wrote {}: depths are in units of {:g} m", plan.transforms->output.string(),
                                  1.0 / plan.scale));
}

}  // namespace alidade::tools
