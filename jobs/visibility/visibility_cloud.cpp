// SPDX-License-Identifier: MIT
#include "jobs/visibility/visibility_cloud.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "base/words.h"
#include "cloud/input_view.h"
#include "geo/raster_file.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/mesh_files.h"
#include "surface/point_surface.h"

namespace alidade::jobs {
namespace {

/// Appends a mesh, without its colours, to `all`. Errors: too many vertices or triangles, naming its file.
void join(TriangleMesh mesh, const std::filesystem::path& file, TriangleMesh& all) {
  constexpr std::size_t k_most = std::numeric_limits<std::uint32_t>::max();
  if (all.triangles.empty()) {
    all.vertices = std::move(mesh.vertices);
    all.triangles = std::move(mesh.triangles);
    return;
  }
  if (mesh.vertices.size() > k_most - all.vertices.size() ||
      mesh.triangles.size() > k_most - all.triangles.size())
    throw file_error(file, "too many vertices or triangles in all meshes", fmt::format("at most {}", k_most));
  const auto first = static_cast<std::uint32_t>(all.vertices.size());
  all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const auto& [a, b, c] : mesh.triangles) all.triangles.push_back({first + a, first + b, first + c});
}

BlockingMesh load_blocking_mesh(const std::vector<std::filesystem::path>& files, Listener& listener) {
  if (files.empty()) return {};
  TriangleMesh all;
  for (const std::filesystem::path& file : files) join(load_mesh(file, {}, listener), file, all);
  const std::uint64_t sum = checksum(all);
  return {sort_triangles(listener,
                         [&](const Progress& progress) {
                           return std::make_shared<const TriangleTree>(std::move(all), progress);
                         }),
          sum};
}

BlockingTerrain terrain_of(geo::HeightRaster raster, const std::filesystem::path& file, Listener& listener) {
  const geo::RasterGrid grid = raster.heights.grid;
  const double layout[] = {grid.north_west.x, grid.north_west.y, grid.cell_size,
                           static_cast<double>(grid.columns), static_cast<double>(grid.rows)};
  const std::uint64_t sums[] = {checksum(std::as_bytes(std::span(raster.heights.values))),
                                checksum(std::as_bytes(std::span(layout)))};
  auto surface = std::make_shared<const geo::TerrainSurface>(std::move(raster.heights));
  if (surface->patch_count() == 0) {
    throw file_error(file, "the raster has no surface", "heights in 2 x 2 neighbouring cells",
                     fmt::format("{} x {} cells", grid.columns, grid.rows));
  }
  listener.note(fmt::format("terrain of {} x {} cells of {:g}, {:g} to {:g} high, from {}", grid.columns,
                            grid.rows, grid.cell_size, surface->bounds().min.z, surface->bounds().max.z,
                            file.string()));
  return {std::move(surface), checksum(std::as_bytes(std::span(sums)))};
}

geo::HeightRaster read_heights(const std::filesystem::path& file, Listener& listener) {
  geo::HeightRaster raster = in_stage(listener, "reading raster", "cells", [&](const Progress& progress) {
    return geo::read_heights(file, progress);
  });
  if (!raster.heights_note.empty()) listener.warn(file.string() + ": " + raster.heights_note);
  return raster;
}

/// Whether the input is a raster instead of a cloud. A file with an extension of text is a cloud: to load
/// GDAL takes longer than to read a small text.
bool is_raster_alone(const CloudInputs& files) {
  if (files.size() != 1) return false;
  const CloudInput& input = files.inputs.front();
  const bool may_be_text =
      input.is(k_text_format) && !has_extension(input.name, {".csv", ".txt", ".xyz", ".pts"});
  std::error_code error;
  return (input.format == nullptr || may_be_text) && std::filesystem::is_regular_file(input.name, error) &&
         geo::is_raster(input.name);
}

/// Loads a raster as terrain, without points.
void load_raster_alone(const VisibilityRequest& request, AcceptedInput accepted, VisibilityCloud& loaded,
                       Listener& listener) {
  const CloudInput& input = request.files.inputs.front();
  const std::filesystem::path& file = input.name;
  if (input.is_changed() ||
      (input.view != nullptr && (input.view->height_unit || !input.view->columns.empty())))
    throw file_error(file, "options that select or convert points do not apply to a raster",
                     "a raster that gdalwarp crops and reprojects; a unit of heights by gdal_edit.py -units");
  if (accepted == AcceptedInput::points) {
    throw file_error(file, "a raster has no points, which this result requires",
                     "a point cloud, and the raster as --terrain");
  }
  if (!request.occluders.terrain.empty()) {
    throw file_error(request.occluders.terrain, "a second raster beside " + file.string(),
                     "one raster: join several with gdalbuildvrt");
  }
  geo::HeightRaster raster = read_heights(file, listener);
  PointCloud none;
  none.crs = raster.crs;
  loaded.terrain = terrain_of(std::move(raster), file, listener);
  loaded.cloud.octree = build(none);
  loaded.cloud.cloud = std::move(none);
}

/// The octree with all that occluders would measure themselves, in steps that show their progress.
Octree measured(Octree octree, const visibility::OccluderOptions& options, Listener& listener) {
  if (octree.size() == 0) return octree;
  const bool needs_surfaces = options.shape != visibility::OccluderShape::sphere;
  const bool needs_spacings = needs_surfaces || !options.radius;
  if (needs_spacings && octree.layers().spacing_neighbours != k_surface_neighbours)
    octree = with_spacings(octree, k_surface_neighbours, listener);
  if (needs_surfaces && octree.layers().surfaces == nullptr) octree = with_surfaces(octree, listener);
  return octree;
}

std::string class_list(const std::bitset<256>& classes) {
  std::string list;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes.test(i)) list += fmt::format("{}{}", list.empty() ? "" : ", ", i);
  }
  return list;
}

