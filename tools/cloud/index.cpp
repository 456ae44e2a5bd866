// SPDX-License-Identifier: MIT
#include "tools/cloud/index.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "base/scratch_checkpoint.h"
#include "base/scratch_file.h"
#include "cloud/scratch_cloud.h"
#include "database/server/server_clouds.h"
#include "database/sqlite/stored_cloud.h"
#include "octree/index_file/save_index.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

Octree measured(const Octree& octree, const IndexRequest& request, Verbosity verbosity) {
  const std::optional<int> neighbours = request.surfaces ? k_surface_neighbours : request.spacing_neighbours;
  if (!neighbours) return octree;
  Console console(verbosity);
  const Octree with = jobs::with_spacings(octree, *neighbours, console);
  return request.surfaces ? jobs::with_surfaces(with, console) : with;
}

struct IndexCommand : CloudRequest {
  std::filesystem::path output;
  IndexRequest index;
  std::optional<std::size_t> memory;
  CheckpointRequest checkpoint;
  ColorDepth color_depth = ColorDepth::automatic;
  AttributeSet attributes = AttributeSet::all();  ///< to keep
};

/// The attribute of a name. Errors: an unknown name.
AttributeSet attribute_of(const std::string& name) {
  for (AttributeSet one(Attribute::color); one.bits <= AttributeSet::all().bits; one.bits <<= 1) {
    if (std::ranges::count(attribute_names(one), name) > 0) return one;
  }
  throw UsageError(fmt::format("unknown attribute; expected none or some of {}; found '{}'",
                               fmt::join(attribute_names(AttributeSet::all()), ", "), name));
}

/// "color,intensity", or "none". return_number and number_of_returns are kept together. Errors: an unknown
/// name.
AttributeSet parse_attributes(const std::string& text) {
  AttributeSet attributes;
  if (text == "none") return attributes;
  for (const std::string& word : split_list(text)) attributes = attributes | attribute_of(word);
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

/// To be raised when the rows that are read from a file change.
constexpr const char* k_rows_version = "2";

/// The files are in the fingerprint one by one.
constexpr std::array<std::string_view, 1> k_silent_options_of_index = {"files"};

/// "2026-01-31T12:00:00.123456789Z".
std::string time_text(std::filesystem::file_time_type time) {
  const auto moment = std::chrono::file_clock::to_sys(time);
  const auto day = std::chrono::floor<std::chrono::days>(moment);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(std::chrono::duration_cast<std::chrono::nanoseconds>(moment - day));
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:09}Z", int(date.year()), unsigned(date.month()),
                     unsigned(date.day()), clock.hours().count(), clock.minutes().count(),
                     clock.seconds().count(), clock.subseconds().count());
}

/// Size and time of the last change of a local file; size and version of a remote one, by its server.
std::string stamp(const std::filesystem::path& file) {
  if (is_remote_name(file.string())) {
    const std::unique_ptr<RemoteFile> remote = open_remote_file(file.string());
    return fmt::format("{} bytes, version {}", remote->size(), remote->version());
  }
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) return "missing";
  return fmt::format("{} bytes, changed {}", size, time_text(std::filesystem::last_write_time(file, error)));
}

Fingerprint reading_fingerprint(const Fields& command, const CloudInputs& inputs) {
  Fingerprint fingerprint{{"program version", ALIDADE_VERSION}, {"version of rows", k_rows_version}};
  for (const auto& [name, words] : command.given()) {
    if (is_silent(name, k_silent_options_of_index)) continue;
    std::string all;
    std::error_code error;
    for (const std::string& word : words) {
      all += (all.empty() ? "" : " ") + name_in_checkpoint(word);
      if (std::filesystem::is_regular_file(word, error))
        fingerprint.push_back({name_in_checkpoint(word), stamp(word)});
    }
    fingerprint.push_back({"--" + name, all.empty() ? "none" : all});
  }
  for (const CloudInput& input : inputs.inputs) {
    const std::filesystem::path& file = input.name;
    const bool is_remote = is_remote_name(file.string());
    fingerprint.push_back(
        {name_in_checkpoint(is_remote ? file : std::filesystem::absolute(file).lexically_normal()),
         stamp(file)});
  }
  fingerprint.push_back({"number of files", std::to_string(inputs.size())});
  return fingerprint;
}

/// Whether a file, or the target of a link, is in a folder.
bool holds(const std::filesystem::path& folder, const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::path parent = file.parent_path(),
                              target = std::filesystem::canonical(file, error).parent_path();
  return same_file(folder, parent.empty() ? "." : parent) || (!target.empty() && same_file(folder, target));
}

