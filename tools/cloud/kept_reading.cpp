// SPDX-License-Identifier: MIT
#include "tools/cloud/kept_reading.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"

namespace alidade::tools {
namespace {

/// To be raised when what is read into the rows changes.
constexpr const char* k_rows_version = "1";

/// The files are in the fingerprint one by one.
constexpr std::array<std::string_view, 11> k_silent_options = {
    "files",   "help",   "output",     "overwrite",           "threads", "quiet",
    "verbose", "memory", "checkpoint", "checkpoint-interval", "resume"};

/// Size and time of the last change of a file on a disk. Remote ones have neither before they are opened.
std::string stamp(const std::filesystem::path& file) {
  if (is_remote_name(file.string())) return fmt::format("{} bytes", InputFile(file).size());
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) return "missing";
  const auto changed = std::filesystem::last_write_time(file, error).time_since_epoch();
  return fmt::format("{} bytes of {}.{:09} s", size, changed.count() / 1'000'000'000,
                     changed.count() % 1'000'000'000);
}

Fingerprint reading_fingerprint(const Options& command, const CloudInputs& inputs) {
  Fingerprint fingerprint{{"version of rows", k_rows_version}};
  for (const auto& [name, words] : command.given()) {
    if (std::ranges::find(k_silent_options, name) != k_silent_options.end()) continue;
    fingerprint.push_back({"--" + name, words.empty() ? "none" : fmt::format("{}", fmt::join(words, " "))});
    std::error_code error;
    for (const std::string& word : words) {
      if (std::filesystem::is_regular_file(word, error)) fingerprint.push_back({word, stamp(word)});
    }
  }
  fingerprint.push_back({"number of files", std::to_string(inputs.size())});
  for (const CloudInput& input : inputs.inputs) {
    const std::filesystem::path& file = input.name;
    const bool is_remote = is_remote_name(file.string());
    fingerprint.push_back(
        {is_remote ? file.string() : std::filesystem::absolute(file).lexically_normal().string(),
         stamp(file)});
  }
  return fingerprint;
}

}  // namespace

void check_kept_reading(const CheckpointRequest& request, bool overwrite, const std::filesystem::path& output,
                        const CloudInputs& inputs) {
  if (request.file.empty()) return;
  const std::filesystem::path& folder = request.file;
  const std::filesystem::path parent = output.parent_path();
  if (same_file(folder, output) || same_file(folder, parent.empty() ? "." : parent))
    throw file_error(folder, "the checkpoint is or holds the output", "another folder");
  for (const CloudInput& input : inputs.inputs) {
    if (input.format && input.format->is_named && input.format->is_named(input.name.string()))
      throw file_error(input.name, "--checkpoint does not find changes of tables", "cloud files");
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
                                   .failed = checkpoint_warning()},
                      reading_fingerprint(*request.command, inputs));
  if (!request.resume) return;
  const std::string name = request.file.string();
  say_note(verbosity, checkpoint_->rows() > 0
                          ? fmt::format("resuming from {}: {} points are read", name, checkpoint_->rows())
                          : fmt::format("no checkpoint {}: starting from the beginning", name));
}

KeptReading::~KeptReading() {
  if (!checkpoint_) return;
  if (checkpoint_->rows() == 0) {
    checkpoint_->remove();
  } else {
    say_how_to_resume(verbosity_, checkpoint_->folder().string());
  }
}

void KeptReading::finish() {
  if (checkpoint_) checkpoint_->remove();
  checkpoint_.reset();
}

}  // namespace alidade::tools
