// SPDX-License-Identifier: MIT
#include "renderer/image_renderer.h"

#include <tbb/task_arena.h>
#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "renderer/noise.h"

namespace alidade::renderer {
namespace {

using Clock = std::chrono::steady_clock;

/// A moment so many seconds from now, at most a year.
Clock::time_point after(Clock::time_point now, double seconds) {
  constexpr double k_year = 3e7;
  return now + std::chrono::duration_cast<Clock::duration>(
                   std::chrono::duration<double>(std::min(seconds, k_year)));
}

/// What render_image() does.
class ImageRenderer {
 public:
  ImageRenderer(const RenderTask& task, const RenderOptions& options, double floor, ImageState& state,
                RenderWatch& watch, image::Film& film)
      : task_(task),
        state_(state),
        watch_(watch),
        film_(film),
        order_(state.order),
        filled_(state.tiles.size(), film.holds_any() ? 0 : 1),
        progressive_(options.preview || options.time_limit || options.target_noise) {
    if (options.target_noise) stop_rule_.emplace(*options.target_noise, floor);
    // With a target a pass is judged where an uninterrupted render does so. Otherwise the checkpoint may come
    // from one that had other passes.
    if (state_.pass_end == 0 || !stop_rule_) begin_passes();
  }

  void run() {
    bool every_pixel = false;
    expect_total();
    for (bool more = true; more;) {
      run_pass();
      if (!every_pixel) watch_.every_pixel_has_a_sample();
      every_pixel = true;
      if (stop_rule_) stop_rule_->apply(state_);
      more = state_.pass_end < task_.settings.samples && !watch_.time_is_up() &&
             !std::ranges::all_of(state_.tiles, &TileState::stopped);
      if (more) state_.pass_end = next_pass_end();
      expect_total();
    }
    // Tiles that were finished before a resumption still lack them.
    for_each_group(order_, 1, [this](std::span<const std::size_t> group) { fill(group); });
  }

 private:
  using Tiles = std::vector<std::size_t>;

  /// Sets the end of the first pass that gives any tile samples.
  void begin_passes() {
    int fewest = order_.empty() ? 0 : task_.settings.samples;
    for (const std::size_t tile : order_)
      fewest = std::min(fewest, static_cast<int>(state_.tiles[tile].samples));
    state_.pass_end = 0;
    do state_.pass_end = next_pass_end();
    while (state_.pass_end <= fewest && state_.pass_end < task_.settings.samples);
  }

  /// Without previews or limits one pass is best: each tile from its first sample to its last.
  /// Otherwise the number of samples doubles up to a step of 16, so that no tile has more than twice as many
  /// as another.
  int next_pass_end() const {
    constexpr int k_step = 16;
    const int reached = state_.pass_end, all = task_.settings.samples;
    if (!progressive_) return all;
    return std::min(all, reached < k_step ? std::max(1, 2 * reached) : reached + k_step);
  }

  void run_pass() {
    Tiles due;
    std::uint32_t fewest = 0;
    for (const std::size_t tile : order_) {
      const TileState& reached = state_.tiles[tile];
      if (reached.stopped || reached.samples >= static_cast<std::uint32_t>(state_.pass_end)) continue;
      if (due.empty() || reached.samples < fewest) fewest = reached.samples;
      due.push_back(tile);
    }
    if (due.empty()) return;
    // With few samples each, several tiles make a batch; but every thread is to have several.
    constexpr std::size_t k_tile_pixels = 256, k_batches_of_thread = 4;
    const std::size_t step = static_cast<std::uint32_t>(state_.pass_end) - fewest;
    const std::size_t most =
        std::min(k_most_paths / (k_tile_pixels * step), due.size() / (k_batches_of_thread * thread_count()));
    for_each_group(due, std::max<std::size_t>(1, most), [this](std::span<const std::size_t> group) {
      fill(group);
      sample(group);
    });
  }

