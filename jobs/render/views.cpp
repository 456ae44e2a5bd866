// SPDX-License-Identifier: MIT
#include "jobs/render/views.h"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <variant>

#include "base/error.h"
#include "renderer/overview.h"
#include "visibility/photo_frame.h"

namespace alidade::jobs {
namespace {

constexpr double k_largest_coordinate = 1e12;

template <std::size_t count>
std::array<double, count> parse_coordinates(const std::string& text) {
  const auto words = split_list(text, count, fmt::format("{} numbers separated by commas", count));
  std::array<double, count> numbers{};
  for (std::size_t i = 0; i < count; ++i)
    numbers[i] = parse_number(words[i], -k_largest_coordinate, k_largest_coordinate);
  return numbers;
}

/// A parsed pattern: text, one field, text.
struct Pattern {
  std::string before, after;
  enum class Field { none, number, name, full_name } field = Field::none;
  std::size_t width = 0;
};

[[noreturn]] void fail(const std::filesystem::path& pattern, const std::string& problem) {
  throw file_error(pattern, problem,
                   "one %04d (number), %s or %f (name) in the output name, such as out_%04d.png");
}

Pattern take_apart(const std::filesystem::path& file) {
  constexpr std::size_t k_largest_width = 9;
  Pattern pattern;
  const std::string text = file.string();
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& part = pattern.field != Pattern::Field::none ? pattern.after : pattern.before;
    if (text[i] != '%') {
      part += text[i];
    } else if (text.compare(i, 2, "%%") == 0) {
      part += text[++i];
    } else {
      if (pattern.field != Pattern::Field::none) fail(file, "several numbers or names");
      std::size_t end = i + 1;
      for (; end < text.size() && text[end] >= '0' && text[end] <= '9' && pattern.width <= k_largest_width;
           ++end)
        pattern.width = 10 * pattern.width + static_cast<std::size_t>(text[end] - '0');
      const char kind = end < text.size() ? text[end] : ' ';
      const bool is_plain = end == i + 1;
      if (kind == 'd' && pattern.width <= k_largest_width)
        pattern.field = Pattern::Field::number;
      else if (is_plain && kind == 's')
        pattern.field = Pattern::Field::name;
      else if (is_plain && kind == 'f')
        pattern.field = Pattern::Field::full_name;
      else
        fail(file, "invalid percent sign");
      i = end;
    }
  }
  return pattern;
}

std::string file_name_of(const std::string& name) {
  const std::size_t folder = name.find_last_of('/') + 1, dot = name.find_last_of('.');
  // A dot at the very beginning of a file's name begins no extension.
  const bool has_extension = dot != std::string::npos && dot > folder;
  std::string result = has_extension ? name.substr(0, dot) : name;
  // Else images of ./images/a.jpg are hidden files.
  if (result.starts_with("./")) result.erase(0, 2);
  for (char& c : result) {
    const bool fine = static_cast<unsigned char>(c) >= 0x20 && c != '/' && c != '\\' && c != ':' && c != 0x7F;
    if (!fine) c = '_';
  }
  return result;
}

/// The name with its folders and extension. Errors: it would lead out of the folder of the output.
std::string full_name_of(const std::string& name, const std::filesystem::path& pattern) {
  const std::filesystem::path path = std::filesystem::path(name).lexically_normal();
  if (path.is_absolute() || path.empty() || !path.has_filename() || *path.begin() == "..")
    fail(pattern, fmt::format("the name of camera '{}' leads out of the folder of the output", name));
  return path.generic_string();
}

/// The bounds of the meshes and other models of a scene.
Bounds model_bounds(const renderer::Scene& scene) {
  Bounds models;
  for (const renderer::Object& object : scene.objects)
    if (const auto* model = std::get_if<renderer::Model>(&object)) models.grow(model->surfaces->bounds());
  return models;
}

/// "camera 'a.jpg' sees nothing", "2 cameras see nothing: 'a.jpg', 'b.jpg'".
std::string text_of(std::span<const std::string> names) {
  if (names.size() == 1 && names.front().empty()) return "the camera sees nothing";
  if (names.size() == 1) return fmt::format("camera '{}' sees nothing", names.front());
  return fmt::format("{} cameras see nothing: {}", names.size(), some_names(names));
}

/// The reason if it is known; else empty.
std::string reason_of(std::vector<camera::NamedCamera> views, const Octree& octree) {
  std::erase_if(views, [](const camera::NamedCamera& view) {
    return std::holds_alternative<camera::OrthographicLens>(view.camera.lens);
  });
  if (views.empty() || octree.size() == 0) return "";
  try {
    visibility::check_photos(octree, views);
  } catch (const Error& error) {
    return error.what();
  }
  return "the frame contains points, but no pixel shows one";
}

}  // namespace

