// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <shared_mutex>

#include "renderer/checkpoint.h"
#include "renderer/image_state.h"
#include "renderer/render.h"
#include "renderer/tile_tracer.h"

namespace alidade::renderer {

/// Progress, previews, checkpoints and the time of a render while many threads work on its state. Whichever
/// thread adds samples when one of them is due does it; the others continue.
class RenderWatch {
 public:
  /// The options and the state must outlive it. `fingerprint` is that of the image, for checkpoints;
  /// `samples` those per pixel. Time begins now.
  RenderWatch(const RenderOptions& options, const ImageState& state, int samples, Fingerprint fingerprint);

  /// To be held while samples are added to the state.
  std::shared_lock<std::shared_mutex> adding() { return std::shared_lock(gate_); }

  /// Reports progress if none was reported for a while. Throws Cancelled as added() does.
  void look();

  /// So many camera samples have been added. Throws Cancelled in every thread once the render is to stop.
  void added(std::uint64_t samples);

  /// Whether the time limit has been reached.
  bool time_is_up() const { return options_.time_limit && seconds() >= *options_.time_limit; }

  /// An estimate of the camera samples that there will be in the end.
  void expect(std::uint64_t total) { expected_ = total; }

  /// Every pixel has a sample: the first preview, and from now on more.
  void every_pixel_has_a_sample();

  /// The last report and preview.
  void finish();

  /// Writes a checkpoint, if any are requested. No thread may be at work.
  void save();

  /// Spent on the image, before a resumption included.
  double seconds() const;

 private:
  using Clock = std::chrono::steady_clock;

  void report_progress(Clock::time_point now);
  void show_preview();
  void write_checkpoint_if_due(Clock::time_point now);
  std::uint64_t expected_total() const;

  const RenderOptions& options_;
  const ImageState& state_;
  const int samples_;
  const Fingerprint fingerprint_;
  const Clock::time_point start_ = Clock::now();
  std::shared_mutex gate_;  ///< shared: the state grows; alone: it is examined
  std::mutex mutex_;        ///< of all below
  Clock::time_point next_report_ = start_, next_preview_ = start_, next_checkpoint_ = start_;
  bool previews_ = false;
  std::atomic<std::uint64_t> done_{0}, expected_{0};
  std::atomic<bool> stopped_{false};
};

/// Brings an image under way to its end, pass by pass, in parallel. `floor`: see noise_floor(). `film` has
/// the layers of the pixels' centres that are requested. Throws Cancelled if the watch does; the state is
/// intact then, too.
void render_image(const RenderTask& task, const RenderOptions& options, double floor, ImageState& state,
                  RenderWatch& watch, image::Film& film);

}  // namespace alidade::renderer
