// SPDX-License-Identifier: MIT
#include "jobs/long_run.h"

#include <fmt/format.h>
#include <functional>
#include <system_error>

#include "base/error.h"
#include "base/output_file.h"
#include "jobs/outputs.h"

namespace alidade::jobs {

void add_checkpoint_fields(const Fields& fields, CheckpointRequest& request, const std::string& when,
                           const std::string& output, const std::string& kind) {
  constexpr double k_most_seconds = 1e9;
  request.fields = fields;
  const Field checkpoint =
      fields.value("--checkpoint", kind,
                   fmt::format("save finished work to {}, {} and on Ctrl-C; deleted once the {} is written",
                               kind, when, output),
                   request.file, std::identity());
  fields.needs(checkpoint)
      .number("--checkpoint-interval", "S", "seconds between checkpoints, above 0 (default 60)",
              request.interval, 1e-3, k_most_seconds);
  fields.needs(checkpoint)
      .flag("--resume",
            fmt::format(
                "continue from the checkpoint if it exists; the {} has the bytes of an uninterrupted run",
                output),
            request.resume);
}

std::string wrote_text(const JobRequest& request) {
  return request.output.empty() ? "" : "; wrote " + request.output.string();
}

void check_checkpoint(const CheckpointRequest& request, bool overwrite, PlannedWork& work,
                      bool (*is_kind)(const std::filesystem::path&), const char* kind) {
  if (request.file.empty()) return;
  if (is_kind == is_parts_file && !request.fields)
    throw input_error("a checkpoint of a request without fields", "add_checkpoint_fields() for the request");
  std::error_code error;
  for (const std::filesystem::path& output : work.writes) {
    if (!output.empty() && same_file(request.file, output))
      throw file_error(request.file, "two outputs have this name", "another name");
  }
  const bool is_there = std::filesystem::exists(request.file, error);
  if (is_there && !request.resume && !overwrite)
    throw file_error(request.file, "the file exists", "--resume to continue from it, or --overwrite");
  if (!overwrite) check_links(request.file);
  check_outputs({.clouds = work.clouds, .reads = work.reads, .writes = {request.file}}, true);
  // Another file would be replaced, and removed in the end.
  if (is_there && !is_kind(request.file)) {
    throw Error({.file = request.file.string(),
                 .location = "byte 0",
                 .problem = std::string("not ") + kind,
                 .expected = "a checkpoint, or the name of a file that does not exist"});
  }
  work.writes.push_back(request.file);
}

std::function<void(const Error&)> checkpoint_warning(Listener& listener) {
  return [&listener, said = false](const Error& error) mutable {
    if (!said) listener.warn_always(std::string("no checkpoint: ") + error.what());
    said = true;
  };
}

std::string beginning_text(const CheckpointRequest& request) {
  return fmt::format("no checkpoint {}: starting from the beginning", request.file.string());
}

void say_how_to_resume(Listener& listener, const std::string& checkpoint) {
  listener.note("saved to " + checkpoint + "; the same command with --resume continues");
}

LongRun::LongRun(const CheckpointRequest& request, const std::function<Fingerprint()>& fingerprint,
                 Listener& listener)
    : listener_(listener) {
  if (request.file.empty()) return;
  const std::string name = request.file.string();
  PartsOptions options{.file = request.file,
                       .interval = request.interval,
                       .resume = request.resume,
                       .failed = checkpoint_warning(listener)};
  parts_.emplace(std::move(options), fingerprint());
  if (!request.resume) return;
  if (parts_->is_kept()) {
    listener.note(fmt::format("resuming from {}: {:.0f} % of the work is done", name,
                              100.0 * static_cast<double>(parts_->finished()) /
                                  static_cast<double>(std::max<std::uint64_t>(parts_->count(), 1))));
  } else {
    listener.note(beginning_text(request));
  }
}

LongRun::~LongRun() {
  if (!parts_ || !parts_->is_kept()) return;
  parts_->flush();
  if (parts_->finished() == 0) return;
  say_how_to_resume(listener_, parts_->name());
}

Progress LongRun::progress(Listener::Stage& stage) {
  return [this, &stage, report = stage.callback()](std::uint64_t done, std::uint64_t total) {
    if (parts_ && !parts_->has_begun()) stage.skip(done);
    return report(done, total);
  };
}

void LongRun::finish() {
  if (parts_) parts_->remove();
}

}  // namespace alidade::jobs
