// SPDX-License-Identifier: MIT
#include "jobs/clouds/index.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/date_time.h"
#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "base/scratch_checkpoint.h"
#include "jobs/cloud_fields.h"
#include "jobs/outputs.h"
#include "octree/index_file/save_index.h"
#include "octree/point_surface.h"
#include "octree/spacing.h"

namespace alidade::jobs {
namespace {

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

/// To be raised when the rows that are read from a file change.
constexpr const char* k_rows_version = "2";

/// The files are in the fingerprint one by one.
constexpr std::array<std::string_view, 1> k_fields_beside_rows = {"files"};

/// Size and time of the last change of a local file; size and version of a remote one, by its server.
std::string stamp(const std::filesystem::path& file) {
  if (is_remote_name(file.string())) {
    const std::unique_ptr<RemoteFile> remote = open_remote_file(file.string());
    return fmt::format("{} bytes, version {}", remote->size(), remote->version());
  }
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) return "missing";
  const auto time = std::chrono::file_clock::to_sys(std::filesystem::last_write_time(file, error));
  const auto day = std::chrono::floor<std::chrono::days>(time);
  return fmt::format("{} bytes, changed {}", size,
                     date_time_text({day, std::chrono::duration<double>(time - day).count()}));
}

Fingerprint reading_fingerprint(const Fields& fields, const CloudInputs& inputs) {
  Fingerprint fingerprint{{"program version", ALIDADE_VERSION}, {"version of rows", k_rows_version}};
  for (const auto& [name, words] : fields.given()) {
    if (is_silent(name, k_fields_beside_rows)) continue;
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

void check_checkpoint_folder(const IndexRequest& request) {
  const std::filesystem::path& folder = request.checkpoint.file;
  if (folder.empty()) return;
  check_that(request.memory.has_value(), "--checkpoint requires --memory");
  if (same_file(folder, request.output) || holds(folder, request.output))
    throw file_error(folder, "the checkpoint is or holds the output", "another folder");
  for (const CloudInput& input : request.files.inputs) {
    if (is_in_database(input))
      throw file_error(input.name, "--checkpoint does not find changes of tables", "cloud files");
    if (!is_remote_name(input.name.string()) && holds(folder, input.name))
      throw file_error(folder, "the checkpoint holds the input " + input.name.string(), "another folder");
  }
  std::error_code error;
  if (!std::filesystem::exists(folder, error)) return;
  if (!is_scratch_checkpoint(folder))
    throw file_error(folder, "not an index checkpoint",
                     "a checkpoint, or the name of a folder that does not exist");
  if (!request.checkpoint.resume && !request.overwrite)
    throw file_error(folder, "the folder exists", "--resume to continue from it, or --overwrite");
}

/// The checkpoint of a reading, if one is requested.
class ReadingCheckpoint {
 public:
  /// Notes what it resumes from. Errors: those of ScratchCheckpoint.
  ReadingCheckpoint(const CheckpointRequest& request, const CloudInputs& inputs, Listener& listener)
      : listener_(listener) {
    if (request.file.empty()) return;
    checkpoint_.emplace(PartsOptions{.file = request.file,
                                     .interval = request.interval,
                                     .resume = request.resume,
                                     .failed = checkpoint_warning(listener),
                                     .is_interrupted = [&listener] { return listener.stops(); }},
                        reading_fingerprint(*request.fields, inputs));
    if (!request.resume) return;
    const std::string name = request.file.string();
    if (checkpoint_->rows() > 0) {
      listener.note(fmt::format("resuming from {}: {} points are read", name, checkpoint_->rows()));
    } else {
      listener.note((checkpoint_->resumes() ? name + " has no points yet" : "no checkpoint " + name) +
                    ": starting from the beginning");
    }
  }
  /// Notes how to resume if the run was not finished; removes a checkpoint without points.
  ~ReadingCheckpoint() {
    if (!checkpoint_) return;
    if (checkpoint_->rows() == 0) {
      checkpoint_->remove();
    } else if (!checkpoint_->is_corrupt()) {
      say_how_to_resume(listener_, checkpoint_->folder().string());
    }
  }
  ReadingCheckpoint(const ReadingCheckpoint&) = delete;
  ReadingCheckpoint& operator=(const ReadingCheckpoint&) = delete;

  /// Null if none is requested.
  ScratchCheckpoint* checkpoint() { return checkpoint_ ? &*checkpoint_ : nullptr; }

  /// Removes the checkpoint: the output is written.
  void finish() {
    if (checkpoint_) checkpoint_->remove();
    checkpoint_.reset();
  }

 private:
  Listener& listener_;
  std::optional<ScratchCheckpoint> checkpoint_;
};

/// check_room() for all that the disk holds while an index is made. The size of a selection is not known
/// beforehand, and not checked.
void check_room_for_index(const IndexRequest& request, const std::filesystem::path& folder,
                          std::uint64_t rows_there, Listener& listener) {
  StatedSize size = stated_size(request.files);
  if (!knows_point_count(request.files, request.partial, size)) return;
  size.attributes = size.attributes & request.attributes;
  // The points in Morton order take 16 bytes each, the octree at most 24. Columns make room for those of the
  // index, and positions for the points in order; a checkpoint keeps both. Later measurements take less than
  // the points in order, which are removed before.
  constexpr std::uint64_t k_sorted = 16, k_octree = 24;
  const std::uint64_t columns = size.bytes() - size.point_count * sizeof(LatticePosition);
  std::uint64_t bytes = columns + size.point_count * (k_sorted + k_octree);
  if (!request.checkpoint.file.empty()) {
    bytes = size.bytes() +
            std::max(size.point_count * (k_sorted + k_octree), columns + size.point_count * k_octree);
    bytes -=
        size.bytes() / std::max<std::uint64_t>(size.point_count, 1) * std::min(rows_there, size.point_count);
  }
  check_room(folder, bytes, listener);
}

Octree measured(const Octree& octree, const IndexContents& contents, Listener& listener) {
  const std::optional<int> neighbours =
      contents.surfaces ? k_surface_neighbours : contents.spacing_neighbours;
  if (!neighbours) return octree;
  const Octree with = with_spacings(octree, *neighbours, listener);
  return contents.surfaces ? with_surfaces(with, listener) : with;
}

}  // namespace

void add_index_fields(const Fields& fields, IndexRequest& request) {
  IndexContents& contents = request.contents;
  add_cloud_files(fields.required(), "files", "FILE...", k_files_help, request.files,
                  add_view_fields(fields));
  fields.required().file("-o,--output", "FILE.alidade", "output index file", request.output);
  fields.choice(
      "--organisation",
      "how the octree stores points, without effect on answers (default adaptive): cells split until few "
      "points remain, a grid of equal cells, or coarse to fine, so that the first levels are a thinned cloud",
      contents.organisation,
      {{"adaptive", Organisation::adaptive},
       {"fixed", Organisation::fixed},
       {"layered", Organisation::layered}});
  fields.length("--cell-size", "LENGTH",
                "longest side of a cell of --organisation fixed, in the unit of the CRS, mostly metres "
                "(default: cells with 32 points on average)",
                contents.cell_size);
  fields.flag("--stored-order",
              "number the points in the order of the octree: saves 4 bytes per point, but point ids differ "
              "from those of the input",
              contents.stored_order);
  fields.choice("--color-depth",
                "bits in use of LAS colours (default: 8 if none exceeds 255); colours of 8 bits take "
                "3 bytes per point in the index, others 6",
                request.color_depth, {{"8", ColorDepth::bits_8}, {"16", ColorDepth::bits_16}});
  fields.value("--attributes", "LIST",
               "attributes to keep, by the names that 'alidade info' prints, such as "
               "color,intensity,classification, or none (default: all)",
               request.attributes, parse_attributes);
  fields.count("--spacings", "N",
               "store the distance of every point to its N-th nearest neighbour, 1 to 64 (usually 8): "
               "'alidade render --radius adapted' then measures nothing; 2 bytes per point and 16 per node",
               contents.spacing_neighbours, 1, k_most_spacing_neighbours);
  fields.flag("--surfaces",
              "store the surface around each point for 'alidade visibility', which then measures nothing; "
              "implies --spacings 8; 4 bytes per point",
              contents.surfaces);
  add_checkpoint_fields(fields.needs(add_scratch_memory(fields, request.memory)), request.checkpoint,
                        "every --checkpoint-interval seconds", "index", "FOLDER");
  fields.flag("--overwrite", "replace an existing output", request.overwrite);
  add_partial(fields, request.partial);
}

IndexPlan plan(const IndexRequest& request) {
  const IndexContents& contents = request.contents;
  check_that(contents.cell_size == 0.0 || contents.organisation == Organisation::fixed,
             "--cell-size requires --organisation fixed");
  check_extension(request.output, {".alidade"});
  if (contents.surfaces && contents.spacing_neighbours &&
      *contents.spacing_neighbours != k_surface_neighbours) {
    throw input_error("--surfaces requires the 8th neighbour", "--spacings 8, or none",
                      std::to_string(*contents.spacing_neighbours));
  }
  check_that(!request.memory || !contents.stored_order, "--memory excludes --stored-order");
  check_writable(request.output, request.overwrite, request.inputs());
  check_checkpoint_folder(request);
  // Points in scratch files take memory of that size only.
  return IndexPlan(request, {.clouds = request.files,
                             .partial = request.partial,
                             .writes = {request.output, request.checkpoint.file},
                             .bytes_per_point = request.memory ? 0.0 : 39.0});
}

IndexResult run(const IndexPlan& plan, Listener& listener) {
  const IndexRequest& request = plan.request();
  ReadingCheckpoint reading(request.checkpoint, request.files, listener);
  std::optional<ScratchSpace> scratch = scratch_beside(request.output, request.memory);
  if (scratch) {
    if (reading.checkpoint()) scratch->folder = request.checkpoint.file;
    check_room_for_index(request, scratch->folder, reading.checkpoint() ? reading.checkpoint()->rows() : 0,
                         listener);
  }
  IndexResult result;
  {
    HeldCloud cloud = hold_cloud(
        request.files,
        {.attributes = request.attributes, .color_depth = request.color_depth, .partial = request.partial},
        scratch, listener, reading.checkpoint());
    warn_all(listener, facts_of(cloud).warnings);
    result = write_index(request.output, cloud, request.contents, request.overwrite, scratch, listener);
  }
  // NFS removes a file from its folder only when no program has it open.
  reading.finish();
  return result;
}

IndexResult write_index(const std::filesystem::path& path, HeldCloud& cloud, const IndexContents& contents,
                        bool overwrite, const std::optional<ScratchSpace>& scratch, Listener& listener) {
  auto* const in_memory = std::get_if<PointCloud>(&cloud);
  Octree octree = in_stage(listener, "building", "points", [&](const Progress& progress) {
    const BuildOptions options{
        .organisation = contents.organisation, .cell_size = contents.cell_size, .progress = progress};
    if (in_memory == nullptr) {
      ScratchCloud& held = std::get<ScratchCloud>(cloud);
      return build_in_scratch(held.facts().lattice, held.positions(), *scratch, options);
    }
    return contents.stored_order ? build_in_stored_order(*in_memory, options)
                                 : build(std::move(*in_memory), options);
  });
  octree = measured(octree, contents, listener);
  in_stage(listener, "writing", "B", [&](const Progress& progress) {
    SaveIndexOptions options{.overwrite = overwrite, .progress = progress};
    if (in_memory == nullptr) options.written = discard_scratch_pages;
    save_index(path, octree, facts_of(cloud), points_of(cloud).attributes, options);
  });
  const IndexResult result{octree.size(), std::filesystem::file_size(path), octree.memory()};
  const auto per_point = [&](std::uint64_t bytes) {
    return octree.size() > 0 ? static_cast<double>(bytes) / static_cast<double>(octree.size()) : 0.0;
  };
  listener.note(fmt::format("{} points, {:.1f} bytes each, {:.1f} of them octree; wrote {}", octree.size(),
                            per_point(result.bytes), per_point(result.octree_bytes), path.string()));
  return result;
}

}  // namespace alidade::jobs
