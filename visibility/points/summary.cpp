// SPDX-License-Identifier: MIT
#include "visibility/points/summary.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/error.h"
#include "base/exact_math.h"
#include "geo/earth.h"
#include "octree/spacing.h"
#include "surface/point_surface.h"
#include "visibility/crossing.h"
#include "visibility/horizon/horizon.h"
#include "visibility/point_blocks.h"
#include "visibility/points/point_visibility.h"

namespace alidade::visibility {
namespace {

constexpr std::size_t k_classes = 256;
constexpr double k_elevation_step = 0.1;  // degrees
constexpr std::array<std::size_t, 3> k_ground_classes{2, 9, 11};

bool is_ground(std::size_t number) {
  return std::ranges::find(k_ground_classes, number) != k_ground_classes.end();
}

/// A value and its weight.
struct Weighted {
  double value, weight;
};

double weight_of_all(std::span<const Weighted> values) {
  double sum = 0.0;
  for (const Weighted& one : values) sum += one.weight;
  return sum;
}

/// Orders the values. Requires one, and a positive weight.
Spread spread_of(std::vector<Weighted>& values) {
  std::ranges::sort(values, {}, [](const Weighted& one) { return std::pair(one.value, one.weight); });
  const double all = weight_of_all(values);
  Spread spread{.min = values.front().value, .median = values.back().value, .max = values.back().value};
  double below = 0.0;
  bool has_median = false;
  for (const Weighted& one : values) {
    below += one.weight;
    spread.mean += one.weight * one.value;
    if (has_median || 2.0 * below < all) continue;
    spread.median = one.value;
    has_median = true;
  }
  spread.mean /= all;
  double squares = 0.0;
  for (const Weighted& one : values)
    squares += one.weight * (one.value - spread.mean) * (one.value - spread.mean);
  spread.deviation = std::sqrt(squares / all);
  return spread;
}

/// The bounds of everything that can be seen.
Bounds box_of(const OccluderOptions& blocks, const Octree& octree) {
  Bounds box = octree.bounds();
  if (blocks.mesh != nullptr) box.grow(blocks.mesh->bounds());
  if (blocks.terrain != nullptr) box.grow(blocks.terrain->bounds());
  return box;
}

/// Distance at which a ray from within a box leaves it.
double way_out(const Bounds& box, const glm::dvec3& from, const glm::dvec3& direction) {
  double end = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) continue;
    const double face = direction[axis] > 0.0 ? box.max[axis] : box.min[axis];
    end = std::min(end, (face - from[axis]) / direction[axis]);
  }
  return end;
}

/// Measures what observers see, one after another.
class Summarizer {
 public:
  Summarizer(const Occluders& occluders, const SummaryOptions& options)
      : occluders_(occluders),
        options_(options),
        octree_(with_spacings(occluders.octree(), k_surface_neighbours)),
        widest_(k_widest_disc * automatic_radius(octree_)),
        blocks_(leaf_blocks(octree_.view(), 1 << 17)),
        box_(box_of(occluders.options(), octree_)) {}

  ObserverSummary summary(const Observer& observer, std::span<const std::uint8_t> seen) const {
    ObserverSummary summary;
    add_points(observer, seen, summary);
    const SightEnd eye = end_near_surface(occluders_, observer.position);
    summary.isovist = isovist(observer, eye);
    summary.volume = volume(observer, eye);
    HorizonOptions horizon_options{.step = options_.step,
                                   .resolution = k_elevation_step,
                                   .azimuth_min = observer.azimuth_min,
                                   .azimuth_max = observer.azimuth_max,
                                   .elevation_min = observer.elevation_min,
                                   .elevation_max = observer.elevation_max,
                                   .max_distance = observer.max_distance};
    std::vector<Weighted> elevations;
    for (const HorizonDirection& direction : horizon(occluders_, eye, horizon_options)) {
      if (direction.elevation) elevations.push_back({*direction.elevation, 1.0});
    }
    if (!elevations.empty()) summary.horizon = spread_of(elevations);
    summary.sky = sky_shares(occluders_, eye, options_.directions, observer.max_distance);
    return summary;
  }

 private:
  double area_of(std::uint32_t index) const {
    return area_of_point(std::min(spacing_at(octree_.layers(), index), widest_));
  }