std::string description_of(const visibility::Occluders& occluders, const OccluderRequest& request) {
  const visibility::OccluderOptions& options = occluders.options();
  const bool has_points = occluders.octree().size() > 0;
  std::string text = !has_points ? "no points"
                     : options.shape == visibility::OccluderShape::automatic
                         ? "discs block, and spheres of points without surface"
                     : options.shape == visibility::OccluderShape::disc
                         ? "discs block, points without surface do not"
                         : "spheres block";
  if (has_points)
    text += options.radius
                ? fmt::format("; radius {}", *options.radius)
                : fmt::format("; radii up to {:.3g}",
                              std::min(occluders.largest_radius(), options.radius_max.value_or(INFINITY)));
  if (options.transparency > 1) text += fmt::format("; at {} crossings", options.transparency);
  if (options.mesh != nullptr) text += fmt::format("; {} triangles", options.mesh->triangle_count());
  if (options.terrain != nullptr) {
    const geo::RasterGrid& grid = options.terrain->heights().grid;
    text += fmt::format("; terrain of {} x {} cells of {:g}", grid.columns, grid.rows, grid.cell_size);
  }
  if (options.counts) text += fmt::format("; without classes {}", class_list(request.ignored_classes));
  return text;
}

}  // namespace

void add_occluder_fields(const Fields& fields, OccluderRequest& request) {
  const Fields group = fields.group("What blocks");
  group.choice("--occluder",
               "what blocks (default auto): a disc on the surface of each point, a sphere, or discs where "
               "there is a surface and spheres elsewhere (foliage, wires)",
               request.options.shape,
               {{"auto", visibility::OccluderShape::automatic},
                {"disc", visibility::OccluderShape::disc},
                {"sphere", visibility::OccluderShape::sphere}});
  const Field radius = group.number(
      "--radius", "R",
      "of discs and spheres, in metres (default: per point, from the distance to its neighbours)",
      request.options.radius, 1e-6, 1e6);
  group.excludes(radius).number(
      "--radius-max", "R",
      "no disc or sphere is wider than this, in metres (default: 16 times the automatic radius of spheres)",
      request.options.radius_max, 1e-6, 1e6);
  group.count("--transparency", "K",
              "block a line at this number of separate crossings (default: 1); more looks through foliage",
              request.options.transparency, 1, 1000);
  add_mesh_field(group, "that block at their first crossing",
                 [&request](const std::string& file) { request.meshes.emplace_back(file); });
  group.file(
      "--terrain", "FILE",
      "elevation raster (GeoTIFF or another format of GDAL) in the reference system of the cloud, whose "
      "bilinear surface blocks; the ground is the higher of its heights and the points' ground",
      request.terrain);
  add_ignored_classes(group, "do not block", request.ignored_classes);
}

void add_ignored_classes(const Fields& fields, const std::string& effect, std::bitset<256>& classes) {
  fields.value(
      "--ignore-classes", "LIST|none", "points of these classes " + effect + " (default: 7,18, noise)",
      classes,
      [](const std::string& text) { return text == "none" ? std::bitset<256>() : parse_classes(text); });
}

