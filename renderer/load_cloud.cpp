// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "octree/build.h"
#include "octree/cloud/attribute_columns.h"
#include "octree/cloud/read_cloud.h"
#include "octree/index_file.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "renderer/render.h"

namespace alidade {
namespace {

/// Where values of a column begin and end when a few outliers are left out.
struct Stretch {
  double low = 0.0, high = 0.0;

  /// 0 at the low end, 1 at the high one; one half where all values are the same.
  double place(double value) const {
    return high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) : 0.5;
  }
};

constexpr double k_outlier_share = 0.02;

/// Ends between which all but 2 % of the counted values lie on either side; values are bin numbers.
Stretch inner_bins(std::span<const std::uint64_t> histogram, std::uint64_t total) {
  const auto outliers = static_cast<std::uint64_t>(k_outlier_share * static_cast<double>(total));
  std::size_t low = 0, high = histogram.size() - 1;
  for (std::uint64_t seen = histogram[low]; seen <= outliers && low < high; seen += histogram[low]) ++low;
  for (std::uint64_t seen = histogram[high]; seen <= outliers && high > low; seen += histogram[high]) --high;
  return {static_cast<double>(low), static_cast<double>(high)};
}

/// Calls visit(place, lattice steps of z) for every point.
template <class Visit>
void for_each_height(const TreeView& tree, const Visit& visit) {
  for_each_leaf(tree, [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i) visit(leaf.place + i, position_of(tree, leaf, i).z);
  });
}

Stretch intensity_stretch(std::span<const std::uint16_t> intensities) {
  std::vector<std::uint64_t> histogram(65536);
  for (const std::uint16_t value : intensities) ++histogram[value];
  return inner_bins(histogram, intensities.size());
}

/// In lattice steps of z.
Stretch height_stretch(const TreeView& tree) {
  std::int64_t lowest = std::numeric_limits<std::int32_t>::max(),
               highest = std::numeric_limits<std::int32_t>::min();
  for_each_height(tree, [&](std::uint32_t, std::int64_t height) {
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
  });
  if (lowest >= highest) return {static_cast<double>(lowest), static_cast<double>(highest)};
  constexpr std::int64_t k_bins = 65536;
  const std::int64_t extent = highest - lowest + 1;
  std::vector<std::uint64_t> histogram(k_bins);
  for_each_height(tree, [&](std::uint32_t, std::int64_t height) {
    ++histogram[static_cast<std::size_t>((height - lowest) * k_bins / extent)];
  });
  const Stretch bins = inner_bins(histogram, tree.point_count);
  const double step = static_cast<double>(extent) / k_bins;
  return {static_cast<double>(lowest) + bins.low * step,
          static_cast<double>(lowest) + (bins.high + 1.0) * step};
}

Color16 from_unit(const glm::dvec3& color) {
  return Color16(color * 65535.0 + 0.5);
}

/// Grey of an intensity, display value: the darkest is no black, which would hide all shape in the shade.
Color16 intensity_color(double place) {
  constexpr double k_darkest = 0.2, k_brightest = 0.95;
  return from_unit(glm::dvec3(k_darkest + (k_brightest - k_darkest) * place));
}

/// Meadow, straw, clay, rock, snow: display values at even steps of height.
Color16 height_color(double place) {
  constexpr std::array<glm::dvec3, 5> k_ramp = {glm::dvec3(0.30, 0.45, 0.34), glm::dvec3(0.60, 0.68, 0.42),
                                                glm::dvec3(0.85, 0.77, 0.52), glm::dvec3(0.70, 0.52, 0.38),
                                                glm::dvec3(0.95, 0.94, 0.92)};
  const double step = place * (k_ramp.size() - 1);
  const auto index = std::min(static_cast<std::size_t>(step), k_ramp.size() - 2);
  const double share = step - static_cast<double>(index);
  return from_unit(k_ramp[index] * (1.0 - share) + k_ramp[index + 1] * share);
}

/// Frees the column, which clear() alone would not.
template <class Column>
void drop(Column& column) {
  Column().swap(column);
}

bool has_color(const AttributeColumns& columns) {
  return std::any_of(columns.colors.begin(), columns.colors.end(),
                     [](const Color16& color) { return color != Color16(0); });
}

bool has_varied_intensity(const AttributeColumns& columns) {
  return std::any_of(columns.intensities.begin(), columns.intensities.end(),
                     [&](std::uint16_t value) { return value != columns.intensities.front(); });
}

AttributeSet wanted_attributes(PointColor color) {
  switch (color) {
    case PointColor::rgb:
      return Attribute::color;
    case PointColor::intensity:
      return Attribute::intensity;
    case PointColor::height:
      return {};
    case PointColor::automatic:
      break;
  }
  return Attribute::color | Attribute::intensity;
}

std::string names(const std::vector<std::filesystem::path>& files) {
  const std::string first = files.empty() ? "the cloud" : files.front().string();
  return files.size() > 1 ? first + " and " + std::to_string(files.size() - 1) + " more" : first;
}

/// What the colours will show. Errors: an attribute was asked for by name and is not there.
PointColor choose_color(const CloudSettings& settings, const AttributeColumns& columns, std::uint64_t count,
                        std::vector<std::string>& warnings) {
  if (count == 0) return PointColor::rgb;
  if (settings.color == PointColor::rgb && columns.colors.empty()) {
    throw Error(
        {.file = names(settings.files), .problem = "points have no colour; color \"rgb\" cannot be shown"});
  }
  if (settings.color == PointColor::intensity && columns.intensities.empty()) {
    throw Error({.file = names(settings.files),
                 .problem = "points have no intensity; color \"intensity\" cannot be shown"});
  }
  if (settings.color != PointColor::automatic) return settings.color;
  if (has_color(columns)) return PointColor::rgb;
  const bool varied = has_varied_intensity(columns);
  warnings.push_back(names(settings.files) +
                     (columns.colors.empty() ? " has no colour" : " has only black as colour") +
                     (varied ? ": coloured by intensity" : " and no varied intensity: coloured by height"));
  return varied ? PointColor::intensity : PointColor::height;
}

