// SPDX-License-Identifier: MIT
#include "jobs/render/ground_layers.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/error.h"
#include "cloud/read_cloud.h"
#include "geo/raster_file.h"
#include "octree/tree_walk.h"
#include "renderer/render.h"

namespace alidade::jobs {
namespace {

/// The cells of an orthophoto. Source: camera::orthophoto_camera(), whose position is the upper left corner.
geo::RasterGrid grid_of(const camera::Camera& view) {
  return {.north_west = {view.pose.position.x, view.pose.position.y},
          .cell_size = 1.0 / view.fx,
          .columns = view.width,
          .rows = view.height};
}

std::vector<std::uint32_t> counts_of(const Octree& octree, const geo::RasterGrid& grid) {
  std::vector<std::uint32_t> counts(grid.size());
  const TreeView& tree = octree.view();
  for_each_leaf(tree, [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const glm::dvec3 position = to_world(tree.lattice, position_of(tree, leaf, i));
      const double column = std::floor((position.x - grid.north_west.x) / grid.cell_size),
                   row = std::floor((grid.north_west.y - position.y) / grid.cell_size);
      if (column >= 0.0 && row >= 0.0 && column < grid.columns && row < grid.rows)
        ++counts[grid.index(static_cast<int>(column), static_cast<int>(row))];
    }
  });
  return counts;
}

/// The positions and points that are seen from above.
image::Film seen_from_above(const renderer::Scene& scene, const renderer::LoadedCloud& cloud,
                            const camera::Camera& view) {
  renderer::Scene plain = scene;
  plain.camera = view;
  plain.render.samples = 1;
  plain.render.mode = renderer::RenderMode::flat;
  return renderer::render(
      plain, &cloud, {.layers = std::vector{image::Layer::color, image::Layer::position, image::Layer::id}});
}

/// Attributes of the points that are seen; `none` elsewhere and on objects.
template <class Value>
std::vector<Value> attribute_of(const image::Film& film, const std::vector<Value>& column, Value none) {
  std::vector<Value> values(film.count(), none);
  for (std::size_t pixel = 0; pixel < values.size(); ++pixel) {
    const std::uint32_t id = film.id[pixel];
    if (id > 0 && id <= column.size()) values[pixel] = column[id - 1];
  }
  return values;
}

}  // namespace

std::vector<std::filesystem::path> GroundLayers::files(const std::filesystem::path& output) const {
  std::vector<std::filesystem::path> files;
  for (const GroundLayer layer : layers) {
    std::filesystem::path file = output;
    if (with_color || layers.size() > 1)
      file.replace_filename(fmt::format("{}_{}{}", output.stem().string(),
                                        k_ground_layers[static_cast<std::size_t>(layer)],
                                        output.extension().string()));
    files.push_back(file);
  }
  return files;
}

void write_ground_layers(const GroundLayers& wanted, const renderer::Scene& scene,
                         const renderer::LoadedCloud& cloud, const CloudInputs& clouds,
                         const camera::NamedCamera& view, bool overwrite, EmptyViews& empty,
                         Listener& listener) {
  const geo::RasterGrid grid = grid_of(view.camera);
  const std::vector<std::filesystem::path> files = wanted.files(scene.output.file);
  image::Film film;
  AttributeSet attributes;
  for (const GroundLayer layer : wanted.layers) {
    if (layer == GroundLayer::intensity) attributes = attributes | Attribute::intensity;
    if (layer == GroundLayer::classification) attributes = attributes | Attribute::classification;
    const bool is_seen = layer != GroundLayer::density && layer != GroundLayer::count;
    if (is_seen && film.count() == 0) film = seen_from_above(scene, cloud, view.camera);
  }
  PointCloud columns;
  if (attributes != AttributeSet()) {
    columns = in_stage(listener, "reading attributes", "B", [&](const Progress& progress) {
      return read_cloud(clouds, {.attributes = attributes, .progress = progress});
    });
  }
  std::vector<std::uint32_t> counts;
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const GroundLayer layer = wanted.layers[i];
    const char* const name = k_ground_layers[static_cast<std::size_t>(layer)];
    const auto write = [&](const auto& values, double no_data) {
      const geo::RasterBand band{.values = std::span(values), .no_data = no_data, .description = name};
      geo::write_raster(files[i], {.grid = grid, .bands = {band}, .crs = cloud.crs}, overwrite);
      listener.note("wrote " + files[i].string());
    };
    const auto write_attribute = [&](const auto& column, auto none) {
      if (column.empty())
        throw file_error(clouds.title(), fmt::format("the cloud has no {}", name), "another layer");
      if (std::ranges::adjacent_find(column, std::not_equal_to()) == column.end())
        listener.warn(fmt::format("{}: all points have the {} {}", files[i].string(), name,
                                  static_cast<unsigned>(column.front())));
      write(attribute_of(film, column, none), none);
    };
    if (layer == GroundLayer::elevation) {
      std::vector<float> heights(film.count(), nothing);
      for (std::size_t pixel = 0; pixel < heights.size(); ++pixel)
        if (film.id[pixel] != 0) heights[pixel] = static_cast<float>(film.position[pixel].z);
      write(heights, nothing);
    } else if (layer == GroundLayer::intensity) {
      write_attribute(columns.intensities, std::uint16_t{0});
    } else if (layer == GroundLayer::classification) {
      write_attribute(columns.classifications, std::uint8_t{255});
    } else {
      if (counts.empty()) counts = counts_of(cloud.octree, grid);
      if (layer == GroundLayer::count) {
        write(counts, 0.0);
      } else {
        std::vector<float> densities(counts.size());
        for (std::size_t cell = 0; cell < counts.size(); ++cell)
          densities[cell] = static_cast<float>(counts[cell] / (grid.cell_size * grid.cell_size));
        write(densities, nothing);
      }
    }
  }
  const bool has_points = std::ranges::any_of(counts, [](std::uint32_t count) { return count > 0; });
  empty.check(view, film.count() > 0 ? film.sees_anything() : has_points);
}

}  // namespace alidade::jobs