  std::size_t band_of(double distance) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(options_.bands, distance) -
                                    options_.bands.begin());
  }

  void add_points(const Observer& observer, std::span<const std::uint8_t> seen,
                  ObserverSummary& summary) const {
    const TreeView& tree = octree_.view();
    const FieldOfView field(observer);
    const auto& counts = occluders_.options().counts;
    std::vector<Weighted> distances, ground;
    summary.bands.resize(options_.bands.size() + 1);
    if (!options_.classes.empty()) summary.class_areas.resize(k_classes);
    for (const std::vector<Leaf>& block : blocks_) {
      occluders_.check_given_up();
      for (const PlacedPoint& point : placed_points(tree, block)) {
        const glm::dvec3 offset = point.position - observer.position;
        if (!field.reaches(offset) || (counts && !counts(point.point_id))) continue;
        const double distance = glm::length(offset), area = area_of(point.index);
        BandSummary& band = summary.bands[band_of(distance)];
        band.all += area;
        if (seen[point.point_id] == 0) continue;
        band.visible += area;
        ++summary.visible_points;
        distances.push_back({distance, area});
        if (options_.classes.empty()) continue;
        const std::uint8_t number = options_.classes[point.point_id];
        summary.class_areas[number] += area;
        if (is_ground(number)) ground.push_back({point.position.z, area});
      }
    }
    for (const BandSummary& band : summary.bands) {
      summary.area.visible += band.visible;
      summary.area.all += band.all;
    }
    if (weight_of_all(distances) > 0.0) summary.distances = spread_of(distances);
    if (weight_of_all(ground) > 0.0) summary.relief = spread_of(ground).deviation;
    if (!options_.classes.empty() && summary.area.visible > 0.0) summary.diversity = diversity(summary);
  }

  static double diversity(const ObserverSummary& summary) {
    double sum = 0.0;
    for (const double area : summary.class_areas) {
      const double share = area / summary.area.visible;
      if (share > 0.0) sum -= share * std::numbers::ln2 * binary_logarithm(share);
    }
    return sum;
  }

  /// The length of the view in a direction.
  struct Reach {
    double length;
    bool is_blocked;
  };
  std::vector<Reach> reaches(const Observer& observer, const SightEnd& eye,
                             std::span<const glm::dvec3> directions) const {
    std::vector<SightLine> lines;
    for (const glm::dvec3& direction : directions)
      lines.push_back(sight_ray(eye, direction, observer.max_distance));
    std::vector<std::optional<Blocker>> blockers(lines.size());
    first_blockers(occluders_, lines, blockers);
    Bounds box = box_;
    box.grow(observer.position);
    std::vector<Reach> found;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const double open = std::min(way_out(box, observer.position, directions[i]), observer.max_distance);
      found.push_back({blockers[i] ? blockers[i]->distance : open, blockers[i].has_value()});
    }
    return found;
  }

  std::optional<Isovist> isovist(const Observer& observer, const SightEnd& eye) const {
    const FieldOfView field(observer);
    const int azimuths = azimuths_per_turn(options_.step);
    std::vector<glm::dvec3> directions;
    for (int i = 0; i < azimuths; ++i) {
      // In the middle of its sector, so that the number of radials in a field of view is
      // proportional to its width.
      const glm::dvec3 direction = geo::compass_direction((i + 0.5) * options_.step, 0.0);
      if (field.contains(direction)) directions.push_back(direction);
    }
    if (directions.empty()) return std::nullopt;
    Isovist isovist;
    std::vector<Weighted> radials;
    int open = 0;
    for (const Reach& reach : reaches(observer, eye, directions)) {
      isovist.area += 0.5 * reach.length * reach.length * (2.0 * std::numbers::pi / azimuths);
      radials.push_back({reach.length, 1.0});
      open += reach.is_blocked ? 0 : 1;
    }
    const Spread spread = spread_of(radials);
    isovist.mean = spread.mean;
    isovist.max = spread.max;
    isovist.deviation = spread.deviation;
    isovist.open = static_cast<double>(open) / static_cast<double>(radials.size());
    return isovist;
  }

  double volume(const Observer& observer, const SightEnd& eye) const {
    const FieldOfView field(observer);
    std::vector<glm::dvec3> directions;
    for (const glm::dvec3& up : even_sky_directions(options_.directions)) {
      for (const double sign : {1.0, -1.0}) {
        const glm::dvec3 direction(up.x, up.y, sign * up.z);
        if (field.contains(direction)) directions.push_back(direction);
      }
    }
    double sum = 0.0;
    for (const Reach& reach : reaches(observer, eye, directions))
      sum += reach.length * reach.length * reach.length / 3.0;
    return sum * 4.0 * std::numbers::pi / (2.0 * options_.directions);
  }

  const Occluders& occluders_;
  const SummaryOptions& options_;
  const Octree octree_;  ///< with spacings
  const double widest_;  ///< larger spacings count as this, since no disc is wider
  const std::vector<std::vector<Leaf>> blocks_;
  const Bounds box_;
};

