// SPDX-License-Identifier: MIT
#include "renderer/load_cloud.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <tuple>

#include "base/exact_math.h"
#include "base/fingerprint.h"
#include "cloud/cloud_inputs.h"
#include "cloud/point_table.h"
#include "cloud/read_cloud.h"
#include "image/color_points.h"
#include "octree/build.h"
#include "octree/distance.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/point_disc.h"

namespace alidade::renderer {
namespace {

/// Lone points far from all others would become balloons: no sphere is larger than so many times the radius
/// that closes nearly all surfaces.
constexpr double k_widest_over_automatic = 4.0;

/// Points by which it is decided what of a cloud an image shows.
constexpr std::size_t k_sample_count = 20000;

void check_positive(double value, const std::string& what) {
  check_that(value > 0.0 && std::isfinite(value), "invalid " + what, "a positive number",
             std::to_string(value));
}

/// Frees the column, which clear() alone would not.
template <class Column>
void drop(Column& column) {
  Column().swap(column);
}

/// Beyond these a point is a stray, far from all but the outermost half percent on either side of an axis: by
/// a quarter of their diagonal. Within the bounds of the cloud, which is not empty.
Bounds stray_limits(const Octree& octree) {
  constexpr double k_outermost = 0.005, k_far = 0.25;
  const std::vector<glm::dvec3> samples = sample_positions(octree, k_sample_count);
  const auto left_out = static_cast<std::size_t>(k_outermost * static_cast<double>(samples.size()));
  std::vector<double> values(samples.size());
  Bounds most;
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(samples, values.begin(),
                           [&](const glm::dvec3& position) { return position[axis]; });
    std::ranges::sort(values);
    most.min[axis] = values[left_out];
    most.max[axis] = values[values.size() - 1 - left_out];
  }
  const glm::dvec3 margin(k_far * glm::length(most.size()));
  const Bounds& all = octree.bounds();
  return {glm::max(all.min, most.min - margin), glm::min(all.max, most.max + margin)};
}

/// Frees the columns that the colours do not need.
void keep_columns(PointCloud& cloud, const image::PointColoring& coloring) {
  if (coloring.by != image::PointColor::rgb) drop(cloud.colors);
  if (coloring.by != image::PointColor::intensity) drop(cloud.intensities);
  std::erase_if(cloud.extra_dimensions,
                [&](const ExtraDimension& dimension) { return dimension.name != coloring.attribute; });
}

LoadedCloud map_cloud(const CloudSettings& settings, const CloudInput& input, const Progress& progress) {
  const IndexFile index(input.file());
  const std::string& name = index.name();
  const std::uint64_t point_count = index.header().tree.point_count;
  LoadedCloud loaded;
  const image::PointColoring coloring = image::choose_color(
      settings.color, {index.columns(), index.attributes(), point_count, name}, loaded.warnings);
  loaded.octree = index.octree(progress);
  loaded.index_checksum = checksum(encode_index_header(index.header()));
  color_cloud(loaded, coloring, index.columns(), index.description(), name);
  return loaded;
}

LoadedCloud build_cloud(const CloudSettings& settings, const CloudInputs& inputs, const Progress& reading,
                        const Progress& afterwards) {
  const std::string name = inputs.title();
  const AttributeSet seen = image::check_color_of_files(
      settings.color, inputs, settings.partial ? Damage::read_over : Damage::reject, name);
  PointCloud cloud = read_cloud(inputs, {.attributes = image::attributes_for(settings.color),
                                         .color_depth = settings.color_depth,
                                         .partial = settings.partial,
                                         .progress = reading});
  return index_cloud(std::move(cloud), seen, settings, name, afterwards);
}

/// Requires: check_shape().
void choose_disc_radius(const CloudSettings& settings, LoadedCloud& cloud, const Progress& progress) {
  const AdaptedRadius adapted = settings.adapted_radius.value_or(AdaptedRadius{});
  cloud.spacing_factor = adapted.factor.value_or(k_disc_spacings);
  check_positive(cloud.spacing_factor, "factor between spacings and radii");
  cloud.lone_radius = automatic_radius(cloud.octree);
  cloud.radius = adapted.max.value_or(k_widest_over_automatic * cloud.lone_radius);
  check_positive(cloud.radius, "largest radius of points");
  cloud.octree = with_spacings(cloud.octree, k_surface_neighbours, progress);
  cloud.surfaces = SurfaceCloud::of_discs(cloud.octree);
}

}  // namespace

