// SPDX-License-Identifier: MIT
#include "jobs/render/depth_maps.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/input_file.h"
#include "base/output_file.h"
#include "base/shown_text.h"
#include "base/words.h"
#include "image/image_file.h"
#include "jobs/outputs.h"
#include "renderer/depth_tracer.h"

namespace alidade::jobs {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;  // keeps the order of keys

constexpr double k_least_scale = 1e-6, k_largest_scale = 1e9;

image::DepthFormat depth_format_of(const DepthRequest& request) {
  const image::DepthFormat by_name = image::depth_format(request.file);
  if (request.format.value_or(by_name) == by_name) return by_name;
  const auto& wanted = image::k_depth_formats[static_cast<std::size_t>(*request.format)];
  throw file_error(request.file, fmt::format("--depth-format {} and the extension disagree", wanted.name),
                   fmt::format("the extension {}", wanted.extensions.front()),
                   request.file.extension().string());
}

/// One name per view; one if there are no views yet.
std::vector<fs::path> map_names(const fs::path& pattern, const ViewsRequest& camera,
                                std::span<const camera::NamedCamera> views) {
  return camera.is_set() ? image_names(pattern, views) : std::vector{pattern};
}

/// The name; empty if the file exists and may stay.
fs::path due(const fs::path& file, ExistingFiles existing) {
  std::error_code error;
  return existing.skip && fs::exists(file, error) ? fs::path() : file;
}

/// The metadata of an image without the settings of light.
std::vector<std::pair<std::string, std::string>> depth_texts(const renderer::ImageMetadata& metadata,
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
void write_depth_transforms(const DepthTransforms& transforms, std::span<const camera::NamedCamera> views,
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

void add_depth_fields(const Fields& fields, DepthRequest& request) {
  const Field depth = fields.file(
      "--depth", "FILE",
      "depth map: .png (16 bit), .exr, .npy, .tif or .bin (COLMAP); 0 where there is no point. Without -o no "
      "image is rendered. For a set of cameras with %04d, %s or %f, as -o",
      request.file);
  const Fields more = fields.needs(depth);
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

DepthPlan plan_depth_maps(const DepthRequest& request, const ViewsRequest& camera,
                          std::span<const camera::NamedCamera> views, ExistingFiles existing,
                          std::span<const fs::path> inputs, std::span<const fs::path> outputs) {
  DepthPlan plan;
  if (request.file.empty()) return plan;
  plan.format = depth_format_of(request);
  plan.scale = request.scale.value_or(image::default_depth_scale(plan.format));
  plan.layer = request.layer;
  plan.overwrite = existing.overwrite;
  plan.files = map_names(request.file, camera, views);
  std::vector<fs::path> masks;
  if (!request.mask.empty()) {
    if (!has_extension(request.mask, {".png"}))
      throw file_error(request.mask, "unknown format of masks", "the extension .png");
    masks = map_names(request.mask, camera, views);
  }
  for (std::size_t i = 0; i < plan.files.size(); ++i) {
    const DepthMap map{i, due(plan.files[i], existing), masks.empty() ? fs::path() : due(masks[i], existing)};
    if (!map.file.empty() || !map.mask.empty()) plan.maps.push_back(map);
  }
  if (!request.transforms.empty()) {
    if (camera.file.empty() || !camera.names.empty())
      throw file_error(request.transforms, "--transforms-out requires all cameras of a transforms.json",
                       "--camera FILE without --camera-name");
    DepthTransforms transforms = read_depth_transforms(camera.file, request.transforms);
    if (!due(request.transforms, existing).empty()) plan.transforms = std::move(transforms);
  }
  std::vector<fs::path> names;
  for (const DepthMap& map : plan.maps) names.insert(names.end(), {map.file, map.mask});
  if (plan.transforms) names.push_back(plan.transforms->output);
  check_outputs(names, plan.overwrite, inputs, outputs);
  return plan;
}

void write_depth_maps(const DepthPlan& plan, std::span<const camera::NamedCamera> views,
                      const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                      const std::function<renderer::ImageMetadata(const camera::NamedCamera&)>& metadata,
                      EmptyViews& empty, Listener& listener) {
  const std::size_t count = plan.maps.size();
  if (count > 0) {
    const renderer::DepthTracer tracer(scene, cloud);
    std::uint64_t total = 0, done = 0;
    for (const DepthMap& map : plan.maps) {
      const camera::Camera& camera = views[map.view].camera;
      total += static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
    }
    const auto stage = listener.begin(
        count == 1 ? "tracing depth" : fmt::format("tracing depth of {} images", count), "rays");
    const Progress progress = stage->callback();
    image::DepthLoss loss;
    for (const DepthMap& map : plan.maps) {
      const image::Film film =
          tracer.trace(views[map.view].camera, plan.layer,
                       [&](std::uint64_t rays, std::uint64_t) { return progress(done + rays, total); });
      const std::vector<float>& depths = plan.layer == image::Layer::depth ? film.depth : film.distance;
      done += film.count();
      bool sees_anything = film.sees_anything();
      if (!map.file.empty()) {
        const std::vector<float> values = image::depth_values(depths, plan.format, plan.scale, loss);
        sees_anything = std::ranges::any_of(values, [](float depth) { return depth != 0.0f; });
        image::write_depth_map(values, film.width, film.height, plan.format,
                               depth_texts(metadata(views[map.view]), plan), map.file, plan.overwrite);
      }
      if (!map.mask.empty())
        image::write_depth_mask(depths, film.width, film.height, map.mask, plan.overwrite);
      empty.check(views[map.view], sees_anything);
    }
    stage->finish();
    warn_all(listener, warnings_about(loss, plan));
    const auto written = [](const DepthMap& map) {
      return (map.file.empty() ? map.mask : map.file).string();
    };
    listener.note(count == 1
                      ? fmt::format("wrote {}", written(plan.maps.front()))
                      : fmt::format("wrote {} to {}", written(plan.maps.front()), written(plan.maps.back())));
  }
  if (!plan.transforms) return;
  write_depth_transforms(*plan.transforms, views, plan.files, plan.overwrite);
  listener.note(fmt::format("wrote {}: depths are in units of {:g} m", plan.transforms->output.string(),
                            1.0 / plan.scale));
}

}  // namespace alidade::jobs