void add_views_fields(const Fields& fields, ViewsRequest& request) {
  const Field camera = fields.file("--camera", "FILE|FOLDER",
                                   "cameras instead of the scene's: " + k_camera_files, request.file);
  fields.needs(camera).text("--camera-name", "NAME",
                            "only this camera, by the name of its photograph; repeatable (default: all)",
                            request.names);
  add_camera_reading(fields.needs(camera), " (default: the scene's camera)", request);
  fields.number("--near", "METRES",
                "do not show points nearer to the camera, such as the camera positions that some "
                "photogrammetry writes into its clouds (default: the camera's, else 0)",
                request.near, 0.0, 1e9);
  const Field panorama = fields.excludes(camera).value(
      "--panorama", "X,Y,Z", "panorama around a position, north in the centre (default size 2048x1024)",
      [&request](const std::string& text) {
        const auto position = parse_coordinates<3>(text);
        request.panorama.emplace(position[0], position[1], position[2]);
      });
  const Field above = fields.excludes(camera).excludes(panorama).choice(
      "--orthographic", "orthophoto with parallel vertical rays, north up; .tif gives a GeoTIFF",
      request.from_above, {{"top", true}});
  fields.excludes(above).value(
      "--size", "WxH",
      "width and height in pixels, at most 2^28 in total (default: the camera's, else 1200x800)",
      request.size, parse_image_size);
  above.needs(fields.needs(above).number("--resolution", "METRES",
                                         "size of a pixel in metres, for --orthographic", request.resolution,
                                         1e-6, 1e6));
  fields.needs(above).value("--extent", "X,Y,X,Y", "bounds of the orthophoto (default: the whole cloud)",
                            request.extent, parse_coordinates<4>);
}

std::vector<camera::NamedCamera> requested_views(const ViewsRequest& request,
                                                 const std::optional<camera::Camera>& of_scene,
                                                 std::vector<std::string>& warnings) {
  if (request.from_above && !request.resolution)
    throw input_error("--orthographic requires --resolution", "--resolution METRES", "none");
  if (const auto& extent = request.extent;
      extent && !((*extent)[0] < (*extent)[2] && (*extent)[1] < (*extent)[3]))
    throw input_error("empty --extent", "min x, min y, max x, max y");
  std::vector<camera::NamedCamera> views;
  if (!request.file.empty()) {
    camera::CameraSet set = read_camera_file(request, of_scene);
    warnings = std::move(set.warnings);
    views = std::move(set.cameras);
  } else if (request.panorama) {
    const ImageSize size = request.size.value_or(ImageSize{2048, 1024});
    views.push_back({"", camera::panorama_camera(*request.panorama, size.width, size.height)});
  } else if (of_scene && !request.from_above) {
    views.push_back({"", *of_scene});
  }
  for (camera::NamedCamera& view : views) {
    if (request.size) view.camera = camera::resized(view.camera, request.size->width, request.size->height);
    if (request.near) view.camera.near = *request.near;
  }
  return views;
}

