// SPDX-License-Identifier: MIT
#include "compare/change_regions.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "cloud/rows.h"

namespace alidade::compare {
namespace {

enum class Grows { yes, no };

/// Set where any (grows) or every (shrinks) pixel of the window is set, as far as the window lies in the
/// image.
std::uint8_t decide(int set_count, int window, Grows grows) {
  return grows == Grows::yes ? set_count > 0 : set_count == window;
}

/// Pixels of [center - gap, center + gap] that lie in [0, size).
int window_size(int center, int size, int gap) {
  return std::min(center + gap, size - 1) - std::max(center - gap, 0) + 1;
}

void along_rows(const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to, int width, int gap,
                Grows grows) {
  for (std::size_t first = 0; first < from.size(); first += static_cast<std::size_t>(width)) {
    const std::uint8_t* const row = from.data() + first;
    int count = 0;
    for (int x = 0; x < std::min(gap, width); ++x) count += row[x];
    for (int x = 0; x < width; ++x) {
      if (x + gap < width) count += row[x + gap];
      if (x - gap - 1 >= 0) count -= row[x - gap - 1];
      to[first + static_cast<std::size_t>(x)] = decide(count, window_size(x, width, gap), grows);
    }
  }
}

void along_columns(const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to, int width, int gap,
                   Grows grows) {
  const int height = static_cast<int>(from.size() / static_cast<std::size_t>(width));
  std::vector<int> counts(static_cast<std::size_t>(width), 0);
  const auto add = [&](int y, int sign) {
    if (y < 0 || y >= height) return;
    const std::uint8_t* const row = from.data() + static_cast<std::size_t>(y) * counts.size();
    for (std::size_t x = 0; x < counts.size(); ++x) counts[x] += sign * row[x];
  };
  for (int y = 0; y < gap; ++y) add(y, 1);
  for (int y = 0; y < height; ++y) {
    add(y + gap, 1);
    add(y - gap - 1, -1);
    const int window = window_size(y, height, gap);
    std::uint8_t* const row = to.data() + static_cast<std::size_t>(y) * counts.size();
    for (std::size_t x = 0; x < counts.size(); ++x) row[x] = decide(counts[x], window, grows);
  }
}

/// Pixels [begin, end) of a row that hang together.
struct Run {
  int begin = 0, end = 0;
  std::uint32_t part = 0;
};

/// Parts that turn out to hang together become one; its number is the least of theirs.
class Parts {
 public:
  std::uint32_t add() {
    parents_.push_back(static_cast<std::uint32_t>(parents_.size()));
    return parents_.back();
  }

  std::uint32_t whole(std::uint32_t part) {
    while (parents_[part] != part) {
      parents_[part] = parents_[parents_[part]];
      part = parents_[part];
    }
    return part;
  }

  void join(std::uint32_t a, std::uint32_t b) {
    const auto [low, high] = std::minmax({whole(a), whole(b)});
    parents_[high] = low;
  }

  std::size_t size() const { return parents_.size(); }