/// Lets a run fail before it starts. Errors: the checkpoint is or holds the output, holds an input, exists
/// and may neither be resumed from nor replaced, or is another folder; an input is a table of a database,
/// whose changes would not be detected.
void check_reading_checkpoint(const CheckpointRequest& request, bool overwrite,
                              const std::filesystem::path& output, const CloudInputs& inputs) {
  if (request.file.empty()) return;
  const std::filesystem::path& folder = request.file;
  if (same_file(folder, output) || holds(folder, output))
    throw file_error(folder, "the checkpoint is or holds the output", "another folder");
  for (const CloudInput& input : inputs.inputs) {
    if (input.is(database::k_sqlite_format) || input.is(database::k_server_format))
      throw file_error(input.name, "--checkpoint does not find changes of tables", "cloud files");
    if (!is_remote_name(input.name.string()) && holds(folder, input.name))
      throw file_error(folder, "the checkpoint holds the input " + input.name.string(), "another folder");
  }
  std::error_code error;
  if (!std::filesystem::exists(folder, error)) return;
  if (!is_scratch_checkpoint(folder))
    throw file_error(folder, "not an index checkpoint",
                     "a checkpoint, or the name of a folder that does not exist");
  if (!request.resume && !overwrite)
    throw file_error(folder, "the folder exists", "--resume to continue from it, or --overwrite");
}

/// The checkpoint of a reading, if one is requested. It is valid for the same files, by name, size and time
/// of the last change (remote ones: the server's version), the same version of the program, and the same
/// options but for threads, memory, and names of outputs.
class ReadingCheckpoint {
 public:
  /// Prints what it resumes from. Errors: those of ScratchCheckpoint.
  ReadingCheckpoint(const CheckpointRequest& request, const CloudInputs& inputs, Verbosity verbosity);
  /// Prints how to resume if the run was not finished; removes a checkpoint without points.
  ~ReadingCheckpoint();
  ReadingCheckpoint(const ReadingCheckpoint&) = delete;
  ReadingCheckpoint& operator=(const ReadingCheckpoint&) = delete;

  /// Null if none is requested.
  ScratchCheckpoint* checkpoint() { return checkpoint_ ? &*checkpoint_ : nullptr; }
  /// Removes the checkpoint: the output is written.
  void finish();

 private:
  Verbosity verbosity_;
  std::optional<ScratchCheckpoint> checkpoint_;
};

ReadingCheckpoint::ReadingCheckpoint(const CheckpointRequest& request, const CloudInputs& inputs,
                                     Verbosity verbosity)
    : verbosity_(verbosity) {
  if (request.file.empty()) return;
  checkpoint_.emplace(PartsOptions{.file = request.file,
                                   .interval = request.interval,
                                   .resume = request.resume,
                                   .failed = checkpoint_warning(),
                                   .is_interrupted = interrupted},
                      reading_fingerprint(*request.fields, inputs));
  if (!request.resume) return;
  const std::string name = request.file.string();
  if (checkpoint_->rows() > 0) {
    say_note(verbosity, fmt::format("resuming from {}: {} points are read", name, checkpoint_->rows()));
  } else {
    say_note(verbosity, (checkpoint_->resumes() ? name + " has no points yet" : "no checkpoint " + name) +
                            ": starting from the beginning");
  }
}

ReadingCheckpoint::~ReadingCheckpoint() {
  if (!checkpoint_) return;
  if (checkpoint_->rows() == 0) {
    checkpoint_->remove();
  } else if (!checkpoint_->is_corrupt()) {
    Console console(verbosity_);
    jobs::say_how_to_resume(console, checkpoint_->folder().string());
  }
}

void ReadingCheckpoint::finish() {
  if (checkpoint_) checkpoint_->remove();
  checkpoint_.reset();
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
  Console console(command.verbosity);
  check_room(folder, bytes, console);
}

/// For clouds larger than memory.
void write_large_index(const IndexCommand& command) {
  ReadingCheckpoint reading(command.checkpoint, command.files, command.verbosity);
  ScratchSpace scratch = *scratch_beside(command.output, command.memory);
  if (reading.checkpoint()) scratch.folder = command.checkpoint.file;
  check_room_for(command, scratch.folder, reading.checkpoint() ? reading.checkpoint()->rows() : 0);
  {
    ScratchCloud cloud = with_progress("reading", "B", command.verbosity, [&](const Progress& progress) {
      return ScratchCloud(command.files,
                          {.attributes = command.attributes,
                           .color_depth = command.color_depth,
                           .partial = command.partial,
                           .progress = progress},
                          scratch, reading.checkpoint());
    });
    say_warnings(command.verbosity, cloud.facts().warnings);
    write_index(command.output, cloud, command.index, scratch, command.verbosity);
  }
  // NFS removes a file from its folder only when no program has it open.
  reading.finish();
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
  check_reading_checkpoint(command.checkpoint, index.overwrite, command.output, command.files);
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
  add_cloud_files(index.required(), "files", "FILE...", k_files_help, command->files, add_view_fields(index));
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
  add_checkpoint_fields(index.needs(add_scratch_memory(index, command->memory)), command->checkpoint,
                        "every --checkpoint-interval seconds", "index", "FOLDER");
  index.flag("--overwrite", "replace an existing output", command->index.overwrite);
  add_run_options(index, *command);
  return command_of(index, command, run);
}

}  // namespace alidade::tools
