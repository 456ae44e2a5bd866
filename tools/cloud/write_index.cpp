// SPDX-License-Identifier: MIT
#include "tools/cloud/index.h"

#include <fmt/format.h>

#include "octree/index_file/index_file.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"
#include "tools/message.h"

namespace alidade {
namespace {

Octree build_from(PointCloud& cloud, const IndexRequest& request, Verbosity verbosity) {
  ProgressLine line("building", "points", verbosity);
  BuildOptions options;
  options.organisation = request.organisation;
  options.cell_size = request.cell_size;
  options.progress = line.callback();
  Octree octree =
      request.stored_order ? build_in_stored_order(cloud, options) : build(std::move(cloud), options);
  line.finish();
  return octree;
}

Octree with_fitted_surfaces(const Octree& octree, Verbosity verbosity) {
  ProgressLine line("fitting surfaces", "points", verbosity);
  Octree with = with_surfaces(octree, line.callback());
  line.finish();
  return with;
}

Octree measured(const Octree& octree, const IndexRequest& request, Verbosity verbosity) {
  const std::optional<int> neighbours = request.surfaces ? k_surface_neighbours : request.spacing_neighbours;
  if (!neighbours) return octree;
  ProgressLine line("measuring spacings", "points", verbosity);
  const Octree with = with_spacings(octree, *neighbours, line.callback());
  line.finish();
  return request.surfaces ? with_fitted_surfaces(with, verbosity) : with;
}

}  // namespace

void write_index(const std::filesystem::path& path, PointCloud& cloud, const IndexRequest& request,
                 Verbosity verbosity) {
  const Octree octree = measured(build_from(cloud, request, verbosity), request, verbosity);
  ProgressLine line("writing", "B", verbosity);
  save_index(path, octree, cloud, {.overwrite = request.overwrite, .progress = line.callback()});
  line.finish();
  if (verbosity == Verbosity::quiet) return;
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  const auto points = static_cast<double>(octree.size());
  say_note(fmt::format("{} points, {:.1f} bytes each, {:.1f} of them octree; wrote {}", octree.size(),
                       octree.size() ? bytes / points : 0.0,
                       octree.size() ? static_cast<double>(octree.memory()) / points : 0.0, path.string()));
}

}  // namespace alidade
