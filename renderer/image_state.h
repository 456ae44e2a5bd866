// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "image/film.h"
#include "renderer/integrator.h"
#include "renderer/render.h"
#include "renderer/tile_tracer.h"

namespace alidade::renderer {

/// What the samples of a row of tiles have added up to, by pixel, rows one after another. Memory per pixel:
/// 28 bytes, 52 with the sums for noise.
struct SumBand {
  std::vector<glm::dvec3> mean;
  std::vector<std::uint32_t> met_count;  ///< samples whose first ray met a surface
  // Only with noise:
  std::vector<glm::vec3> squares;  ///< sum of squared differences from the mean (Welford 1962)
  std::vector<glm::vec3> earlier;  ///< the mean when the number of samples was last a power of two
};

/// Squared differences between the mean of the first 2^(j+1) samples and that of the first 2^j, summed over
/// the channels and pixels of a tile; j is the index in the array. k_max_samples is 2^24.
using LevelSums = std::array<double, 24>;

/// How far a tile has come.
struct TileState {
  std::uint32_t samples = 0;    ///< of each of its pixels
  bool stopped = false;         ///< its noise is low enough
  std::uint64_t ray_count = 0;  ///< rays its samples took
};

/// The tiles of a part, along Morton's curve: paths of neighbouring tiles meet the same part of the cloud.
std::vector<std::size_t> tiles_of(const TileGrid& grid, ImagePart part);

/// An image under way, or a part of one: all that a resumed render needs. Memory beside the bands: about 1
/// byte per pixel. Different tiles may be worked on by different threads.
struct ImageState {
  TileGrid grid;
  std::vector<std::size_t> order;  ///< tiles_of() what is rendered
  bool with_noise = false;
  std::vector<SumBand> bands;  ///< by row of tiles
  std::vector<TileState> tiles;
  std::vector<LevelSums> levels;  ///< by tile; empty without noise
  int pass_end = 0;  ///< every tile is to reach this many samples, or stopped before, or more are requested
  double seconds = 0.0;  ///< spent on it before the last resumption

  ImageState(int width, int height, bool with_noise, ImagePart part = {});

  /// Camera samples taken.
  std::uint64_t sample_count() const;
  std::uint64_t ray_count() const;
};

/// Adds the next samples of a tile: the same number for each pixel, pixel by pixel in rows. The result does
/// not depend on how the samples are dealt out over calls.
void add_samples(ImageState& state, std::size_t tile, std::span<const PathResult> results);

/// The image so far, colour and alpha only: each pixel the mean of a square of pixels, as small as
/// keeps width and height at or below `longest_side`. Pixels without samples are black.
image::Film reduced(const ImageState& state, int longest_side);

/// Turns the sums into the film's colour and alpha, which must be empty, and its variance if that is
/// requested (the sums for noise must be there). Each band is freed as soon as it has been read, so that the
/// film replaces the sums in memory.
void move_into_film(ImageState& state, bool with_variance, image::Film& film);

}  // namespace alidade::renderer
