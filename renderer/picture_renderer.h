// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "renderer/render_watch.h"
#include "renderer/stop_rule.h"
#include "renderer/tile_tracer.h"

namespace alidade {

/// Brings a picture under way to its end, pass by pass, in parallel. Everything it is given must outlive it.
class PictureRenderer {
 public:
  /// `floor`: see noise_floor(). `film` has the layers of the pixels' centres that are asked for.
  PictureRenderer(const RenderTask& task, const RenderOptions& options, double floor, PictureState& state,
                  RenderWatch& watch, Film& film);

  /// Throws Cancelled if the watch says so; the state is whole then, too.
  void run();

 private:
  using Tiles = std::vector<std::size_t>;
  using Work = std::function<void(std::span<const std::size_t> tiles)>;

  void begin_passes();
  int next_pass_end() const;
  bool any_goes_on() const;
  void run_pass();
  void for_each_group(const Tiles& tiles, std::size_t size, const Work& work) const;
  void sample(std::span<const std::size_t> tiles);
  void fill(std::span<const std::size_t> tiles);
  void expect_total();

  const RenderTask& task_;
  PictureState& state_;
  RenderWatch& watch_;
  Film& film_;
  const Tiles order_;
  std::vector<std::uint8_t> filled_;  ///< by tile: the layers of the pixels' centres
  std::optional<StopRule> stop_rule_;
  const bool progressive_;
};

}  // namespace alidade
