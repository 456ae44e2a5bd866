// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "camera/projection.h"
#include "image/film.h"
#include "renderer/integrator.h"
#include "renderer/tile_grid.h"

namespace alidade {

/// Everything a pixel needs; the same for all of them.
struct RenderTask {
  const Projection& projection;
  const RenderSettings& settings;
  const World& world;
  const Lights& lights;
  double ao_distance;
};

/// Paths traced together: more share more of the cloud, fewer stay in the processor's second-level cache.
inline constexpr std::size_t k_most_paths = 4096;

/// The samples first .. last - 1 of every pixel of a box.
struct TileSamples {
  TileBox box;
  std::uint32_t first = 0, last = 0;

  std::size_t count() const { return box.count() * (last - first); }
};

/// Traces them together: box after box, pixel by pixel in rows, sample by sample. Where the lens has no view,
/// there is no light and no surface. A sample is the same however samples are put together.
std::vector<PathResult> sample_tiles(const RenderTask& task, std::span<const TileSamples> work);

/// Gives the pixels of a box what their centres see, in the layers that the film holds (colour and variance
/// are left alone).
void fill_center_layers(const RenderTask& task, const TileBox& box, Film& film);

}  // namespace alidade
