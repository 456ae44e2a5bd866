// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/checkpoint.h"
#include "base/progress.h"
#include "camera/camera_set.h"
#include "cloud/attributes.h"
#include "cloud/select_points.h"
#include "image/read_image.h"
#include "visibility/observers.h"
#include "visibility/sight_line.h"

// Which photos see which points of a cloud, at which resolution, and in which colour.
//
//   const CameraSet set = camera::read_cameras("sparse/0");
//   const Occluders occluders(octree, {});
//   const PhotoVisibility seen = photo_visibility(occluders, set.cameras, {});
//   if (seen.counts[id] >= 3) use(seen.sampling[id]);

namespace alidade::visibility {

/// Photos as observers with their positions and names and all directions in view.
std::vector<Observer> photo_observers(std::span<const camera::NamedCamera> photos,
                                      double max_distance = std::numeric_limits<double>::infinity());

struct PhotoVisibilityOptions {
  double max_distance = std::numeric_limits<double>::infinity();  ///< no photo sees farther
  /// Returns the pixels of the photo of that index, of the size of its camera, for PhotoVisibility::colors;
  /// called in the order of the photos, for those that see a point. Empty: no colours. May throw.
  std::function<image::PhotoPixels(std::size_t photo)> read_photo{};
  std::optional<double> footprint_cell{};  ///< width of the cells of footprints; empty: footprint_cell()
  bool with_footprints = false;            ///< whether to make outlines
  PartCheckpoint* parts = nullptr;  ///< as PointVisibilityOptions::parts; its progress is in sight lines
  Progress progress{};
};

/// Points in one block of a SeenSet.
constexpr std::size_t k_seen_block = 4096;
using SeenBlock = std::array<std::uint64_t, k_seen_block / 64>;

/// The points that a photo sees, as bits in blocks; blocks without any are left out. If neighbours in space
/// have neighbouring numbers, a photo takes some bits per point that it sees.
struct SeenSet {
  std::vector<std::pair<std::uint32_t, SeenBlock>> blocks;  ///< by number, ascending

  std::uint64_t byte_count() const { return blocks.size() * sizeof(blocks[0]); }
};

/// Number of points that both of two photos see.
std::uint64_t common_points(const SeenSet& a, const SeenSet& b);

/// Two photos with points that both see.
struct PhotoOverlap {
  std::uint32_t first = 0, second = 0;  ///< indices of the photos, first < second
  std::uint64_t points = 0;             ///< seen by both, > 0
};

/// All pairs with points in common, by `first`, then `second`. The same on any number of threads. Cost: for
/// each pair linear in the blocks of both, 10^8 shared points per second and thread or more.
std::vector<PhotoOverlap> overlaps(const std::vector<SeenSet>& photos);

/// What one photo sees. Medians are over the points it sees; 0 if there are none.
struct PhotoSummary {
  std::uint64_t points = 0;
  double median_sampling = 0.0;  ///< ground sampling distance
  double median_distance = 0.0;
  double largest_overlap = 0.0;  ///< largest share of its points that another photo sees
  /// Outline of the map's cells with a point it sees; see outline(). Empty unless with_footprints is set.
  std::vector<PlanePolygon> footprint{};
};

/// Columns are by point id.
struct PhotoVisibility {
  /// Photos that see the point: it is in the frame (PhotoFrame) and within max_distance, and nothing blocks
  /// the line from the camera to it (point_visibility()).
  std::vector<std::uint32_t> counts;
  /// Number, from 1, of the photo with the smallest ground sampling distance, the first of equals; 0: none.
  std::vector<std::uint32_t> best;
  /// PhotoFrame::ground_sampling_distance() in that photo; NaN if no photo sees the point.
  std::vector<float> sampling;
  /// The blended() colour of the photos that see the point; black if no photo sees it.
  /// Empty without read_photo.
  std::vector<Color16> colors;
  std::vector<PhotoSummary> photos;    ///< one per photo
  std::vector<PhotoOverlap> overlaps;  ///< by points that both see
  double footprint_cell = 0.0;         ///< width of the cells; 0 without footprints
};

/// What all photos see together.
struct PhotoTotals {
  std::array<std::uint64_t, 4> points_by_count{};  ///< points seen by 0, 1, 2, and 3 or more photos
  std::uint64_t photos_without_points = 0;
  double median_sampling = 0.0;  ///< of the points that any photo sees, in their best ones; 0 without any
  double median_overlap =
      0.0;  ///< of PhotoSummary::largest_overlap, of the photos with points; 0 without any
};
PhotoTotals totals(const PhotoVisibility& seen);

/// Checks the memory before a run. Errors: not enough memory for the columns.
void check_photo_memory(std::uint64_t points, const PhotoVisibilityOptions& options);

/// Sends a line of sight from each photo to each point in its frame. The same answer on any number of threads
/// and any instruction set. Cost: sight_line.h's per line, some 10 ns per point and photo outside of the
/// frame and 1 microsecond inside. Memory: 13 B per point and 46 B for colours, some bits per point and photo
/// that sees it, 1 photo, 5 B per cell of footprints. Errors: those of check_photos(), check_photo_memory(),
/// grid_over(), run_parts(), and of read_photo.
PhotoVisibility photo_visibility(const Occluders& occluders, std::span<const camera::NamedCamera> photos,
                                 const PhotoVisibilityOptions& options);

}  // namespace alidade::visibility