void check_shape(const CloudSettings& settings) {
  if (settings.shape == PointShape::sphere) return;
  check_that(settings.max_level >= k_max_level, "discs do not support max_level",
             "spheres, or all levels: spacings are those of the whole cloud");
  check_that(!settings.radius, "discs do not support one radius for all points",
             "the radius auto, or factor and max of adapted radii");
  check_that(!std::holds_alternative<Dielectric>(settings.material), "discs do not support glass", "spheres");
  const int neighbours = settings.adapted_radius ? settings.adapted_radius->neighbours : k_surface_neighbours;
  check_that(neighbours == k_surface_neighbours, "discs do not support this number of neighbours",
             std::to_string(k_surface_neighbours), std::to_string(neighbours));
}

void choose_radius(const CloudSettings& settings, LoadedCloud& cloud, const Progress& progress) {
  check_shape(settings);
  cloud.spacing_factor = cloud.lone_radius = 0.0;
  cloud.surfaces = {};
  if (settings.shape != PointShape::sphere) return choose_disc_radius(settings, cloud, progress);
  const std::optional<AdaptedRadius>& adapted = settings.adapted_radius;
  const std::optional<double> given = adapted ? adapted->max : settings.radius;
  if (given) check_positive(*given, adapted ? "largest radius of points" : "radius of points");
  cloud.radius = given ? *given : automatic_radius(cloud.octree, settings.max_level);
  if (!adapted) return;
  check_that(settings.max_level >= k_max_level, "adapted radii do not support max_level",
             "one radius, or all levels: spacings are those of the whole cloud");
  constexpr double k_sphere_spacings = 0.75;
  cloud.spacing_factor = adapted->factor.value_or(k_sphere_spacings);
  check_positive(cloud.spacing_factor, "factor between spacings and radii");
  if (!given) cloud.radius *= k_widest_over_automatic;
  cloud.octree = with_spacings(cloud.octree, adapted->neighbours, progress);
  cloud.surfaces = SurfaceCloud::of_spheres(cloud.octree);
}

std::optional<SphereAround> sphere_around(const LoadedCloud& cloud, const glm::dvec3& position,
                                          int max_level) {
  if (cloud.spacing_factor == 0.0) {
    const auto around =
        find(cloud.octree, position, {.radius = cloud.radius, .k = 1, .max_level = max_level});
    if (around.empty()) return std::nullopt;
    return SphereAround{around.front().point_id, cloud.radius, around.front().distance};
  }
  std::vector<PointSphere> spheres;
  find_spheres(cloud.surfaces, position, 0.0,
               {.radius = cloud.radius, .spacing_factor = cloud.spacing_factor}, spheres);
  std::optional<SphereAround> nearest;
  for (const PointSphere& sphere : spheres) {
    const SphereAround around{point_id(cloud.octree.view(), sphere.index), sphere.radius,
                              distance(position, sphere.center)};
    if (!nearest ||
        std::tie(around.distance, around.point_id) < std::tie(nearest->distance, nearest->point_id))
      nearest = around;
  }
  return nearest;
}

image::PointValues heights(const TreeView& tree) {
  return {
      .count = tree.point_count, .for_each_block = [&tree](const image::VisitBlock& visit) {
        const auto visit_leaf = [&](const Leaf& leaf) {
          std::array<double, 256> values;
          for (std::uint32_t i = 0; i < leaf.count; ++i) {
            const double z = to_world(tree.lattice, position_of(tree, leaf, i)).z;
            values[i] = std::fabs(z) <= image::k_largest_value ? z : std::numeric_limits<double>::quiet_NaN();
          }
          image::ValueBlock block{.values = {values.data(), leaf.count}, .first_id = leaf.first, .ids = {}};
          if (tree.ids != nullptr) block.ids = {tree.ids + leaf.first, leaf.count};
          visit(block);
        };
        for_each_leaf_in_parallel(tree, Progress(), [&] { return visit_leaf; });
      }};
}

void color_cloud(LoadedCloud& loaded, const image::PointColoring& coloring, const AttributeColumns& columns,
                 const PointCloud& description, const std::string& name) {
  std::vector<std::string> warnings = description.warnings;
  if (loaded.octree.size() == 0) warnings.push_back(name + " has no points");
  loaded.warnings.insert(loaded.warnings.begin(), warnings.begin(), warnings.end());
  loaded.crs = description.crs;
  loaded.scanner_positions = description.scanner_positions;
  loaded.files = description.files;
  image::ColoredPoints points =
      image::color_points(coloring, columns, description, heights(loaded.octree.view()));
  loaded.colors = std::move(points.colors);
  loaded.color = std::move(points.key);
  if (coloring.by == image::PointColor::rgb) loaded.mapped_colors = columns.colors;
  if (loaded.color.missing_count == 0) return;
  loaded.warnings.push_back(fmt::format("{}: {} of {} points have no {} and are grey", name,
                                        loaded.color.missing_count, loaded.color.point_count,
                                        loaded.color.word));
}