 private:
  std::vector<std::uint32_t> parents_;
};

/// Numbers the runs of a row like those of the row above that they touch.
void number_runs(std::vector<Run>& runs, const std::vector<Run>& above, Parts& parts) {
  std::size_t first = 0;
  for (Run& run : runs) {
    while (first < above.size() && above[first].end < run.begin) ++first;
    bool is_new = true;
    for (std::size_t i = first; i < above.size() && above[i].begin <= run.end; ++i) {
      if (is_new)
        run.part = above[i].part;
      else
        parts.join(run.part, above[i].part);
      is_new = false;
    }
    if (is_new) run.part = parts.add();
  }
}

std::vector<Run> runs_of(const std::uint8_t* row, int width) {
  std::vector<Run> runs;
  for (int x = 0; x < width; ++x) {
    if (row[x] == 0) continue;
    if (runs.empty() || runs.back().end != x)
      runs.push_back({x, x + 1});
    else
      ++runs.back().end;
  }
  return runs;
}

/// 1 + the part of each changed pixel. Parts hang together through the pixels of `closed`.
std::vector<std::uint32_t> part_labels(const std::vector<std::uint8_t>& changed,
                                       const std::vector<std::uint8_t>& closed, int width, Parts& parts) {
  std::vector<std::uint32_t> labels(changed.size(), 0);
  std::vector<Run> above;
  for (std::size_t first = 0; first < closed.size(); first += static_cast<std::size_t>(width)) {
    std::vector<Run> runs = runs_of(closed.data() + first, width);
    number_runs(runs, above, parts);
    for (const Run& run : runs) {
      for (int x = run.begin; x < run.end; ++x) {
        const std::size_t pixel = first + static_cast<std::size_t>(x);
        if (changed[pixel] != 0) labels[pixel] = run.part + 1;
      }
    }
    above = std::move(runs);
  }
  return labels;
}

void measure_regions(ChangeRegions& changes, std::span<const float> map, int width) {
  std::vector<std::uint64_t> finite(changes.regions.size(), 0);
  for (ChangeRegion& region : changes.regions) region.left = width;
  for (std::size_t pixel = 0; pixel < map.size(); ++pixel) {
    if (changes.labels[pixel] == 0) continue;
    ChangeRegion& region = changes.regions[changes.labels[pixel] - 1];
    const int x = static_cast<int>(pixel % static_cast<std::size_t>(width)),
              y = static_cast<int>(pixel / static_cast<std::size_t>(width));
    if (region.pixels++ == 0) region.top = y;
    region.left = std::min(region.left, x);
    region.right = std::max(region.right, x + 1);
    region.bottom = y + 1;
    const double value = std::abs(static_cast<double>(map[pixel]));
    if (std::isfinite(value)) {
      region.mean += value;
      ++finite[changes.labels[pixel] - 1];
    }
    if (value > region.strongest) {
      region.strongest = value;
      region.x = x;
      region.y = y;
    }
  }
  for (std::size_t i = 0; i < finite.size(); ++i)
    if (finite[i] > 0) changes.regions[i].mean /= static_cast<double>(finite[i]);
}

void check_options(const ChangeOptions& options) {
  constexpr int k_widest_gap = 64;
  check_that(options.threshold >= 0.0, "change threshold out of range", "at least 0",
             std::to_string(options.threshold));
  check_that(options.least_density >= 0.0 && options.least_density <= 1.0,
             "fraction of changed pixels out of range", "0 to 1", std::to_string(options.least_density));
  check_that(options.gap >= 0 && options.gap <= k_widest_gap, "gap between changed pixels out of range",
             "0 to " + std::to_string(k_widest_gap) + " pixels", std::to_string(options.gap));
}

constexpr const char* k_region_name = "Region";

/// Objects of a scene are numbered down from the largest id; no scene has as many.
constexpr std::uint32_t k_first_object_id = 0xff000000u;

ExtraDimension region_dimension() {
  ExtraDimension dimension;
  dimension.name = k_region_name;
  dimension.description = "changed region, 1 is largest";
  dimension.type = ScalarType::uint32;
  dimension.byte_count = 4;
  return dimension;
}

}  // namespace

std::vector<std::uint8_t> drop_specks(const std::vector<std::uint8_t>& set, int width, double least_density) {
  constexpr int k_reach = 2;
  const int height = static_cast<int>(set.size() / static_cast<std::size_t>(width));
  std::vector<std::uint8_t> result(set.size(), 0);
  in_parallel(height, 4, [&](int y) {
    const int top = std::max(y - k_reach, 0), bottom = std::min(y + k_reach, height - 1);
    for (int x = 0; x < width; ++x) {
      const std::size_t pixel = pixel_index(x, y, width);
      if (set[pixel] == 0) continue;
      const int left = std::max(x - k_reach, 0), right = std::min(x + k_reach, width - 1);
      int count = 0;
      for (int v = top; v <= bottom; ++v)
        for (int u = left; u <= right; ++u) count += set[pixel_index(u, v, width)];
      result[pixel] = count >= least_density * (right - left + 1) * (bottom - top + 1);
    }
  });
  return result;
}

std::vector<std::uint8_t> close_gaps(const std::vector<std::uint8_t>& set, int width, int gap) {
  if (gap == 0) return set;
  std::vector<std::uint8_t> one(set.size()), other(set.size());
  along_rows(set, one, width, gap, Grows::yes);
  along_columns(one, other, width, gap, Grows::yes);
  along_rows(other, one, width, gap, Grows::no);
  along_columns(one, other, width, gap, Grows::no);
  return other;
}

ChangeRegions change_regions(std::span<const float> map, int width, const ImageMask& mask,
                             const ChangeOptions& options) {
  check_options(options);
  assert(width > 0 && map.size() % static_cast<std::size_t>(width) == 0);
  ChangeRegions changes;
  std::vector<std::uint8_t> changed(map.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    changed[i] = mask.at(i) && std::abs(static_cast<double>(map[i])) > options.threshold;
    changes.changed_pixels += changed[i];
  }
  if (options.least_density > 0.0) changed = drop_specks(changed, width, options.least_density);
  Parts parts;
  changes.labels = part_labels(changed, close_gaps(changed, width, options.gap), width, parts);

  struct Size {
    std::uint32_t part = 0;
    std::uint64_t pixels = 0;
  };
  std::vector<std::uint32_t> pixels(parts.size(), 0);
  for (const std::uint32_t label : changes.labels)
    if (label > 0) ++pixels[parts.whole(label - 1)];
  std::vector<Size> sizes;
  for (std::uint32_t part = 0; part < pixels.size(); ++part) {
    if (pixels[part] == 0) continue;
    if (pixels[part] >= options.least_pixels)
      sizes.push_back({part, pixels[part]});
    else
      ++changes.small_regions;
  }
  std::ranges::stable_sort(sizes, std::greater<>{}, &Size::pixels);
  if (sizes.size() > options.most_regions) {
    changes.further_regions = sizes.size() - options.most_regions;
    sizes.resize(options.most_regions);
  }

  // The counts are not needed any more; `pixels` now has the new number of each region.
  std::ranges::fill(pixels, 0u);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    pixels[sizes[i].part] = static_cast<std::uint32_t>(i + 1);
    changes.listed_pixels += sizes[i].pixels;
  }
  for (std::uint32_t& label : changes.labels)
    if (label > 0) label = pixels[parts.whole(label - 1)];
  changes.regions.resize(sizes.size());
  measure_regions(changes, map, width);
  return changes;
}

