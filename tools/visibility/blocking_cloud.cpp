// SPDX-License-Identifier: MIT
#include "tools/visibility/blocking_cloud.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"
#include "tools/message.h"
#include "tools/visibility/check_map_unit.h"

namespace alidade {
namespace {

IndexedCloud load(const std::vector<std::filesystem::path>& files, bool partial, AttributeSet attributes,
                  Verbosity verbosity) {
  ProgressLine line("loading cloud", "B", verbosity);
  IndexCloudOptions options;
  options.read.progress = line.callback();
  options.read.partial = partial;
  options.read.attributes = attributes | Attribute::classification;
  IndexedCloud cloud = load_indexed_cloud(files, options);
  line.finish();
  if (verbosity != Verbosity::quiet) {
    for (const std::string& warning : cloud.cloud.warnings) say_warning(warning);
  }
  if (cloud.octree.size() == 0) throw Error({.file = files.front().string(), .problem = "holds no points"});
  return cloud;
}

/// With all that occluders would measure themselves, in steps that show their progress.
Octree measured(Octree octree, const OccluderOptions& options, Verbosity verbosity) {
  const bool needs_surfaces = options.shape != OccluderShape::sphere;
  const bool needs_spacings = needs_surfaces || !options.radius;
  if (needs_spacings && octree.view().spacing_neighbours != k_surface_neighbours) {
    ProgressLine line("measuring spacings", "points", verbosity);
    octree = with_spacings(octree, k_surface_neighbours, line.callback());
    line.finish();
  }
  if (needs_surfaces && octree.view().surfaces == nullptr) {
    ProgressLine line("fitting surfaces", "points", verbosity);
    octree = with_surfaces(octree, line.callback());
    line.finish();
  }
  return octree;
}

std::string class_list(const std::bitset<256>& classes) {
  std::string list;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes.test(i)) list += fmt::format("{}{}", list.empty() ? "" : ", ", i);
  }
  return list;
}

std::string description_of(const Occluders& occluders, const OccluderRequest& request, bool has_ignored) {
  const OccluderOptions& options = occluders.options();
  std::string text = options.shape == OccluderShape::automatic
                         ? "discs block, and spheres of points without surface"
                     : options.shape == OccluderShape::disc ? "discs block, points without surface do not"
                                                            : "spheres block";
  text += options.radius ? fmt::format("; radius {}", *options.radius)
                         : fmt::format("; radii up to {:.3g}", occluders.largest_radius());
  if (options.transparency > 1) text += fmt::format("; from {} crossings on", options.transparency);
  if (has_ignored) text += fmt::format("; but not classes {}", class_list(request.ignored_classes));
  return text;
}

}  // namespace

std::unique_ptr<VisibilityCloud> load_cloud_alone(const std::vector<std::filesystem::path>& files,
                                                  bool partial, AttributeSet attributes,
                                                  Verbosity verbosity) {
  auto loaded = std::make_unique<VisibilityCloud>();
  loaded->cloud = load(files, partial, attributes, verbosity);
  check_map_unit(loaded->cloud.cloud);
  loaded->columns = loaded->cloud.columns();
  return loaded;
}

void measure_occluders(VisibilityCloud& cloud, const OccluderRequest& request, Verbosity verbosity) {
  OccluderOptions options;
  options.shape = request.shape.value_or(OccluderShape::automatic);
  options.radius = request.radius;
  options.transparency = request.transparency;
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
  if (verbosity != Verbosity::quiet) say_note(cloud.what_blocks);
}

}  // namespace alidade
