// SPDX-License-Identifier: MIT
#include "tools/cloud/index.h"

#include <fmt/format.h>

#include "octree/index_file/index_file.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/view_options.h"

namespace alidade::tools {
namespace {

Octree measured(const Octree& octree, const IndexRequest& request, Verbosity verbosity) {
  const std::optional<int> neighbours = request.surfaces ? k_surface_neighbours : request.spacing_neighbours;
  if (!neighbours) return octree;
  const Octree with = with_spacings_shown(octree, *neighbours, verbosity);
  return request.surfaces ? with_surfaces_shown(with, verbosity) : with;
}

struct IndexCommand : CloudRequest {
  std::filesystem::path output;
  IndexRequest index;
  ColorDepth color_depth = ColorDepth::automatic;
};

ExitCode run(const IndexCommand& command) {
  if (command.index.cell_size > 0.0 && command.index.organisation != Organisation::fixed)
    throw Error({.problem = "--cell-size requires --organisation fixed"});
  if (command.output.extension() != ".alidade")
    throw file_error(command.output, "unknown output format", "the extension .alidade");
  if (command.index.surfaces && command.index.spacing_neighbours &&
      *command.index.spacing_neighbours != k_surface_neighbours) {
    throw input_error("--surfaces requires the 8th neighbour", "--spacings 8, or none",
                      std::to_string(*command.index.spacing_neighbours));
  }
  check_writable(command.output, command.index.overwrite, command.files.names());
  PointCloud cloud = read_shown(command, {.color_depth = command.color_depth});
  write_index(command.output, cloud, command.index, command.verbosity);
  return ExitCode::done;
}

}  // namespace

void write_index(const std::filesystem::path& path, PointCloud& cloud, const IndexRequest& request,
                 Verbosity verbosity) {
  BuildOptions options{.organisation = request.organisation, .cell_size = request.cell_size};
  Octree octree = with_progress("building", "points", verbosity, [&](const Progress& progress) {
    options.progress = progress;
    return request.stored_order ? build_in_stored_order(cloud, options) : build(std::move(cloud), options);
  });
  octree = measured(octree, request, verbosity);
  with_progress("writing", "B", verbosity, [&](const Progress& progress) {
    save_index(path, octree, cloud, {.overwrite = request.overwrite, .progress = progress});
  });
  if (verbosity == Verbosity::quiet) return;
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  const auto points = static_cast<double>(octree.size());
  say_note(fmt::format("{} points, {:.1f} bytes each, {:.1f} of them octree; wrote {}", octree.size(),
                       octree.size() ? bytes / points : 0.0,
                       octree.size() ? static_cast<double>(octree.memory()) / points : 0.0, path.string()));
}

Command add_index(const Options& program) {
  auto command = std::make_shared<IndexCommand>();
  const Options index = program.command("index", "Build an index file, which replaces cloud files");
  add_cloud_files(index.required(), "files", "FILE...", k_files_help, command->files,
                  add_view_options(index));
  index.required().file("-o,--output", "FILE.alidade", "output index file", command->output);
  index.choice(
      "--organisation",
      "how the octree stores points, without effect on answers (default adaptive): cells split until few "
      "points remain, a grid of equal cells, or coarse to fine, so that the first levels are a thinned cloud",
      command->index.organisation,
      {{"adaptive", Organisation::adaptive},
       {"fixed", Organisation::fixed},
       {"layered", Organisation::layered}});
  index.length("--cell-size", "LENGTH",
               "longest side of a cell of --organisation fixed, in the unit of the CRS, mostly metres "
               "(default: cells with 32 points on average)",
               command->index.cell_size);
  index.flag("--stored-order",
             "number the points in the order of the octree: saves 4 bytes per point, but point ids differ "
             "from those of the input",
             command->index.stored_order);
  index.choice("--color-depth",
               "bits in use of LAS colours (default: 8 if none exceeds 255); the index keeps 16",
               command->color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  index.count("--spacings", "N",
              "store the distance of every point to its N-th nearest neighbour, 1 to 64 (usually 8): "
              "'alidade render --radius adapted' then measures nothing; 2 bytes per point and 16 per node",
              command->index.spacing_neighbours, 1, k_most_spacing_neighbours);
  index.flag("--surfaces",
             "store the surface around each point for 'alidade visibility', which then measures nothing; "
             "implies --spacings 8; 4 bytes per point",
             command->index.surfaces);
  index.flag("--overwrite", "replace an existing output", command->index.overwrite);
  add_run_options(index, *command);
  return command_of(index, command, run);
}

}  // namespace alidade::tools
