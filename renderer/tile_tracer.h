// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "camera/projection.h"
#include "image/film.h"
#include "image/pixel_box.h"
#include "renderer/integrator.h"

namespace alidade::renderer {

/// An image cut evenly into tiles of about 16 x 16 pixels, 12 to 23 on a side where the image is at least
/// 12 wide and high, so that none is a sliver. Tiles are numbered row by row.
class TileGrid {
 public:
  TileGrid() = default;
  TileGrid(int width, int height)
      : width_(width), height_(height), columns_(tiles_along(width)), rows_(tiles_along(height)) {}

  int width() const { return width_; }    ///< of the image, pixels
  int height() const { return height_; }  ///< of the image, pixels
  std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(width_) * static_cast<std::uint64_t>(height_);
  }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  std::size_t count() const { return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_); }

  int column_of(std::size_t tile) const {
    return static_cast<int>(tile % static_cast<std::size_t>(columns_));
  }
  int row_of(std::size_t tile) const { return static_cast<int>(tile / static_cast<std::size_t>(columns_)); }
  std::size_t tile_at(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  image::PixelBox box(std::size_t tile) const {
    const int column = column_of(tile), row = row_of(tile);
    return {width_ * column / columns_, height_ * row / rows_, width_ * (column + 1) / columns_,
            height_ * (row + 1) / rows_};
  }

  /// All pixels of a row of tiles.
  image::PixelBox band(int row) const {
    return {0, height_ * row / rows_, width_, height_ * (row + 1) / rows_};
  }

 private:
  static constexpr int k_side = 16;

  static int tiles_along(int pixels) { return std::max(1, (pixels + k_side / 2) / k_side); }

  int width_ = 0, height_ = 0, columns_ = 1, rows_ = 1;
};

/// Everything a pixel needs; the same for all of them.
struct RenderTask {
  const camera::Projection& projection;
  const RenderSettings& settings;
  const World& world;
  const Lights& lights;
  double ao_distance;
  bool hides_sky;  ///< from the camera: OutputSettings::transparent, background
  /// Called by every thread between the steps of its paths; what it throws ends the work. Empty: never.
  std::function<void()> look{};
};

/// Paths traced together: more share more of the cloud and take more memory, up to 1.5 kB each.
inline constexpr std::size_t k_most_paths = 16384;

/// The samples first .. last - 1 of every pixel of a box.
struct TileSamples {
  image::PixelBox box;
  std::uint32_t first = 0, last = 0;

  std::size_t count() const { return box.count() * (last - first); }
};

/// Traces them together: box after box, pixel by pixel in rows, sample by sample. Where the lens has no view,
/// there is no light and no surface. A sample is the same however samples are put together.
std::vector<PathResult> sample_tiles(const RenderTask& task, std::span<const TileSamples> work);

/// Gives the pixels of a box what their centres see, in the layers that the film holds (colour and variance
/// are left alone).
void fill_center_layers(const camera::Projection& projection, const World& world, const image::PixelBox& box,
                        image::Film& film);

}  // namespace alidade::renderer
