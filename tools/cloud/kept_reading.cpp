// SPDX-License-Identifier: MIT
#include "tools/cloud/kept_reading.h"

#include <fmt/format.h>
#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "database/server/server_clouds.h"
#include "database/sqlite/stored_cloud.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

/// To be raised when the rows that are read from a file change.
constexpr const char* k_rows_version = "2";

/// The files are in the fingerprint one by one.
constexpr std::array<std::string_view, 1> k_own_silent_options = {"files"};

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

Fingerprint reading_fingerprint(const Options& command, const CloudInputs& inputs) {
  Fingerprint fingerprint{{"program version", ALIDADE_VERSION}, {"version of rows", k_rows_version}};
  for (const auto& [name, words] : command.given()) {
    if (is_silent(name, k_own_silent_options)) continue;
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

}  // namespace

void check_kept_reading(const CheckpointRequest& request, bool overwrite, const std::filesystem::path& output,
                        const CloudInputs& inputs) {
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

KeptReading::KeptReading(const CheckpointRequest& request, const CloudInputs& inputs, Verbosity verbosity)
    : verbosity_(verbosity) {
  if (request.file.empty()) return;
  checkpoint_.emplace(PartsOptions{.file = request.file,
                                   .interval = request.interval,
                                   .resume = request.resume,
                                   .failed = checkpoint_warning(),
                                   .is_interrupted = interrupted},
                      reading_fingerprint(*request.command, inputs));
  if (!request.resume) return;
  const std::string name = request.file.string();
  if (checkpoint_->rows() > 0) {
    say_note(verbosity, fmt::format("resuming from {}: {} points are read", name, checkpoint_->rows()));
  } else {
    say_note(verbosity, (checkpoint_->resumes() ? name + " has no points yet" : "no checkpoint " + name) +
                            ": starting from the beginning");
  }
}

KeptReading::~KeptReading() {
  if (!checkpoint_) return;
  if (checkpoint_->rows() == 0) {
    checkpoint_->remove();
  } else if (!checkpoint_->is_corrupt()) {
    say_how_to_resume(verbosity_, checkpoint_->folder().string());
  }
}

void KeptReading::finish() {
  if (checkpoint_) checkpoint_->remove();
  checkpoint_.reset();
}

}  // namespace alidade::tools
