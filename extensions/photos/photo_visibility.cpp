// SPDX-License-Identifier: MIT
#include "extensions/photos/photo_visibility.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "extensions/photos/footprint.h"
#include "extensions/photos/point_colors.h"
#include "geo/raster.h"
#include "octree/spacing.h"
#include "visibility/photo_frame.h"
#include "visibility/point_blocks.h"
#include "visibility/points/point_visibility.h"

namespace alidade::visibility {
namespace {

constexpr std::size_t k_points_at_once = 1 << 17;

/// 0 without values.
double median_of(std::vector<float>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The median spacing of some hundred thousand points at most. If the octree has no spacings, that of points
/// spread evenly over the area.
double median_spacing(const Octree& octree) {
  constexpr std::uint64_t k_enough = 1 << 17, k_neighbours = 8;
  const TreeView& tree = octree.view();
  std::vector<float> spacings;
  if (octree.layers().spacings != nullptr) {
    const std::uint64_t step = tree.point_count / k_enough + 1;
    for (std::uint64_t i = 0; i < tree.point_count; i += step)
      spacings.push_back(static_cast<float>(spacing_at(octree.layers(), static_cast<std::uint32_t>(i))));
  }
  if (const double median = median_of(spacings); median > 0.0 && std::isfinite(median)) return median;
  const glm::dvec3 size = octree.bounds().max - octree.bounds().min;
  const double longest = std::max({size.x, size.y, 1e-3});
  const double area = std::max(size.x * size.y, 1e-6 * longest * longest);
  return std::sqrt(k_neighbours * area / static_cast<double>(tree.point_count));
}

/// What a photo sees of k_seen_block points.
struct BlockView {
  SeenBlock bits{};
  std::vector<float> sampling, distances;

  bool is_empty() const { return sampling.empty(); }
};

/// Collects the views of the photos, one after another.
class Collector {
 public:
  Collector(const Occluders& occluders, std::span<const camera::NamedCamera> photos,
            const std::vector<PhotoFrame>& frames, const PhotoVisibilityOptions& options)
      : occluders_(occluders),
        tree_(occluders.octree().view()),
        photos_(photos),
        frames_(frames),
        options_(options),
        batches_(leaf_blocks(tree_, k_points_at_once)),
        sets_(photos.size()),
        views_(options.read_photo ? tree_.point_count : 0) {
    result_.best.resize(tree_.point_count);
    result_.sampling.assign(tree_.point_count, std::numeric_limits<float>::quiet_NaN());
    result_.photos.resize(photos.size());
    if (!options.with_footprints) return;
    const Bounds& area = occluders.octree().bounds();
    result_.footprint_cell =
        options.footprint_cell.value_or(footprint_cell(area, median_spacing(occluders.octree())));
    grid_ = geo::grid_over(area, result_.footprint_cell);
    constexpr std::uint64_t k_bytes_per_cell = 5;
    check_memory(k_bytes_per_cell * grid_.size(), "the cells of footprints");
  }

  void add(std::size_t photo, std::span<const std::uint8_t> seen) {
    PhotoSummary& summary = result_.photos[photo];
    if (std::ranges::find(seen, std::uint8_t{1}) == seen.end()) return;
    image::PhotoPixels pixels;
    if (options_.read_photo) pixels = options_.read_photo(photo);
    cells_.assign(grid_.size(), 0);
    std::vector<float> sampling, distances;
    std::uint32_t first_block = 0;
    for (const std::vector<Leaf>& batch : batches_) {
      const std::vector<PlacedPoint> points = placed_points(tree_, batch);
      const std::vector<BlockView> blocks = look_at(photo, points, seen, pixels);
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        if (blocks[i].is_empty()) continue;
        sampling.insert(sampling.end(), blocks[i].sampling.begin(), blocks[i].sampling.end());
        distances.insert(distances.end(), blocks[i].distances.begin(), blocks[i].distances.end());
        sets_[photo].blocks.emplace_back(first_block + static_cast<std::uint32_t>(i), blocks[i].bits);
      }
      first_block += static_cast<std::uint32_t>(blocks.size());
    }
    summary.points = sampling.size();
    summary.median_sampling = median_of(sampling);
    summary.median_distance = median_of(distances);
    sets_[photo].blocks.shrink_to_fit();
    check_memory(sets_[photo].byte_count(), "the points that photos see");
    if (options_.with_footprints) summary.footprint = outline(grid_, cells_);
  }

  PhotoVisibility result(std::vector<std::uint32_t> counts) {
    result_.counts = std::move(counts);
    if (options_.read_photo) {
      result_.colors.resize(views_.size());
      in_parallel(views_.size(), 256, [&](std::size_t id) {
        if (result_.counts[id] > 0) result_.colors[id] = blended(views_[id]);
      });
    }
    result_.overlaps = overlaps(sets_);
    for (const PhotoOverlap& pair : result_.overlaps) {
      for (const std::uint32_t photo : {pair.first, pair.second}) {
        PhotoSummary& summary = result_.photos[photo];
        summary.largest_overlap = std::max(
            summary.largest_overlap, static_cast<double>(pair.points) / static_cast<double>(summary.points));
      }
    }
    return std::move(result_);
  }

 private:
  /// What the photo sees of some points, in blocks.
  std::vector<BlockView> look_at(std::size_t photo, const std::vector<PlacedPoint>& points,
                                 std::span<const std::uint8_t> seen, const image::PhotoPixels& pixels) {
    std::vector<BlockView> blocks((points.size() + k_seen_block - 1) / k_seen_block);
    in_blocks(points.size(), k_seen_block, [&](std::size_t begin, std::size_t end) {
      BlockView& block = blocks[begin / k_seen_block];
      for (std::size_t i = begin; i < end; ++i) {
        if (seen[points[i].point_id] == 0) continue;
        block.bits[(i - begin) / 64] |= std::uint64_t{1} << ((i - begin) % 64);
        add_point(photo, points[i], pixels, block);
      }
    });
    return blocks;
  }

  /// No two threads may call this with the same point.
  void add_point(std::size_t photo, const PlacedPoint& point, const image::PhotoPixels& pixels,
                 BlockView& view) {
    const PhotoFrame& frame = frames_[photo];
    const std::uint64_t id = point.point_id;
    const double distance = frame.ground_sampling_distance(point.position, occluders_.surface(id));
    const auto sampling = static_cast<float>(distance);
    view.sampling.push_back(sampling);
    view.distances.push_back(
        static_cast<float>(glm::length(point.position - photos_[photo].camera.pose.position)));
    if (result_.best[id] == 0 || sampling < result_.sampling[id]) {
      result_.best[id] = static_cast<std::uint32_t>(photo + 1);
      result_.sampling[id] = sampling;
    }
    if (!cells_.empty()) mark(point.position);
    if (views_.empty()) return;
    const auto film = frame.film_position(point.position);
    if (film)
      add_view({static_cast<float>(1.0 / (distance * distance)), color_at(pixels, *film)}, views_[id]);
  }

  void mark(const glm::dvec3& position) {
    const auto cell = geo::cell_at(grid_, position);
    // A cell holds points of several threads.
    if (cell) std::atomic_ref(cells_[grid_.index(cell->x, cell->y)]).store(1, std::memory_order_relaxed);
  }

  const Occluders& occluders_;
  const TreeView& tree_;
  std::span<const camera::NamedCamera> photos_;
  const std::vector<PhotoFrame>& frames_;
  const PhotoVisibilityOptions& options_;
  std::vector<std::vector<Leaf>> batches_;
  std::vector<SeenSet> sets_;
  std::vector<ColorViews> views_;
  geo::RasterGrid grid_;
  std::vector<std::uint8_t> cells_;  ///< of the current photo
  PhotoVisibility result_;
};

std::vector<PhotoFrame> frames_of(std::span<const camera::NamedCamera> photos) {
  std::vector<PhotoFrame> frames;
  for (const camera::NamedCamera& photo : photos) frames.emplace_back(photo.camera);
  return frames;
}

}  // namespace

std::vector<Observer> photo_observers(std::span<const camera::NamedCamera> photos, double max_distance) {
  std::vector<Observer> observers;
  for (const camera::NamedCamera& photo : photos)
    observers.push_back(
        {.position = photo.camera.pose.position,
         .name = photo.name.empty() ? "photo " + std::to_string(observers.size() + 1) : photo.name,
         .max_distance = max_distance});
  return observers;
}

PhotoTotals totals(const PhotoVisibility& seen) {
  PhotoTotals all;
  std::vector<float> sampling, overlaps;
  for (std::size_t id = 0; id < seen.counts.size(); ++id) {
    ++all.points_by_count[std::min<std::size_t>(seen.counts[id], 3)];
    if (seen.counts[id] > 0) sampling.push_back(seen.sampling[id]);
  }
  for (const PhotoSummary& photo : seen.photos) {
    if (photo.points == 0) ++all.photos_without_points;
    if (photo.points > 0) overlaps.push_back(static_cast<float>(photo.largest_overlap));
  }
  all.median_sampling = median_of(sampling);
  all.median_overlap = median_of(overlaps);
  return all;
}

void check_photo_memory(std::uint64_t points, const PhotoVisibilityOptions& options) {
  constexpr std::uint64_t k_columns = 13, k_to_write = 12;
  const std::uint64_t colors = options.read_photo ? sizeof(ColorViews) + sizeof(Color16) : 0;
  check_memory(points * (k_columns + k_to_write + colors), "the columns of all points");
}

PhotoVisibility photo_visibility(const Occluders& occluders, std::span<const camera::NamedCamera> photos,
                                 const PhotoVisibilityOptions& options) {
  check_photos(occluders.octree(), photos, options.max_distance);
  check_photo_memory(occluders.octree().size(), options);
  const std::vector<PhotoFrame> frames = frames_of(photos);
  Collector collector(occluders, photos, frames, options);
  const auto in_view = [&frames](std::size_t photo, const glm::dvec3& position) {
    return frames[photo].film_position(position).has_value();
  };
  const auto take = [&collector](std::size_t photo, std::span<const std::uint8_t> seen) {
    collector.add(photo, seen);
  };
  PointVisibility seen = point_visibility(
      occluders, photo_observers(photos, options.max_distance),
      {.in_view = in_view, .each_observer = take, .parts = options.parts, .progress = options.progress});
  return collector.result(std::move(seen.counts));
}

std::uint64_t common_points(const SeenSet& a, const SeenSet& b) {
  std::uint64_t points = 0;
  auto other = b.blocks.begin();
  for (const auto& [number, bits] : a.blocks) {
    while (other != b.blocks.end() && other->first < number) ++other;
    if (other == b.blocks.end()) break;
    if (other->first != number) continue;
    for (std::size_t word = 0; word < bits.size(); ++word)
      points += static_cast<std::uint64_t>(std::popcount(bits[word] & other->second[word]));
  }
  return points;
}

std::vector<PhotoOverlap> overlaps(const std::vector<SeenSet>& photos) {
  std::vector<std::vector<PhotoOverlap>> rows(photos.size());
  in_parallel(photos.size(), 1, [&](std::size_t first) {
    for (std::size_t second = first + 1; second < photos.size(); ++second) {
      const std::uint64_t points = common_points(photos[first], photos[second]);
      if (points > 0)
        rows[first].push_back(
            {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(second), points});
    }
  });
  std::vector<PhotoOverlap> all;
  for (const std::vector<PhotoOverlap>& row : rows) all.insert(all.end(), row.begin(), row.end());
  return all;
}

}  // namespace alidade::visibility
