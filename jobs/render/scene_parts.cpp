// SPDX-License-Identifier: MIT
#include "jobs/render/scene_parts.h"

#include <fmt/format.h>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "base/error.h"
#include "geo/sun.h"
#include "image/color_points.h"
#include "image/legend.h"
#include "image/read_image.h"
#include "jobs/cloud_formats.h"
#include "jobs/load_cloud.h"
#include "jobs/mesh_files.h"
#include "jobs/outputs.h"
#include "mesh/triangle_tree.h"
#include "renderer/cloud_in_view.h"
#include "renderer/integrator.h"

namespace alidade::jobs {
namespace {

std::string radius_text(const renderer::CloudSettings& settings, const renderer::LoadedCloud& cloud) {
  if (settings.shape != renderer::PointShape::sphere) {
    return fmt::format("discs of radius {:.4g} times the distance to neighbour 8, at most {:.4g}",
                       cloud.spacing_factor, cloud.radius);
  }
  if (settings.adapted_radius) {
    return fmt::format("spheres of radius {:.4g} times the distance to neighbour {}, at most {:.4g}",
                       cloud.spacing_factor, settings.adapted_radius->neighbours, cloud.radius);
  }
  return fmt::format("spheres of radius {:.4g}{}", cloud.radius,
                     settings.radius ? "" : " (from the spacing of the points)");
}

/// A warning if all values that a cloud is coloured by are equal; empty if they differ.
std::string remark_on_colors(const image::ColorKey& key) {
  const std::uint64_t count = key.point_count - key.missing_count;
  if (count == 0) return "";
  if (key.scale && key.scale->extent.low == key.scale->extent.high)
    return fmt::format("--color-by {}: all values are {:g}", key.word, key.scale->extent.low);
  const bool is_one = !key.scale && key.swatches.size() == 1 && key.swatches.front().count;
  return is_one ? fmt::format("--color-by {}: all values are {}", key.word,
                              key.swatches.front().number.empty() ? key.swatches.front().label
                                                                  : key.swatches.front().number)
                : "";
}

/// One filter per view; points further from its half-spaces than their radius are not seen.
std::vector<database::PointFilter> view_filters(std::span<const camera::NamedCamera> views, double radius) {
  std::vector<database::PointFilter> filters;
  for (const camera::NamedCamera& view : views) {
    database::PointFilter& filter = filters.emplace_back();
    for (const Plane& plane : renderer::view_planes(view.camera).planes)
      filter.planes.push_back({plane, {-radius, std::numeric_limits<double>::infinity()}});
  }
  return filters;
}

/// The part of a cloud in a database that the cameras see, without radii: points whose spheres, as far as
/// their radius is given, may be in an image. Notes how much was read. Errors: those of the database.
renderer::LoadedCloud load_in_view(const RenderPlan& plan, Listener& listener) {
  const renderer::CloudSettings& settings = *plan.request().scene.cloud;
  const CloudInput& input = plan.request().files.inputs.front();
  const char* const unit = part_unit(input);
  database::CloudPart part =
      in_stage(listener, fmt::format("loading {} in view", unit), unit, [&](const Progress& progress) {
        return read_database_part(input, view_filters(plan.views, settings.radius.value_or(0.0)),
                                  image::attributes_for(settings.color), progress);
      });
  if (part.chunk_count > 0)
    listener.note(fmt::format("read {} of {} chunks of {}", part.chunks_read, part.chunk_count,
                              public_name(input.name.string())));
  return renderer::index_cloud(std::move(part.cloud), part.attributes, settings, input.name.string());
}

void place_sun_by_time(renderer::Scene& scene, const renderer::LoadedCloud* cloud, Listener& listener) {
  std::optional<geo::SceneMap> map;
  if (cloud != nullptr && cloud->octree.size() > 0)
    map = geo::SceneMap{cloud->crs, glm::dvec2(renderer::visible_bounds(*cloud).center())};
  const geo::PlacedSun placed = geo::place_sun(*scene.sun_by_time, map);
  scene.sun_origin = geo::describe(*scene.sun_by_time, placed);
  scene.sun_by_time.reset();
  if (placed.is_up) scene.sun = placed.sun;
  listener.note(scene.sun_origin);
  if (!placed.is_up)
    listener.warn(fmt::format("the sun is below the horizon, at elevation {:.3f} degrees: it gives no light",
                              placed.sun.elevation));
}

}  // namespace

void load_meshes(renderer::Scene& scene, Listener& listener) {
  for (renderer::Object& object : scene.objects) {
    auto* const model = std::get_if<renderer::Model>(&object);
    if (model == nullptr || !model->mesh) continue;
    const renderer::MeshFile& source = *model->mesh;
    TriangleMesh mesh = load_mesh(source.file, source.placement, listener);
    model->name = fmt::format("{} {:016x}", kept_name(source.file), checksum(mesh));
    model->surfaces = sort_triangles(listener, [&](const Progress& progress) {
      return std::make_shared<TriangleTree>(std::move(mesh), progress);
    });
  }
}

void load_sky(renderer::Scene& scene, const std::filesystem::path& scene_file, Listener& listener) {
  if (scene.render.mode == renderer::RenderMode::flat) scene.sky = renderer::ConstantSky{};
  auto* const sky = std::get_if<renderer::ImageSky>(&scene.sky);
  if (sky == nullptr) return;
  image::SkyPixels pixels;
  try {
    pixels = image::read_sky_image(sky->file);
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    parts.problem += fmt::format(" (at /sky/file of {})", scene_file.string());
    throw Error(parts);
  }
  if (!pixels.warning.empty()) listener.warn(pixels.warning);
  listener.note(fmt::format("sky from {}, {} x {} pixels", sky->file.string(), pixels.width, pixels.height));
  sky->image = std::make_shared<renderer::SkyImage>(std::move(pixels), sky->scale, sky->rotation);
}

renderer::LoadedCloud load_scene_cloud(const RenderPlan& plan, Listener& listener) {
  const renderer::CloudSettings& settings = *plan.request().scene.cloud;
  const CloudInputs& files = plan.request().files;
  std::unique_ptr<Listener::Stage> loading, measuring;
  const Progress measure = [&](std::uint64_t done, std::uint64_t total) {
    if (!measuring) {
      if (loading) loading->finish();
      loading.reset();
      measuring = listener.begin("measuring spacings", "points");
    }
    return measuring->callback()(done, total);
  };
  renderer::LoadedCloud cloud;
  if (plan.request().in_view) {
    cloud = load_in_view(plan, listener);
    renderer::choose_radius(settings, cloud, measure);
  } else {
    loading = listener.begin("loading cloud", "B");
    cloud = renderer::load_cloud(settings, files, loading->callback(), measure);
  }
  if (measuring) measuring->finish();
  if (loading) loading->finish();
  warn_all(listener, cloud.warnings);
  check_map_unit(cloud.crs, files);
  const std::string color = cloud.color.by == image::PointColor::rgb ? "rgb" : cloud.color.word;
  listener.note(
      fmt::format("{} points, coloured by {}, {}", cloud.octree.size(), color, radius_text(settings, cloud)));
  if (const std::string remark = remark_on_colors(cloud.color); !remark.empty()) listener.warn(remark);
  if (cloud.color.scale) listener.note(cloud.color.word + ": " + image::scale_text(cloud.color));
  return cloud;
}

void complete_light(renderer::Scene& scene, const renderer::LoadedCloud* cloud, Listener& listener) {
  if (scene.render.mode != renderer::RenderMode::path) scene.sun_by_time.reset();
  if (scene.sun_by_time) place_sun_by_time(scene, cloud, listener);
  if (scene.render.mode != renderer::RenderMode::ambient_occlusion) return;
  const bool is_given = scene.render.ao_distance.has_value();
  const double distance = renderer::ambient_occlusion_distance(scene.render, cloud);
  scene.render.ao_distance = distance;
  if (is_given) return;
  listener.note(std::isinf(distance)
                    ? "ambient occlusion at any distance (there is no cloud to set the range)"
                    : fmt::format("ambient occlusion within {:.4g} (from the size of the cloud)", distance));
}

}  // namespace alidade::jobs
