// SPDX-License-Identifier: MIT
#include "tools/cloud/index.h"

#include <fmt/format.h>
#include <algorithm>

#include "base/scratch_file.h"
#include "cloud/scratch_cloud.h"
#include "octree/index_file/index_file.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"
#include "tools/cloud/kept_reading.h"
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
  std::optional<std::size_t> memory;
  CheckpointRequest checkpoint;
  ColorDepth color_depth = ColorDepth::automatic;
  AttributeSet attributes = AttributeSet::all();  ///< to keep
};

/// "color,intensity", or "none". Errors: an unknown name.
AttributeSet parse_attributes(const std::string& text) {
  const std::vector<std::string> known = attribute_names(AttributeSet::all());
  AttributeSet attributes;
  if (text == "none") return attributes;
  for (const std::string& word : split_list(text)) {
    const auto found = std::ranges::find(known, word);
    if (found == known.end())
      throw UsageError(fmt::format("unknown attribute; expected none or some of {}; found '{}'",
                                   fmt::join(known, ", "), word));
    attributes.bits |= 1u << (found - known.begin());
  }
  return attributes;
}

BuildOptions build_options(const IndexRequest& request, const Progress& progress) {
  return {.organisation = request.organisation, .cell_size = request.cell_size, .progress = progress};
}

void save_shown(const std::filesystem::path& path, const Octree& octree, const PointCloud& facts,
                const AttributeColumns& columns, SaveIndexOptions options, Verbosity verbosity) {
  with_progress("writing", "B", verbosity, [&](const Progress& progress) {
    options.progress = progress;
    save_index(path, octree, facts, columns, options);
  });
  if (verbosity == Verbosity::quiet) return;
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  const auto points = static_cast<double>(octree.size());
  say_note(fmt::format("{} points, {:.1f} bytes each, {:.1f} of them octree; wrote {}", octree.size(),
                       octree.size() ? bytes / points : 0.0,
                       octree.size() ? static_cast<double>(octree.memory()) / points : 0.0, path.string()));
}

/// check_room() for all that the disk holds while an index is made. The size of a selection is not known
/// beforehand, and not checked.
void check_room_for(const IndexCommand& command, const std::filesystem::path& folder,
                    std::uint64_t rows_there) {
  const bool selects = std::ranges::any_of(command.files.inputs, &CloudInput::is_changed);
  StatedSize size = stated_size(command.files);
  if (selects || command.partial || size.uncounted_bytes > 0) return;
  size.attributes = size.attributes & command.attributes;
  // The points in Morton order take 16 bytes each, the octree at most 24. Columns make room for those of the
  // index, and positions for the points in order; a checkpoint keeps both. Later measurements take less than
  // the points in order, which are removed before.
  constexpr std::uint64_t k_sorted = 16, k_octree = 24;
  const std::uint64_t columns = size.bytes() - size.point_count * sizeof(LatticePosition);
  std::uint64_t bytes = columns + size.point_count * (k_sorted + k_octree);
  if (!command.checkpoint.file.empty()) {
    bytes = size.bytes() +
            std::max(size.point_count * (k_sorted + k_octree), columns + size.point_count * k_octree);
    bytes -=
        size.bytes() / std::max<std::uint64_t>(size.point_count, 1) * std::min(rows_there, size.point_count);
  }
  check_room(folder, bytes, command.verbosity);
}

/// For clouds larger than memory.
void write_large_index(const IndexCommand& command) {
  KeptReading kept(command.checkpoint, command.files, command.verbosity);
  ScratchSpace scratch = *scratch_beside(command.output, command.memory);
  if (kept.checkpoint()) scratch.folder = command.checkpoint.file;
  check_room_for(command, scratch.folder, kept.checkpoint() ? kept.checkpoint()->rows() : 0);
  {
    ScratchCloud cloud = with_progress("reading", "B", command.verbosity, [&](const Progress& progress) {
      return ScratchCloud(command.files,
                          {.attributes = command.attributes,
                           .color_depth = command.color_depth,
                           .partial = command.partial,
                           .progress = progress},
                          scratch, kept.checkpoint());
    });
    say_warnings(command.verbosity, cloud.facts().warnings);
    write_index(command.output, cloud, command.index, scratch, command.verbosity);
  }
  // NFS removes a file from its folder only when no program has it open.
  kept.finish();
}