template <class Value>
Row or_null(const std::optional<Value>& value) {
  return value ? Row(*value) : Row(nullptr);
}

Row share_of(double part, double all) {
  return all > 0.0 ? Row(part / all) : Row(nullptr);
}

/// Columns "distance_min" and so on; null without values.
void add_spread(const std::string& name, const std::optional<Spread>& spread, Row& row) {
  for (const auto& [measure, value] : {std::pair("min", &Spread::min), std::pair("median", &Spread::median),
                                       std::pair("mean", &Spread::mean), std::pair("max", &Spread::max),
                                       std::pair("deviation", &Spread::deviation)})
    row[name + "_" + measure] = spread ? Row((*spread).*value) : Row(nullptr);
}

void add_isovist(const std::optional<Isovist>& isovist, Row& row) {
  for (const auto& [measure, value] :
       {std::pair("area", &Isovist::area), std::pair("mean", &Isovist::mean), std::pair("max", &Isovist::max),
        std::pair("deviation", &Isovist::deviation), std::pair("open", &Isovist::open)})
    row[std::string("isovist_") + measure] = isovist ? Row((*isovist).*value) : Row(nullptr);
}

void add_bands(const ObserverSummary& summary, std::span<const double> limits, Row& row) {
  double from = 0.0;
  for (std::size_t i = 0; i < summary.bands.size(); ++i) {
    const double to = i < limits.size() ? limits[i] : std::numeric_limits<double>::infinity();
    const std::string band = fmt::format("{:g}_{:g}", from, to);
    row["area_" + band] = summary.bands[i].visible;
    row["share_" + band] = share_of(summary.bands[i].visible, summary.bands[i].all);
    from = to;
  }
}

}  // namespace

double ObserverSummary::ground_area() const {
  double sum = 0.0;
  if (!class_areas.empty())
    for (const std::size_t number : k_ground_classes) sum += class_areas[number];
  return sum;
}

std::vector<ObserverSummary> summarize(const Occluders& occluders, std::span<const Observer> observers,
                                       const SummaryOptions& options) {
  azimuths_per_turn(options.step);
  double last = 0.0;
  for (const double band : options.bands) {
    check_that(band > last && std::isfinite(band), "bands of distance out of order",
               fmt::format("more than {}", last), fmt::format("{}", band));
    last = band;
  }
  const Summarizer summarizer(occluders, options);
  std::vector<ObserverSummary> summaries(observers.size());
  PointVisibilityOptions points{.parts = options.parts, .progress = options.progress};
  points.each_observer = [&](std::size_t number, std::span<const std::uint8_t> seen) {
    summaries[number] = summarizer.summary(observers[number], seen);
  };
  point_visibility(occluders, observers, points);
  return summaries;
}

Row summary_row(const ObserverSummary& summary, const Observer& observer, std::span<const double> limits,
                const std::bitset<256>& classes) {
  Row row = {{"name", observer.name},
             {"x", observer.position.x},
             {"y", observer.position.y},
             {"z", observer.position.z},
             {"points", summary.visible_points},
             {"area", summary.area.visible},
             {"share", share_of(summary.area.visible, summary.area.all)}};
  add_bands(summary, limits, row);
  add_spread("distance", summary.distances, row);
  add_isovist(summary.isovist, row);
  row["volume"] = summary.volume;
  add_spread("horizon", summary.horizon, row);
  row["sky_view"] = summary.sky.cosine_weighted;
  row["sky_share"] = summary.sky.solid_angle;
  if (summary.class_areas.empty()) return row;
  row["ground_area"] = summary.ground_area();
  row["relief"] = or_null(summary.relief);
  row["diversity"] = or_null(summary.diversity);
  for (std::size_t number = 0; number < classes.size(); ++number) {
    if (classes.test(number))
      row[fmt::format("class_{}", number)] = share_of(summary.class_areas[number], summary.area.visible);
  }
  return row;
}

bool write_summaries(std::span<const ObserverSummary> summaries, std::span<const Observer> observers,
                     const SummaryOptions& options, RowForm form, const RowFileHead& head,
                     const ToLonLat& to_lon_lat, const std::filesystem::path& file, bool overwrite) {
  std::bitset<256> classes;
  for (const std::uint8_t number : options.classes) classes.set(number);
  PositionTable table{.list = "observers", .rows = {}, .positions = {}};
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    table.rows.push_back(summary_row(summaries[i], observers[i], options.bands, classes));
    table.positions.push_back(observers[i].position);
  }
  return write_positions(table, Row::object(), form, head, to_lon_lat, file, overwrite);
}

}  // namespace alidade::visibility