Bounds seen_bounds(const renderer::Scene& scene, const renderer::LoadedCloud* cloud,
                   const std::filesystem::path& scene_file) {
  const Bounds models = model_bounds(scene);
  if (cloud == nullptr && models.empty())
    throw file_error(scene_file, "the scene has neither a camera nor a cloud");
  if (cloud != nullptr && cloud->octree.size() == 0) {
    // The file on the command line, which for an index file is not the one that its points came from.
    throw file_error(scene.cloud->files.front(), "the cloud has no points for a default view",
                     "--camera FILE");
  }
  Bounds seen = cloud != nullptr ? renderer::visible_bounds(*cloud) : models;
  // A mesh elsewhere would make the cloud a speck.
  if (meet(seen, models)) seen.grow(models);
  return seen;
}

camera::NamedCamera view_of_cloud(const ViewsRequest& request, const renderer::Scene& scene,
                                  const renderer::LoadedCloud* cloud,
                                  const std::filesystem::path& scene_file) {
  const Bounds seen = seen_bounds(scene, cloud, scene_file);
  if (!request.from_above) {
    const ImageSize size = request.size.value_or(k_overview_size);
    if (cloud == nullptr || meet(seen, model_bounds(scene)))
      return {"", camera::overview_camera(seen, size.width, size.height)};
    return {"", renderer::overview_camera(*cloud, size.width, size.height)};
  }
  Bounds bounds = model_bounds(scene);
  if (cloud != nullptr) {
    bounds = cloud->octree.bounds();
    // Discs end near the last points, however wide the widest may be.
    const double beyond = cloud->lone_radius > 0.0 ? cloud->lone_radius : cloud->radius;
    bounds.min -= glm::dvec3(beyond);
    bounds.max += glm::dvec3(beyond);
  }
  if (request.extent) {
    const auto& [least_x, least_y, largest_x, largest_y] = *request.extent;
    bounds = {{least_x, least_y, bounds.min.z}, {largest_x, largest_y, bounds.max.z}};
  }
  for (const renderer::Object& object : scene.objects) {
    // What is above the cloud is seen from above, too.
    if (const auto* sphere = std::get_if<renderer::Sphere>(&object))
      bounds.max.z = std::max(bounds.max.z, sphere->center.z + sphere->radius);
  }
  return {"", camera::orthophoto_camera(bounds, *request.resolution)};
}

std::vector<std::filesystem::path> image_names(const std::filesystem::path& pattern,
                                               std::span<const camera::NamedCamera> views) {
  const Pattern parts = take_apart(pattern);
  if (parts.field == Pattern::Field::none && views.size() > 1)
    fail(pattern,
         fmt::format("{} cameras, but one output name (--camera-name selects one camera)", views.size()));
  std::vector<std::filesystem::path> names;
  std::map<std::filesystem::path, std::string> taken;
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::string field;
    if (parts.field == Pattern::Field::number) field = fmt::format("{:0{}}", i, parts.width);
    if (parts.field == Pattern::Field::name) field = file_name_of(views[i].name);
    if (parts.field == Pattern::Field::full_name) field = full_name_of(views[i].name, pattern);
    names.emplace_back(parts.before + field + parts.after);
    const auto [earlier, is_new] = taken.emplace(names.back(), views[i].name);
    if (!is_new) {
      fail(pattern, fmt::format("cameras '{}' and '{}' have the same output {}", earlier->second,
                                views[i].name, names.back().string()));
    }
  }
  return names;
}

void EmptyViews::check(const camera::NamedCamera& view, bool sees_anything) {
  const bool is_known = std::ranges::find(views_, view.name, &camera::NamedCamera::name) != views_.end();
  if (!is_known && !sees_anything) views_.push_back(view);
}

std::vector<std::string> EmptyViews::names() const {
  std::vector<std::string> names;
  for (const camera::NamedCamera& view : views_) names.push_back(view.name);
  return names;
}

void EmptyViews::report(const ViewsRequest& request, const renderer::LoadedCloud* cloud,
                        Listener& listener) const {
  if (views_.empty()) return;
  const std::string text = request.extent ? "--extent contains no points of the cloud" : text_of(names());
  const std::string reason = cloud != nullptr ? reason_of(views_, cloud->octree) : "";
  listener.warn(reason.empty() ? text : text + "; " + reason);
}

}  // namespace alidade::jobs
