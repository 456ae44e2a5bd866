// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cloud/point_cloud.h"
#include "compare/compared_image.h"

// Operations on pixels that are set (1) or not (0), in an image with rows of `width`.

namespace alidade::compare {

/// Leaves a set pixel if at least this share of the 5 x 5 pixels around it, as far as they lie in the
/// image, is set: what is not scattered. The corner of a square has 9 of 25. Cost: 25 pixels are read per
/// set one.
std::vector<std::uint8_t> drop_specks(const std::vector<std::uint8_t>& set, int width, double least_density);

/// Closes gaps between set pixels: a dilation by the square of side 2 gap + 1, then an erosion by it. What is
/// set stays set; beyond the image's edge everything counts as set to the erosion, so that nothing is lost
/// there. Requires gap >= 0. Cost: four passes, whatever the gap; memory: 1 byte per pixel beside the result.
std::vector<std::uint8_t> close_gaps(const std::vector<std::uint8_t>& set, int width, int gap);

// Where two images differ, as few regions that a person can inspect.

struct ChangeOptions {
  double threshold = 0.2;  ///< in the unit of the map; pixels above it have changed
  /// A pixel stays if at least this share of the 5 x 5 around it has changed as well, 0 .. 1; 0: all stay.
  /// Drops the grain of path tracing and the seams between points.
  double least_density = 0.3;
  int gap = 3;  ///< pixels, 0 .. 64: gaps up to about twice as wide between changed pixels are closed
  std::uint64_t least_pixels = 16;  ///< smaller regions are left out
  std::size_t most_regions = 1000;  ///< the largest ones are kept
};

/// Changed pixels that hang together.
struct ChangeRegion {
  int left = 0, top = 0, right = 0, bottom = 0;  ///< box: [left, right) x [top, bottom)
  std::uint64_t pixels = 0;                      ///< changed ones, without specks and closed gaps
  double strongest = 0.0, mean = 0.0;            ///< magnitudes of these pixels; the mean of the finite ones
  int x = 0, y = 0;                              ///< the strongest one, the first in reading order
};

struct ChangeRegions {
  std::vector<ChangeRegion> regions;  ///< by size, the largest first; equal size: in reading order
  std::vector<std::uint32_t> labels;  ///< per pixel: 1 + index in `regions`, where it has changed; else 0
  std::uint64_t changed_pixels = 0;   ///< all above the threshold, also specks and those of regions left out
  std::uint64_t listed_pixels = 0;    ///< those of `regions`
  std::uint64_t small_regions = 0;    ///< left out for being smaller than least_pixels
  std::uint64_t further_regions = 0;  ///< left out for being beyond most_regions
};

/// Regions of a map with one value per pixel, rows of `width` from the top. Pixels have changed if they count
/// and the magnitude of their value is above the threshold (infinite: too; NaN: not). Specks are dropped,
/// gaps closed by a square (close_gaps()), and what touches then, also at corners, is one region. Errors:
/// options out of range. Cost: some passes; memory: 7 bytes per pixel, and at worst, in images full of
/// noise, 3 more.
ChangeRegions change_regions(std::span<const float> map, int width, const ImageMask& mask,
                             const ChangeOptions& options = {});

// From pixels back to points: those that were there, and those that are there now.

/// A point that a region shows.
struct RegionPoint {
  std::uint32_t id = 0;      ///< row in the cloud
  std::uint32_t region = 0;  ///< 1 + index in ChangeRegions::regions
  bool operator==(const RegionPoint&) const = default;
};

/// The points that the regions show, each once (in the largest region that shows it), by id. `ids` is the id
/// layer of one of the two images: point id + 1, 0 where there is nothing. The reference's ids are rows of
/// the reference's cloud, the test's of the test's. Objects of a scene, which count down from 4294967295, are
/// not points. Errors: an id beyond `point_count` that cannot be an object of a scene, so the image was
/// made of another cloud; a layer that is not of the map's size. Cost: a sort of the changed pixels.
std::vector<RegionPoint> region_points(std::span<const std::uint32_t> ids, const ChangeRegions& changes,
                                       std::uint64_t point_count);

/// These points of the cloud with all their attributes, scale, offset, reference system and records, and the
/// number of the region in an extra dimension Region (uint32, from 1), which replaces one of that name.
/// Memory: a copy of these points.
PointCloud points_of_regions(const PointCloud& cloud, std::span<const RegionPoint> points);

}  // namespace alidade::compare
