// SPDX-License-Identifier: MIT
#include "tools/visibility/blocking_cloud.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "geo/map_unit.h"
#include "octree/point_surface.h"
#include "tools/cloud/load_cloud.h"
#include "tools/cloud/mesh_files.h"

namespace alidade::tools {
namespace {

/// Error if x and y of the cloud are degrees and z is a length: then no distance can be measured and nothing
/// has an elevation, so that all answers about sight would be wrong.
void check_map_unit(const PointCloud& cloud) {
  if (geo::map_unit(cloud.crs) != geo::MapUnit::degree) return;
  throw file_error(cloud.files.empty() ? "" : cloud.files.front().path.string(),
                   "geographic coordinates (degrees) are not supported",
                   "a projected reference system: reproject the cloud");
}

/// Adds a mesh without its colours. Errors: then there are too many vertices or triangles, under its file.
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

BlockingMesh load_blocking_mesh(const std::vector<std::filesystem::path>& files, Verbosity verbosity) {
  if (files.empty()) return {};
  TriangleMesh all;
  for (const std::filesystem::path& file : files) join(read_mesh_shown(file, {}, verbosity), file, all);
  const std::uint64_t sum = checksum(all);
  return {build_mesh_shown(verbosity,
                           [&](const Progress& progress) {
                             return std::make_shared<const TriangleTree>(std::move(all), progress);
                           }),
          sum};
}

/// With all that occluders would measure themselves, in steps that show their progress.
Octree measured(Octree octree, const visibility::OccluderOptions& options, Verbosity verbosity) {
  const bool needs_surfaces = options.shape != visibility::OccluderShape::sphere;
  const bool needs_spacings = needs_surfaces || !options.radius;
  if (needs_spacings && octree.view().spacing_neighbours != k_surface_neighbours)
    octree = with_spacings_shown(octree, k_surface_neighbours, verbosity);
  if (needs_surfaces && octree.view().surfaces == nullptr) octree = with_surfaces_shown(octree, verbosity);
  return octree;
}

std::string class_list(const std::bitset<256>& classes) {
  std::string list;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes.test(i)) list += fmt::format("{}{}", list.empty() ? "" : ", ", i);
  }
  return list;
}

std::string description_of(const visibility::Occluders& occluders, const OccluderRequest& request,
                           bool has_ignored) {
  const visibility::OccluderOptions& options = occluders.options();
  std::string text = options.shape == visibility::OccluderShape::automatic
                         ? "discs block, and spheres of points without surface"
                     : options.shape == visibility::OccluderShape::disc
                         ? "discs block, points without surface do not"
                         : "spheres block";
  text += options.radius ? fmt::format("; radius {}", *options.radius)
                         : fmt::format("; radii up to {:.3g}", occluders.largest_radius());
  if (options.transparency > 1) text += fmt::format("; at {} crossings", options.transparency);
  if (options.mesh != nullptr) text += fmt::format("; {} triangles", options.mesh->triangle_count());
  if (has_ignored) text += fmt::format("; without classes {}", class_list(request.ignored_classes));
  return text;
}

}  // namespace

void add_occluder_options(const Options& command, OccluderRequest& request) {
  const Options group = command.group("What blocks");
  group.choice("--occluder",
               "what blocks (default auto): a disc on the surface of each point, a sphere, or discs where "
               "there is a surface and spheres elsewhere (foliage, wires)",
               request.options.shape,
               {{"auto", visibility::OccluderShape::automatic},
                {"disc", visibility::OccluderShape::disc},
                {"sphere", visibility::OccluderShape::sphere}});
  group.number("--radius", "R",
               "of discs and spheres, in metres (default: per point, from the distance to its neighbours)",
               request.options.radius, 1e-6, 1e6);
  group.count("--transparency", "K",
              "block a line at this number of separate crossings (default: 1); more looks through foliage",
              request.options.transparency, 1, 1000);
  add_mesh_option(group, "that block at their first crossing", request.meshes);
  group.value("--ignore-classes", "LIST|none", "points of these classes do not block (default: 7,18, noise)",
              request.ignored_classes, [](const std::string& text) {
                return text == "none" ? std::bitset<256>() : parse_classes(text);
              });
}

std::vector<std::filesystem::path> VisibilityRequest::inputs(
    std::initializer_list<std::filesystem::path> more) const {
  std::vector<std::filesystem::path> files = CloudRequest::inputs(more);
  files.insert(files.end(), occluders.meshes.begin(), occluders.meshes.end());
  return files;
}

std::unique_ptr<VisibilityCloud> load_cloud_alone(const VisibilityRequest& request, AttributeSet attributes) {
  auto loaded = std::make_unique<VisibilityCloud>();
  loaded->mesh = load_blocking_mesh(request.occluders.meshes, request.verbosity);
  loaded->cloud = load_shown(request, {.read = {.attributes = attributes | Attribute::classification}});
  if (loaded->cloud.octree.size() == 0)
    throw file_error(request.files.first_name(), "the cloud has no points");
  check_map_unit(loaded->cloud.cloud);
  loaded->columns = loaded->cloud.columns();
  return loaded;
}

void measure_occluders(VisibilityCloud& cloud, const OccluderRequest& request, Verbosity verbosity) {
  visibility::OccluderOptions options = request.options;
  options.mesh = cloud.mesh.tree;
  const std::span<const std::uint8_t> classes = cloud.columns.classifications;
  // Asking for every point takes time, so it is left out where no point has such a class.
  const bool has_ignored =
      std::ranges::any_of(classes, [&](std::uint8_t kind) { return request.ignored_classes.test(kind); });
  if (has_ignored) {
    options.counts = [classes, ignored = request.ignored_classes](std::uint64_t point_id) {
      return !ignored.test(classes[point_id]);
    };
  }
  cloud.occluders.emplace(measured(cloud.cloud.octree, options, verbosity), options);
  cloud.what_blocks = description_of(*cloud.occluders, request, has_ignored);
  say_note(verbosity, cloud.what_blocks);
}

visibility::Ground find_ground(const VisibilityCloud& cloud, visibility::GroundOptions options,
                               Verbosity verbosity) {
  return with_progress("computing the ground", "points", verbosity, [&](const Progress& progress) {
    options.progress = progress;
    return visibility::make_ground(cloud.octree(), cloud.columns.classifications, options);
  });
}

}  // namespace alidade::tools