std::vector<RegionPoint> region_points(std::span<const std::uint32_t> ids, const ChangeRegions& changes,
                                       std::uint64_t point_count) {
  check_that(ids.size() == changes.labels.size(), "the id layer and the change map differ in size",
             std::to_string(changes.labels.size()) + " pixels", std::to_string(ids.size()));
  std::vector<RegionPoint> points;
  for (std::size_t pixel = 0; pixel < ids.size(); ++pixel) {
    if (changes.labels[pixel] == 0 || ids[pixel] == 0) continue;
    if (ids[pixel] > point_count) {
      if (ids[pixel] >= k_first_object_id) continue;
      throw Error(
          {.problem = "the image shows a point that the cloud lacks; it was rendered from another cloud",
           .expected = "point ids up to " + std::to_string(point_count),
           .found = std::to_string(ids[pixel])});
    }
    points.push_back({ids[pixel] - 1, changes.labels[pixel]});
  }
  // Regions are numbered by size, so the largest one of a point comes first.
  std::ranges::sort(points, [](const RegionPoint& a, const RegionPoint& b) {
    return a.id != b.id ? a.id < b.id : a.region < b.region;
  });
  const auto is_same = [](const RegionPoint& a, const RegionPoint& b) { return a.id == b.id; };
  points.erase(std::unique(points.begin(), points.end(), is_same), points.end());
  return points;
}

PointCloud points_of_regions(const PointCloud& cloud, std::span<const RegionPoint> points) {
  PointCloud result;
  result.lattice = cloud.lattice;
  result.crs = cloud.crs;
  result.records = cloud.records;
  result.gps_time_is_standard = cloud.gps_time_is_standard;
  result.project_id = cloud.project_id;
  result.file_source_id = cloud.file_source_id;
  const auto pick = [&](auto& column, const auto& all) {
    if (all.empty()) return;
    column.reserve(points.size());
    for (const RegionPoint& point : points) column.push_back(all[point.id]);
  };
  pick(result.positions, cloud.positions);
  for_each_column(result, cloud, [&](Attribute, auto& column, const auto& all) { pick(column, all); });
  for (const ExtraDimension& all : cloud.extra_dimensions) {
    if (all.name == k_region_name) continue;
    ExtraDimension& column = result.extra_dimensions.emplace_back(description_of(all));
    const auto bytes = static_cast<std::size_t>(all.byte_count);
    column.values.resize(points.size() * bytes);
    for (std::size_t i = 0; i < points.size(); ++i)
      std::memcpy(column.values.data() + i * bytes, all.values.data() + points[i].id * bytes, bytes);
  }
  ExtraDimension& regions = result.extra_dimensions.emplace_back(region_dimension());
  regions.values.reserve(4 * points.size());
  for (const RegionPoint& point : points)
    for (int shift = 0; shift < 32; shift += 8)
      regions.values.push_back(static_cast<std::uint8_t>(point.region >> shift));
  return result;
}

}  // namespace alidade::compare
