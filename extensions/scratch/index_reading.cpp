// SPDX-License-Identifier: MIT
#include "extensions/scratch/index_reading.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/date_time.h"
#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "extensions/scratch/scratch_checkpoint.h"
#include "extensions/scratch/scratch_cloud.h"
#include "jobs/cloud_formats.h"
#include "jobs/large_clouds.h"
#include "jobs/long_run.h"
#include "jobs/outputs.h"

namespace alidade::jobs {
namespace {

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
                                     .failed = checkpoint_warning(listener)},
                        reading_fingerprint(*request.fields, inputs),
                        [&listener] { return listener.stops(); });
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

/// The cloud of a reading, whose files a checkpoint may keep.
class ReadCloud final : public ScratchCloud {
 public:
  ReadCloud(const CloudInputs& inputs, const ReadOptions& options, const ScratchSpace& scratch,
            std::shared_ptr<ReadingCheckpoint> reading)
      : ScratchCloud(inputs, options, scratch, reading->checkpoint()), reading_(std::move(reading)) {}

  void finish() override {
    // NFS removes a file from its folder only when no program has it open.
    close();
    reading_->finish();
  }

 private:
  std::shared_ptr<ReadingCheckpoint> reading_;
};

}  // namespace

void add_reading_fields(const Fields& fields, IndexRequest& request) {
  add_checkpoint_fields(fields.needs(*add_scratch_memory(fields, request.memory)), request.checkpoint,
                        "every --checkpoint-interval seconds", "index", "FOLDER");
}

void check_reading(const IndexRequest& request) {
  const std::filesystem::path& folder = request.checkpoint.file;
  if (folder.empty()) return;
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

std::unique_ptr<LargeCloud> read_for_index(const IndexRequest& request, const ReadOptions& options,
                                           const ScratchSpace& scratch, Listener& listener) {
  const auto reading = std::make_shared<ReadingCheckpoint>(request.checkpoint, request.files, listener);
  ScratchCheckpoint* const checkpoint = reading->checkpoint();
  const ScratchSpace space{checkpoint ? request.checkpoint.file : scratch.folder, scratch.memory};
  check_room_for_index(request, space.folder, checkpoint ? checkpoint->rows() : 0, listener);
  return in_stage(listener, "reading", "B", [&](const Progress& progress) {
    ReadOptions with_progress = options;
    with_progress.progress = progress;
    return std::make_unique<ReadCloud>(request.files, with_progress, space, reading);
  });
}

}  // namespace alidade::jobs