LoadedCloud index_cloud(PointCloud&& cloud, AttributeSet attributes, const CloudSettings& settings,
                        const std::string& name, const Progress& progress) {
  LoadedCloud loaded;
  const image::PointColoring coloring = image::choose_color(
      settings.color, {columns_of(cloud), attributes, cloud.size(), name}, loaded.warnings);
  keep_columns(cloud, coloring);
  loaded.octree = build(std::move(cloud), {.progress = progress});
  color_cloud(loaded, coloring, columns_of(cloud), cloud, name);
  if (coloring.by == image::PointColor::rgb) loaded.colors = std::move(cloud.colors);
  loaded.mapped_colors = {};
  return loaded;
}

LoadedCloud load_cloud(const CloudSettings& settings, const CloudInputs& inputs, const Progress& progress,
                       const Progress& measuring) {
  // Reading counts the work; what follows only checks for cancellation, at the count where reading ended.
  std::uint64_t done = 0, total = 0;
  const Progress reading = [&](std::uint64_t bytes, std::uint64_t all_bytes) {
    done = bytes;
    total = all_bytes;
    return !progress || progress(bytes, all_bytes);
  };
  const Progress afterwards = [&](std::uint64_t, std::uint64_t) {
    return !progress || progress(done, total);
  };
  const CloudInput* const index = inputs.only(k_index_format);
  LoadedCloud loaded = index && !index->changes_heights()
                           ? map_cloud(settings, *index, reading)
                           : build_cloud(settings, inputs, reading, afterwards);
  if (settings.max_level < k_max_level && loaded.octree.size() > 0 &&
      loaded.octree.view().organisation != Organisation::layered) {
    throw file_error(inputs.title(), "max_level requires a layered index",
                     "an index file made with --organisation layered");
  }
  report(afterwards, done, total);
  choose_radius(settings, loaded, measuring);
  return loaded;
}

LoadedCloud load_cloud(const CloudSettings& settings, const Progress& progress, const Progress& measuring) {
  return load_cloud(settings, resolve_clouds(settings.files, index_and_file_formats()), progress, measuring);
}

std::vector<glm::dvec3> visible_positions(const LoadedCloud& cloud) {
  const Octree& octree = cloud.octree;
  if (octree.size() == 0) return {};
  std::vector<glm::dvec3> positions = sample_positions(octree, k_sample_count);
  const Bounds limits = stray_limits(octree);
  std::erase_if(positions, [&](const glm::dvec3& position) { return !limits.contains(position); });
  if (octree.size() <= k_sample_count) return positions;
  // Samples miss the tips of what is thin: the farthest in directions all around are those nearest to
  // positions far away.
  constexpr int k_directions = 128;
  constexpr double k_golden_degrees = 137.5, k_far = 32.0;
  const PointQuery query{.k = 1,
                         .filter = [&](const Candidate& point) { return limits.contains(point.position); }};
  const double distance = k_far * glm::length(limits.size());
  for (int i = 0; i < k_directions; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / k_directions, across = std::sqrt(1.0 - z * z);
    const SineCosine turn = sine_cosine_of_degrees(k_golden_degrees * i);
    const glm::dvec3 direction(across * turn.cosine, across * turn.sine, z);
    for (const PointHit& hit : find(octree, limits.center() + distance * direction, query))
      positions.push_back(hit.position);
  }
  return positions;
}

Bounds visible_bounds(const LoadedCloud& cloud) {
  const Bounds& all = cloud.octree.bounds();
  Bounds bounds;
  if (all.empty()) return bounds;
  const Bounds limits = stray_limits(cloud.octree);
  if (limits.min == all.min && limits.max == all.max)
    bounds = all;
  else
    for (const glm::dvec3& position : visible_positions(cloud)) bounds.grow(position);
  bounds.min -= cloud.radius;
  bounds.max += cloud.radius;
  return bounds;
}

std::uint64_t stray_count(const LoadedCloud& cloud) {
  if (cloud.octree.bounds().empty()) return 0;
  const Bounds limits = stray_limits(cloud.octree);
  // Only what is outside is visited.
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  Bounds rest{glm::dvec3(-k_infinity), glm::dvec3(k_infinity)};
  std::uint64_t strays = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Bounds below = rest, above = rest;
    below.max[axis] = std::nextafter(limits.min[axis], -k_infinity);
    above.min[axis] = std::nextafter(limits.max[axis], k_infinity);
    strays += count(cloud.octree, below) + count(cloud.octree, above);
    rest.min[axis] = limits.min[axis];
    rest.max[axis] = limits.max[axis];
  }
  return strays;
}

}  // namespace alidade::renderer