ExitCode run(const IndexCommand& command) {
  const IndexRequest& index = command.index;
  if (index.cell_size > 0.0 && index.organisation != Organisation::fixed)
    throw Error({.problem = "--cell-size requires --organisation fixed"});
  if (command.output.extension() != ".alidade")
    throw file_error(command.output, "unknown output format", "the extension .alidade");
  if (index.surfaces && index.spacing_neighbours && *index.spacing_neighbours != k_surface_neighbours) {
    throw input_error("--surfaces requires the 8th neighbour", "--spacings 8, or none",
                      std::to_string(*index.spacing_neighbours));
  }
  if (command.memory && index.stored_order) throw Error({.problem = "--memory excludes --stored-order"});
  check_writable(command.output, index.overwrite, command.files.names());
  check_kept_reading(command.checkpoint, index.overwrite, command.output, command.files);
  if (command.memory) {
    write_large_index(command);
  } else {
    PointCloud cloud =
        read_shown(command, {.attributes = command.attributes, .color_depth = command.color_depth});
    write_index(command.output, cloud, index, command.verbosity);
  }
  return ExitCode::done;
}

}  // namespace

void write_index(const std::filesystem::path& path, PointCloud& cloud, const IndexRequest& request,
                 Verbosity verbosity) {
  Octree octree = with_progress("building", "points", verbosity, [&](const Progress& progress) {
    const BuildOptions options = build_options(request, progress);
    return request.stored_order ? build_in_stored_order(cloud, options) : build(std::move(cloud), options);
  });
  octree = measured(octree, request, verbosity);
  save_shown(path, octree, cloud, columns_of(cloud), {.overwrite = request.overwrite}, verbosity);
}

void write_index(const std::filesystem::path& path, ScratchCloud& cloud, const IndexRequest& request,
                 const ScratchSpace& scratch, Verbosity verbosity) {
  Octree octree = with_progress("building", "points", verbosity, [&](const Progress& progress) {
    return build_in_scratch(cloud.facts().lattice, cloud.positions(), scratch,
                            build_options(request, progress));
  });
  octree = measured(octree, request, verbosity);
  save_shown(path, octree, cloud.facts(), cloud.columns(),
             {.overwrite = request.overwrite, .written = discard_scratch_pages}, verbosity);
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
               "bits in use of LAS colours (default: 8 if none exceeds 255); colours of 8 bits take "
               "3 bytes per point in the index, others 6",
               command->color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  index.value("--attributes", "LIST",
              "attributes to keep, by the names that 'alidade info' prints, such as "
              "color,intensity,classification, or none (default: all)",
              command->attributes, parse_attributes);
  index.count("--spacings", "N",
              "store the distance of every point to its N-th nearest neighbour, 1 to 64 (usually 8): "
              "'alidade render --radius adapted' then measures nothing; 2 bytes per point and 16 per node",
              command->index.spacing_neighbours, 1, k_most_spacing_neighbours);
  index.flag("--surfaces",
             "store the surface around each point for 'alidade visibility', which then measures nothing; "
             "implies --spacings 8; 4 bytes per point",
             command->index.surfaces);
  add_checkpoint_options(index.needs(add_scratch_memory(index, command->memory)), command->checkpoint,
                         "every --checkpoint-interval seconds", "index", "FOLDER");
  index.flag("--overwrite", "replace an existing output", command->index.overwrite);
  add_run_options(index, *command);
  return command_of(index, command, run);
}

}  // namespace alidade::tools
