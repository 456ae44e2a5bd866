// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "octree/build.h"
#include "octree/cloud/read_cloud.h"
#include "octree/index_file.h"
#include "octree/point_spacing.h"
#include "octree/point_surface.h"
#include "tools/command.h"
#include "tools/message.h"
#include "tools/options.h"
#include "tools/progress.h"

namespace alidade {
namespace {

struct IndexCommand {
  std::vector<std::filesystem::path> files;
  std::filesystem::path output;
  std::optional<Organisation> organisation;
  double cell_size = 0.0;
  std::optional<ColorDepth> color_depth;
  bool stored_order = false;
  std::optional<int> spacing_neighbours;
  bool surfaces = false;
  bool overwrite = false;
  std::optional<int> threads;
  VerbosityOptions verbosity;
};

PointCloud read(const IndexCommand& command) {
  ProgressLine line("reading", "B", command.verbosity.verbosity());
  PointCloud cloud = read_cloud(
      command.files,
      {.color_depth = command.color_depth.value_or(ColorDepth::automatic), .progress = line.callback()});
  line.finish();
  if (command.verbosity.quiet) return cloud;
  for (const std::string& warning : cloud.warnings) say_warning(warning);
  return cloud;
}

Octree build_from(const IndexCommand& command, PointCloud& cloud) {
  ProgressLine line("building", "points", command.verbosity.verbosity());
  BuildOptions options;
  options.organisation = command.organisation.value_or(Organisation::adaptive);
  options.cell_size = command.cell_size;
  options.progress = line.callback();
  Octree octree =
      command.stored_order ? build_in_stored_order(cloud, options) : build(std::move(cloud), options);
  line.finish();
  return octree;
}

Octree with_surfaces(const IndexCommand& command, const Octree& octree) {
  if (!command.surfaces) return octree;
  ProgressLine line("fitting surfaces", "points", command.verbosity.verbosity());
  Octree with = with_surfaces(octree, line.callback());
  line.finish();
  return with;
}

Octree measured(const IndexCommand& command, const Octree& octree) {
  const std::optional<int> neighbours = command.surfaces ? k_surface_neighbours : command.spacing_neighbours;
  if (!neighbours) return octree;
  ProgressLine line("measuring spacings", "points", command.verbosity.verbosity());
  const Octree with = with_spacings(octree, *neighbours, line.callback());
  line.finish();
  return with_surfaces(command, with);
}

ExitCode run(const IndexCommand& command) {
  if (command.cell_size > 0.0 && command.organisation != Organisation::fixed)
    throw Error({.problem = "--cell-size is for --organisation fixed"});
  if (command.output.extension() != ".alidade") {
    throw Error({.file = command.output.string(),
                 .problem = "is no name of an index file",
                 .expected = "a name that ends in .alidade"});
  }
  if (command.surfaces && command.spacing_neighbours && *command.spacing_neighbours != k_surface_neighbours) {
    throw Error({.problem = "--surfaces goes by the 8th neighbour",
                 .expected = "--spacings 8, or none",
                 .found = std::to_string(*command.spacing_neighbours)});
  }
  check_writable(command.output, command.overwrite, command.files);
  PointCloud cloud = read(command);
  const Octree octree = measured(command, build_from(command, cloud));
  ProgressLine line("writing", "B", command.verbosity.verbosity());
  save_index(command.output, octree, cloud, {.overwrite = command.overwrite, .progress = line.callback()});
  line.finish();
  if (!command.verbosity.quiet) {
    const auto bytes = static_cast<double>(std::filesystem::file_size(command.output));
    const auto points = static_cast<double>(octree.size());
    say_note(fmt::format("{} points, {:.1f} bytes each, {:.1f} of them octree; wrote {}", octree.size(),
                         octree.size() ? bytes / points : 0.0,
                         octree.size() ? static_cast<double>(octree.memory()) / points : 0.0,
                         command.output.string()));
  }
  return ExitCode::done;
}

}  // namespace

Command add_index(CLI::App& program) {
  auto command = std::make_shared<IndexCommand>();
  CLI::App* index =
      program.add_subcommand("index", "Make an index file, which takes the place of cloud files");
  index->add_option("files", command->files, "cloud files; several are joined into one cloud")
      ->option_text("FILE...")
      ->required();
  index->add_option("-o,--output", command->output, "index file to write")
      ->option_text("FILE.alidade")
      ->required();
  add_choice<Organisation>(
      *index, "--organisation",
      "how points are spread over the octree; answers are the same (default adaptive): cells "
      "split until few points are left, a grid of cells of one size, or coarse to fine, so "
      "that a prefix of levels is a thinned cloud",
      command->organisation,
      {{"adaptive", Organisation::adaptive},
       {"fixed", Organisation::fixed},
       {"layered", Organisation::layered}});
  add_value(
      *index, "--cell-size", "LENGTH",
      "longest side of a cell of --organisation fixed, in the unit of the CRS, mostly metres (default: cells "
      "that hold 32 points on average)",
      [command](const std::string& text) {
        command->cell_size = parse_number(text, 0.0);
        if (command->cell_size == 0.0) throw CLI::ValidationError("expected a length above 0, found '0'");
      });
  index->add_flag(
      "--stored-order", command->stored_order,
      "number the points as the octree stores them: 4 bytes per point less, but point ids are not those "
      "of the input any more");
  add_choice<ColorDepth>(*index, "--color-depth",
                         "bits in use of LAS colours (default: 8 if none exceeds 255); the index keeps 16",
                         command->color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  add_value(*index, "--spacings", "N",
            "store the distance of every point to its N-th nearest neighbour, 1 to 64 (the usual one is 8): "
            "'alidade "
            "render --radius adapted' then has nothing to measure; 2 bytes per point and 16 per node",
            [command](const std::string& text) {
              command->spacing_neighbours = static_cast<int>(parse_count(text, 1, k_most_spacing_neighbours));
            });
  index->add_flag(
      "--surfaces", command->surfaces,
      "store the surface that each point lies on, for 'alidade visibility', which then has nothing "
      "to measure; implies --spacings 8; 4 bytes per point");
  index->add_flag("--overwrite", command->overwrite, "replace an existing output");
  add_threads(*index, command->threads);
  add_verbosity(*index, command->verbosity);
  index->footer(
      "Form:\n"
      "  alidade index FILE... -o FILE.alidade [OPTIONS]\n"
      "\n"
      "The index file holds the octree, every attribute of every point, the coordinate reference system, the "
      "LAS\n"
      "records, and which files it was made of. It is read wherever a cloud file is, without building "
      "anything,\n"
      "and gives the same answers and pictures. About 11 bytes per point for the octree, which holds all "
      "positions\n"
      "without loss, and what the attributes take: 22 bytes for LAS point format 7, with colours and GPS "
      "time.\n"
      "'alidade info --verify' checks it byte by byte. The format: docs/index_file.md.\n"
      "\n"
      "Examples:\n"
      "  alidade index site.las -o site.alidade\n"
      "  alidade index tile_1.las tile_2.las -o site.alidade --organisation layered\n"
      "  alidade index site.las -o site.alidade --spacings 8\n"
      "  alidade index site.las -o site.alidade --surfaces\n");
  return {index, [command] {
            ExitCode code = ExitCode::failed;
            with_threads(command->threads, [&] { code = run(*command); });
            return code;
          }};
}

}  // namespace alidade