PlannedWork VisibilityRequest::work(std::initializer_list<std::filesystem::path> reads,
                                    std::initializer_list<std::filesystem::path> writes) const {
  // Points with their octree, spacings and surfaces; those in scratch files take memory of that size only.
  PlannedWork work{.clouds = files,
                   .partial = partial,
                   .reads = occluders.meshes,
                   .writes = {output},
                   .bytes_per_point = memory ? 0.0 : 45.0};
  if (is_raster_alone(files)) {
    work.reads.push_back(files.first_name());
    work.clouds = {};
    work.bytes_per_point = 0.0;
  }
  work.reads.push_back(occluders.terrain);
  work.reads.insert(work.reads.end(), reads);
  work.writes.insert(work.writes.end(), writes);
  return work;
}

std::unique_ptr<VisibilityCloud> load_cloud_alone(const VisibilityRequest& request, AttributeSet attributes,
                                                  AcceptedInput accepted, Listener& listener) {
  auto loaded = std::make_unique<VisibilityCloud>();
  loaded->mesh = load_blocking_mesh(request.occluders.meshes, listener);
  if (is_raster_alone(request.files)) {
    load_raster_alone(request, accepted, *loaded, listener);
    loaded->columns = loaded->cloud.columns();
    return loaded;
  }
  const std::filesystem::path& terrain = request.occluders.terrain;
  Crs terrain_crs;
  if (!terrain.empty()) {
    geo::HeightRaster raster = read_heights(terrain, listener);
    terrain_crs = raster.crs;
    loaded->terrain = terrain_of(std::move(raster), terrain, listener);
  }
  loaded->cloud = load_cloud(request.files, request.partial,
                             {.read = {.attributes = attributes | Attribute::classification},
                              .scratch = scratch_beside(request.output, request.memory)},
                             listener);
  if (loaded->cloud.octree.size() == 0)
    throw file_error(request.files.first_name(), "the cloud has no points");
  check_map_unit(loaded->cloud.cloud.crs, request.files);
  const Crs& crs = loaded->cloud.cloud.crs;
  if (!terrain_crs.empty() && !crs.empty())
    check_same_system(
        {terrain_crs, terrain.string()}, {crs, "the cloud"},
        file_error(terrain, "the raster is in another reference system than the cloud",
                   crs_name(crs) + ": reproject the raster with gdalwarp -t_srs", crs_name(terrain_crs)),
        listener);
  loaded->columns = loaded->cloud.columns();
  return loaded;
}

void check_same_system(const NamedSystem& one, const NamedSystem& other, const Error& different,
                       Listener& listener) {
  const CrsAgreement agreement = compare_crs(one.crs, other.crs);
  if (agreement == CrsAgreement::different) throw different;
  if (agreement == CrsAgreement::unknown)
    listener.warn(fmt::format("{} is in {}, {} in {}; both are assumed to be the same", one.name,
                              crs_name(one.crs), other.name, crs_name(other.crs)));
}

visibility::Occluders measured_occluders(const Octree& octree, std::span<const std::uint8_t> classes,
                                         const std::bitset<256>& ignored, visibility::OccluderOptions options,
                                         Listener& listener) {
  options.is_given_up = [&listener] { return listener.stops(); };
  // Testing the class of every point takes time, so there is no test if no point has such a class.
  if (std::ranges::any_of(classes, [&](std::uint8_t kind) { return ignored.test(kind); }))
    options.counts = [classes, ignored](std::uint64_t point_id) { return !ignored.test(classes[point_id]); };
  return {measured(octree, options, listener), options};
}

void measure_occluders(VisibilityCloud& cloud, const OccluderRequest& request, Listener& listener) {
  visibility::OccluderOptions options = request.options;
  options.mesh = cloud.mesh.tree;
  options.terrain = cloud.terrain.surface;
  cloud.occluders = measured_occluders(cloud.cloud.octree, cloud.columns.classifications,
                                       request.ignored_classes, std::move(options), listener);
  cloud.what_blocks = description_of(*cloud.occluders, request);
  listener.note(cloud.what_blocks);
}

visibility::Ground find_ground(const VisibilityCloud& cloud, visibility::GroundOptions options,
                               Listener& listener) {
  if (!cloud.has_points()) return visibility::Ground(*cloud.terrain.surface);
  visibility::Ground ground =
      in_stage(listener, "computing the ground", "points", [&](const Progress& progress) {
        options.progress = progress;
        return visibility::make_ground(cloud.octree(), cloud.columns.classifications, options);
      });
  if (cloud.terrain.surface != nullptr)
    ground.raise_to(std::make_shared<const visibility::Ground>(*cloud.terrain.surface));
  return ground;
}

}  // namespace alidade::jobs