/// Colours that are worked out, by point id.
std::vector<Color16> computed_colors(PointColor color, std::span<const std::uint16_t> intensities,
                                     const TreeView& tree) {
  std::vector<Color16> colors(tree.point_count);
  if (color == PointColor::intensity) {
    const Stretch stretch = intensity_stretch(intensities);
    for (std::size_t id = 0; id < colors.size(); ++id)
      colors[id] = intensity_color(stretch.place(intensities[id]));
  } else {
    const Stretch stretch = height_stretch(tree);
    for_each_height(tree, [&](std::uint32_t place, std::int64_t height) {
      colors[point_id(tree, place)] = height_color(stretch.place(static_cast<double>(height)));
    });
  }
  return colors;
}

/// Takes over what a cloud says about itself.
void describe(LoadedCloud& loaded, const CloudSettings& settings, PointCloud&& cloud, std::uint64_t count) {
  loaded.warnings = std::move(cloud.warnings);
  if (count == 0) loaded.warnings.push_back(names(settings.files) + " has no points");
  loaded.crs = std::move(cloud.crs);
  loaded.files = std::move(cloud.files);
}

LoadedCloud map_cloud(const CloudSettings& settings, const Progress& progress) {
  const IndexFile index = open_index(settings.files.front());
  LoadedCloud loaded;
  describe(loaded, settings, PointCloud(index.description()), index.header().tree.point_count);
  loaded.color = choose_color(settings, index.columns(), index.header().tree.point_count, loaded.warnings);
  loaded.octree = index.octree(progress);
  if (loaded.color == PointColor::rgb) {
    loaded.mapped_colors = index.columns().colors;
  } else {
    loaded.colors = computed_colors(loaded.color, index.columns().intensities, loaded.octree.view());
  }
  return loaded;
}

LoadedCloud build_cloud(const CloudSettings& settings, const Progress& reading, const Progress& afterwards) {
  PointCloud cloud = read_cloud(settings.files, {.attributes = wanted_attributes(settings.color),
                                                 .color_depth = settings.color_depth,
                                                 .progress = reading});
  LoadedCloud loaded;
  describe(loaded, settings, std::move(cloud), cloud.size());
  loaded.color = choose_color(settings, columns_of(cloud), cloud.size(), loaded.warnings);
  if (loaded.color != PointColor::intensity) drop(cloud.intensities);
  if (loaded.color != PointColor::rgb) drop(cloud.colors);
  loaded.octree = build(std::move(cloud), {.progress = afterwards});
  loaded.colors = loaded.color == PointColor::rgb
                      ? std::move(cloud.colors)
                      : computed_colors(loaded.color, cloud.intensities, loaded.octree.view());
  return loaded;
}

}  // namespace

LoadedCloud load_cloud(const CloudSettings& settings, const Progress& progress) {
  if (settings.radius && !(*settings.radius > 0.0 && std::isfinite(*settings.radius))) {
    throw Error({.problem = "bad radius of points",
                 .expected = "a positive number",
                 .found = std::to_string(*settings.radius)});
  }
  // Reading counts the work; what follows is asked whether to go on, at the place where reading ended.
  std::uint64_t done = 0, total = 0;
  const Progress reading = [&](std::uint64_t bytes, std::uint64_t all_bytes) {
    done = bytes;
    total = all_bytes;
    return !progress || progress(bytes, all_bytes);
  };
  const Progress afterwards = [&](std::uint64_t, std::uint64_t) {
    return !progress || progress(done, total);
  };
  const bool is_indexed = settings.files.size() == 1 && is_index_file(settings.files.front());
  LoadedCloud loaded = is_indexed ? map_cloud(settings, reading) : build_cloud(settings, reading, afterwards);
  if (settings.max_level < k_max_level && loaded.octree.size() > 0 &&
      loaded.octree.view().organisation != Organisation::layered) {
    throw Error({.file = names(settings.files),
                 .problem = "max_level needs points in levels",
                 .expected = "an index file made with --organisation layered"});
  }
  loaded.radius = settings.radius ? *settings.radius : automatic_radius(loaded.octree, settings.max_level);
  report(afterwards, done, total);
  return loaded;
}

Bounds visible_bounds(const LoadedCloud& cloud) {
  constexpr std::size_t k_sample_count = 20000;
  constexpr double k_stray_share = 0.005, k_margin = 0.05;
  const Bounds& all = cloud.octree.bounds();
  Bounds bounds;
  if (all.empty()) return bounds;
  const std::vector<glm::dvec3> samples = sample_positions(cloud.octree, k_sample_count);
  const auto stray = static_cast<std::size_t>(k_stray_share * static_cast<double>(samples.size()));
  std::vector<double> values(samples.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(samples, values.begin(),
                           [&](const glm::dvec3& position) { return position[axis]; });
    std::ranges::sort(values);
    const double low = values[stray], high = values[values.size() - 1 - stray],
                 margin = k_margin * (high - low);
    // A site without strays is shown to its very edge: the margin makes up for the share that was cut.
    bounds.min[axis] = std::max(all.min[axis], low - margin) - cloud.radius;
    bounds.max[axis] = std::min(all.max[axis], high + margin) + cloud.radius;
  }
  return bounds;
}

}  // namespace alidade