  template <class Work>
  void for_each_group(const Tiles& tiles, std::size_t size, const Work& work) const {
    in_blocks(tiles.size(), size, [&](std::size_t begin, std::size_t end) {
      // Threads have tiles of their own: the rays of one are not to be shared out again.
      tbb::task_arena alone(1);
      alone.execute([&] { work(std::span(tiles).subspan(begin, end - begin)); });
    });
  }

  /// Brings some tiles to the end of the pass, or as far as time allows. The first sample is always taken.
  void sample(std::span<const std::size_t> tiles) {
    std::size_t pixels = 0;
    for (const std::size_t tile : tiles) pixels += state_.grid.box(tile).count();
    const auto at_once = static_cast<std::uint32_t>(std::max<std::size_t>(1, k_most_paths / pixels));
    std::vector<TileSamples> work;
    Tiles working;
    for (;;) {
      const bool time_is_up = watch_.time_is_up();
      work.clear();
      working.clear();
      std::size_t count = 0;
      for (const std::size_t tile : tiles) {
        const std::uint32_t first = state_.tiles[tile].samples,
                            last = std::min(first + at_once, static_cast<std::uint32_t>(state_.pass_end));
        if (first >= last || (time_is_up && first > 0)) continue;
        work.push_back({state_.grid.box(tile), first, last});
        working.push_back(tile);
        count += work.back().count();
      }
      if (work.empty()) return;
      std::vector<PathResult> results = sample_tiles(task_, work);
      for (PathResult& result : results)
        if (task_.hides_sky && !result.met_surface) result.radiance = Rgb(0.0f);
      {
        const auto adding = watch_.adding();
        std::span<const PathResult> rest(results);
        for (std::size_t i = 0; i < work.size(); ++i) {
          add_samples(state_, working[i], rest.first(work[i].count()));
          rest = rest.subspan(work[i].count());
        }
      }
      watch_.added(count);
    }
  }

  void fill(std::span<const std::size_t> tiles) {
    for (const std::size_t tile : tiles) {
      if (filled_[tile] != 0) continue;
      watch_.look();
      fill_center_layers(task_.projection, task_.world, state_.grid.box(tile), film_);
      filled_[tile] = 1;
    }
  }

  void expect_total() {
    double total = 0.0;
    for (const std::size_t tile : order_) {
      const double samples = stop_rule_ ? stop_rule_->expected_samples(state_, tile, task_.settings.samples)
                                        : task_.settings.samples;
      total += samples * static_cast<double>(state_.grid.box(tile).count());
    }
    watch_.expect(static_cast<std::uint64_t>(total));
  }

  const RenderTask& task_;
  ImageState& state_;
  RenderWatch& watch_;
  image::Film& film_;
  const Tiles& order_;
  std::vector<std::uint8_t> filled_;  ///< by tile: the layers of the pixels' centres
  std::optional<StopRule> stop_rule_;
  const bool progressive_;
};

}  // namespace

RenderWatch::RenderWatch(const RenderOptions& options, const ImageState& state, int samples,
                         Fingerprint fingerprint)
    : options_(options), state_(state), samples_(samples), fingerprint_(std::move(fingerprint)) {
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

void RenderWatch::look() {
  if (stopped_) throw Cancelled();
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  // Most reports come with samples: this is for long waves.
  constexpr auto k_silence = std::chrono::milliseconds(200);
  const Clock::time_point now = Clock::now();
  if (lock && now >= next_report_ + k_silence) report_progress(now);
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
  image::Film film;
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
    write_checkpoint(checkpoint.file, fingerprint_, samples_, state_, seconds());
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
  write_checkpoint(options_.checkpoint->file, fingerprint_, samples_, state_, seconds());
}

void render_image(const RenderTask& task, const RenderOptions& options, double floor, ImageState& state,
                  RenderWatch& watch, image::Film& film) {
  ImageRenderer(task, options, floor, state, watch, film).run();
}

}  // namespace alidade::renderer
