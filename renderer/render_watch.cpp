// SPDX-License-Identifier: MIT
#include "renderer/render_watch.h"

#include <algorithm>
#include <cmath>

#include "renderer/checkpoint.h"

namespace alidade {
namespace {

using Clock = std::chrono::steady_clock;

/// A moment so many seconds from now; far ones are all the same.
Clock::time_point after(Clock::time_point now, double seconds) {
  constexpr double k_year = 3e7;
  return now + std::chrono::duration_cast<Clock::duration>(
                   std::chrono::duration<double>(std::min(seconds, k_year)));
}

}  // namespace

RenderWatch::RenderWatch(const RenderOptions& options, const PictureState& state, int samples,
                         PictureIdentity identity)
    : options_(options), state_(state), samples_(samples), identity_(std::move(identity)) {
  if (options_.checkpoint) next_checkpoint_ = after(start_, options_.checkpoint->interval);
  done_ = state_.sample_count();
}

double RenderWatch::seconds() const {
  return state_.seconds + std::chrono::duration<double>(Clock::now() - start_).count();
}

std::uint64_t RenderWatch::expected_total() const {
  const std::uint64_t done = done_, expected = std::max<std::uint64_t>(expected_, done);
  if (!options_.time_limit) return expected;
  const double spent = seconds(), limit = *options_.time_limit;
  if (!(spent > 0.0) || spent >= limit) return spent >= limit ? done : expected;
  const double in_time = static_cast<double>(done) * (limit / spent);
  return in_time < static_cast<double>(expected) ? std::max(done, static_cast<std::uint64_t>(in_time))
                                                 : expected;
}

void RenderWatch::added(std::uint64_t samples) {
  done_ += samples;
  if (stopped_) throw Cancelled();
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (!lock) return;
  const Clock::time_point now = Clock::now();
  report_progress(now);
  write_checkpoint_if_due(now);
  if (previews_ && now >= next_preview_) show_preview();
}

void RenderWatch::report_progress(Clock::time_point now) {
  if (!options_.progress || now < next_report_) return;
  next_report_ = now + std::chrono::milliseconds(50);
  const std::uint64_t done = done_;
  if (options_.progress(done, std::max(done, expected_total()))) return;
  stopped_ = true;
  throw Cancelled();
}

void RenderWatch::show_preview() {
  Film film;
  {
    const std::unique_lock<std::shared_mutex> alone(gate_);
    film = reduced(state_, options_.preview->longest_side);
  }
  options_.preview->show(film);
  next_preview_ = after(Clock::now(), options_.preview->interval);
}

void RenderWatch::write_checkpoint_if_due(Clock::time_point now) {
  constexpr double k_smallest_share = 10.0;
  if (!options_.checkpoint || now < next_checkpoint_) return;
  const CheckpointOptions& checkpoint = *options_.checkpoint;
  try {
    const std::unique_lock<std::shared_mutex> alone(gate_);
    write_checkpoint(checkpoint.file, identity_, samples_, state_, seconds());
  } catch (const Error& error) {
    if (!checkpoint.failed) throw;
    checkpoint.failed(error);
  }
  const Clock::time_point end = Clock::now();
  const double took = std::chrono::duration<double>(end - now).count();
  next_checkpoint_ = after(end, std::max(checkpoint.interval, k_smallest_share * took));
}

void RenderWatch::every_pixel_has_a_sample() {
  if (!options_.preview) return;
  const std::unique_lock<std::mutex> lock(mutex_);
  previews_ = true;
  show_preview();
}

void RenderWatch::finish() {
  const std::unique_lock<std::mutex> lock(mutex_);
  if (options_.preview) show_preview();
  report(options_.progress, done_, done_);
}

void RenderWatch::save() {
  if (!options_.checkpoint) return;
  write_checkpoint(options_.checkpoint->file, identity_, samples_, state_, seconds());
}

}  // namespace alidade
