// SPDX-License-Identifier: MIT
#include "jobs/checkpoint_request.h"

#include <fmt/format.h>
#include <functional>

#include "base/error.h"

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

std::function<void(const Error&)> checkpoint_warning(Listener& listener) {
  return [&listener, said = false](const Error& error) mutable {
    if (!said) listener.warn_always(std::string("no checkpoint: ") + error.what());
    said = true;
  };
}

void say_how_to_resume(Listener& listener, const std::string& checkpoint) {
  listener.note("saved to " + checkpoint + "; the same command with --resume continues");
}

}  // namespace alidade::jobs
