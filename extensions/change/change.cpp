// SPDX-License-Identifier: MIT
#include "extensions/change/change.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <span>
#include <vector>

#include "base/error.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/local_plane.h"
#include "surface/point_disc.h"

namespace alidade::visibility {
namespace {

constexpr float k_none = std::numeric_limits<float>::quiet_NaN();
/// Radius of a cylinder in spacings: it holds some 32 points.
constexpr double k_cylinder_spacings = 2.0;
/// Largest distance to a surface that counts as the same one after it has moved, in radii of the cylinder.
constexpr double k_distance_radii = 3.0;
/// Points of one surface lie within so many radii of its mean, or so many thicknesses of the point's sheet.
constexpr double k_window_radii = 1.0 / 6.0, k_window_thicknesses = 3.0;
/// The means of both surfaces may be so many radii apart across the axis. Where one epoch has points on one
/// side only, as at the hole below a scanner, an error of the normal would be taken for a distance.
constexpr double k_most_aside = 0.4;
/// Cosine between normals of one surface: 45 degrees.
constexpr double k_least_parallel = 0.70710678118654752;

/// One epoch with the queries that comparisons need.
class EpochCloud {
 public:
  explicit EpochCloud(const Epoch& epoch)
      : epoch_(epoch),
        spacings_(spacings_in_order(octree())),
        largest_spacing_(epoch.occluders.largest_radius() / k_disc_spacings) {}

  const Octree& octree() const { return epoch_.occluders.octree(); }
  const Occluders& occluders() const { return epoch_.occluders; }
  const CountedPoints& counts() const { return occluders().options().counts; }
  bool is_counted(std::uint64_t id) const { return !counts() || counts()(id); }
  std::span<const glm::dvec3> origins() const { return epoch_.origins; }
  /// Metres; limited, since that of a single point may be the length of the site, and that of
  /// a few points is infinite.
  double spacing(std::uint64_t id) const { return std::min<double>(spacings_[id], largest_spacing_); }
  bool has_spacing(std::uint64_t id) const { return std::isfinite(spacings_[id]); }

  PointSurface surface(std::uint64_t id) const { return occluders().surface(id); }

  /// The points nearest to a position, within a distance.
  std::vector<PointHit> nearest(const glm::dvec3& position, std::size_t k,
                                double distance = k_unlimited_radius) const {
    PointQuery query{.radius = distance, .k = k};
    if (counts()) query.filter = [this](const Candidate& point) { return counts()(point.point_id); };
    return find(octree(), position, query);
  }

  /// Whether a point counts and is on a surface that is parallel within 45 degrees.
  bool is_parallel(std::uint64_t id, const glm::dvec3& normal) const {
    if (!is_counted(id)) return false;
    const PointSurface other = surface(id);
    return other.exists && std::fabs(glm::dot(other.normal, normal)) >= k_least_parallel;
  }

  /// The surface of the parallel points in a cylinder.
  std::optional<CylinderSurface> surface_in(const Cylinder& cylinder) const {
    return nearest_surface(octree(), cylinder, 0.0,
                           [&](std::uint64_t id) { return is_parallel(id, cylinder.axis); });
  }

  /// 1 if the normal of a point points to the nearest scanner that sees it, or upwards if no scanner is
  /// known; -1 if it points the other way.
  double side_of(std::uint64_t id, const glm::dvec3& position, const glm::dvec3& normal) const {
    const auto side_towards = [&](const glm::dvec3& way) { return glm::dot(way, normal) < 0.0 ? -1.0 : 1.0; };
    if (origins().empty()) return side_towards({0.0, 0.0, 1.0});
    const double first = side_towards(origins().front() - position);
    const bool all_agree = std::ranges::all_of(
        origins(), [&](const glm::dvec3& origin) { return side_towards(origin - position) == first; });
    if (all_agree) return first;
    std::vector<glm::dvec3> by_distance = epoch_.origins;
    std::ranges::stable_sort(by_distance, {}, [&](const glm::dvec3& origin) {
      return glm::dot(origin - position, origin - position);
    });
    // A blocker within some spacings is of the same surface.
    constexpr double k_own_spacings = 3.0;
    const auto is_seen_from = [&](const glm::dvec3& origin) {
      const SightLine line = sight_line({origin}, end_on_point(occluders(), id, position, origin));
      const std::optional<Blocker> blocker = first_blocker(occluders(), line);
      return !blocker || blocker->distance >= line.length - k_own_spacings * spacing(id);
    };
    const auto seen_from = std::ranges::find_if(by_distance, is_seen_from);
    return side_towards((seen_from == by_distance.end() ? by_distance.front() : *seen_from) - position);
  }

 private:
  const Epoch& epoch_;
  HugeVector<float> spacings_;
  double largest_spacing_;
};

/// A point of one epoch, and the lengths that it is compared by.
struct ComparedPoint {
  std::uint64_t id = 0;
  glm::dvec3 position{0.0};
  PointSurface surface;
  double spacing = 0.0;           ///< metres
  double near_limit = 0.0;        ///< a point of the other epoch within this is the same thing, metres
  double nearest = 0.0;           ///< distance to the nearest point of the other epoch, metres
  double radius = 0.0;            ///< of the cylinder, metres
  double max_distance = 0.0;      ///< metres
  double window = 0.0;            ///< metres
  bool has_wider_normal = false;  ///< PointChanges::wider_normals
  /// Whether a point of the other epoch within near_limit is found to be the same thing without a distance.
  bool is_same_if_near = true;
};

struct Finding {
  ChangeClass kind = ChangeClass::never_seen;
  float distance = k_none, detection_level = k_none;
  bool has_normal = true, has_wider_normal = false;
};

/// What a line of sight of the other epoch shows about a position.
enum class Sight { unknown, hidden, met, passed };

/// Compares points of one epoch with the other.
class Comparison {
 public:
  /// `sign`: 1 for points of BEFORE, -1 for those of AFTER.
  Comparison(const EpochCloud& own, const EpochCloud& other, const ChangeOptions& options, int sign)
      : own_(own), other_(other), options_(options), sign_(sign) {}

  /// Requires a point that counts.
  Finding compare(std::uint64_t id, const glm::dvec3& position) const {
    const ComparedPoint point = measured(id, position);
    Finding finding = by_distance(point);
    if (std::isnan(finding.distance)) finding.kind = without_distance(point, finding.kind);
    finding.has_normal = point.surface.exists;
    finding.has_wider_normal = point.has_wider_normal;
    return finding;
  }

 private:
  /// Sets `surface` and `has_wider_normal`.
  void find_surface(ComparedPoint& point) const {
    // Fewer points lower the trust in a plane by their number alone.
    constexpr double k_enough_points = 9.0;
    point.surface = own_.surface(point.id);
    if (!options_.normal_radius) return;
    const LocalPlane plane = local_plane(own_.octree(), point.position, *options_.normal_radius);
    const bool is_trusted = plane.trust >= k_least_surface_trust;
    point.has_wider_normal = !is_trusted && plane.count < k_enough_points;
    if (!point.has_wider_normal) point.surface = {is_trusted, plane.normal, plane.height, plane.thickness};
  }

  ComparedPoint measured(std::uint64_t id, const glm::dvec3& position) const {
    ComparedPoint point{.id = id, .position = position, .surface = {}};
    find_surface(point);
    point.spacing = own_.spacing(id);
    const std::vector<PointHit> nearest = other_.nearest(position, 1);
    point.nearest = nearest.empty() ? std::numeric_limits<double>::infinity() : nearest.front().distance;
    point.near_limit =
        std::max(point.spacing, nearest.empty() ? 0.0 : other_.spacing(nearest.front().point_id));
    point.is_same_if_near = !options_.normal_radius && !options_.cylinder_radius && own_.has_spacing(id) &&
                            (nearest.empty() || other_.has_spacing(nearest.front().point_id));
    point.radius = options_.cylinder_radius.value_or(k_cylinder_spacings * point.near_limit);
    point.max_distance = options_.max_distance.value_or(k_distance_radii * point.radius);
    point.window = std::max(k_window_radii * point.radius, k_window_thicknesses * point.surface.thickness);
    return point;
  }

  /// Steps 1 and 2 of find_changes(). Without a distance: not_measured if the other epoch has points within
  /// reach, in the cylinder if there is one; else unmatched.
  Finding by_distance(const ComparedPoint& point) const {
    Finding finding = by_surfaces(point);
    if (std::isnan(finding.distance) && point.nearest == 0.0) {
      const CylinderSurface alone{.count = 1};
      const double level = detection_level(alone, alone, options_.registration_error);
      finding = {ChangeClass::same, 0.0f, static_cast<float>(level)};
    }
    return finding;
  }

  Finding by_surfaces(const ComparedPoint& point) const {
    if (!(point.nearest <= std::hypot(point.radius, point.max_distance))) return {ChangeClass::unmatched};
    if (!point.surface.exists) return {ChangeClass::not_measured};
    const Cylinder cylinder{point.position, point.surface.normal, point.radius, point.max_distance,
                            point.window};
    const std::optional<CylinderSurface> other = other_.surface_in(cylinder);
    if (!other) return {ChangeClass::unmatched};
    if (other->count < k_least_cylinder_points) return {ChangeClass::not_measured};
    const std::optional<CylinderSurface> own = own_.surface_in(cylinder);
    if (!own || own->count < k_least_cylinder_points) return {ChangeClass::not_measured};
    const double offset = other->t - own->t;
    if (glm::length(other->middle - own->middle - offset * cylinder.axis) > k_most_aside * point.radius)
      return {ChangeClass::not_measured};
    const double level = detection_level(*own, *other, options_.registration_error);
    const double side = own_.side_of(point.id, point.position, point.surface.normal);
    return {std::fabs(offset) > level ? ChangeClass::moved : ChangeClass::same,
            static_cast<float>(sign_ * side * offset), static_cast<float>(level)};
  }

  /// Steps 3 and 4. `found`: the class from by_distance().
  ChangeClass without_distance(const ComparedPoint& point, ChangeClass found) const {
    const ChangeClass kind = is_near(point) ? ChangeClass::same : by_sight(point);
    if (point.is_same_if_near) return kind;
    const bool is_open =
        kind == ChangeClass::same || (kind == ChangeClass::unmatched && found == ChangeClass::not_measured);
    return is_open ? ChangeClass::not_measured : kind;
  }

  /// Step 3: whether the other epoch has a point here. One on a surface must be on the same as
  /// the point, if that has one.
  bool is_near(const ComparedPoint& point) const {
    constexpr std::size_t k_neighbours = 8;
    if (point.nearest > point.near_limit) return false;
    if (!point.surface.exists) return true;
    const glm::dvec3& normal = point.surface.normal;
    return std::ranges::any_of(
        other_.nearest(point.position, k_neighbours, point.near_limit), [&](const PointHit& hit) {
          if (!other_.surface(hit.point_id).exists) return hit.distance <= point.spacing;
          return other_.is_parallel(hit.point_id, normal) &&
                 std::fabs(glm::dot(hit.position - point.position, normal)) <= point.window;
        });
  }

  /// Step 4.
  ChangeClass by_sight(const ComparedPoint& point) const {
    if (other_.origins().empty()) return ChangeClass::unmatched;
    bool is_met = false;
    for (const glm::dvec3& origin : other_.origins()) {
      const Sight sight = sight_from(origin, point);
      if (sight == Sight::passed) return sign_ > 0 ? ChangeClass::gone : ChangeClass::appeared;
      is_met = is_met || sight == Sight::met;
    }
    return is_met ? ChangeClass::same : ChangeClass::never_seen;
  }

  Sight sight_from(const glm::dvec3& origin, const ComparedPoint& point) const {
    const glm::dvec3 way = point.position - origin;
    const double distance = glm::length(way);
    if (!(distance > point.radius && distance <= options_.max_range)) return Sight::unknown;
    const std::optional<Blocker> blocker =
        first_blocker(other_.occluders(), sight_ray({origin}, way, options_.max_range));
    if (!blocker) return Sight::unknown;
    const double behind = blocker->distance - distance;
    if (std::fabs(behind) <= point.spacing) return Sight::met;
    if (behind < 0.0) return Sight::hidden;
    if (is_same_plane(point, *blocker)) return Sight::met;
    const glm::dvec3 direction = way / distance;
    return is_aimed(point, distance, *blocker) && is_front(*blocker, direction) ? Sight::passed
                                                                                : Sight::unknown;
  }

  /// Whether a line that grazes the surface of a point ends on it, behind the point.
  bool is_same_plane(const ComparedPoint& point, const Blocker& blocker) const {
    constexpr double k_near_spacings = 16.0;
    const glm::dvec3 offset = blocker.position - point.position;
    return point.surface.exists && glm::length(offset) <= k_near_spacings * point.spacing &&
           std::fabs(glm::dot(offset, point.surface.normal)) <= point.window &&
           other_.is_parallel(blocker.point_id, point.surface.normal);
  }

  /// Whether a line ends on the side of a surface that was scanned. Where there are no points, as below a
  /// scanner, lines pass through the ground and end on surfaces from behind.
  bool is_front(const Blocker& blocker, const glm::dvec3& direction) const {
    const PointSurface surface = other_.surface(blocker.point_id);
    return !surface.exists || other_.side_of(blocker.point_id, blocker.position, surface.normal) *
                                      glm::dot(surface.normal, direction) <
                                  0.0;
  }

  /// Whether points at this distance from the scanner are dense enough for one of its beams to
  /// have met the point's surface.
  bool is_aimed(const ComparedPoint& point, double distance, const Blocker& blocker) const {
    // A surface is fitted to points within 2.5 spacings; a point without one reaches to its neighbours.
    constexpr double k_width_of_surface = 5.0, k_width_of_lone = 1.6;
    const double between = other_.spacing(blocker.point_id) * distance / blocker.distance;
    return between <= (point.surface.exists ? k_width_of_surface : k_width_of_lone) * point.spacing;
  }

  const EpochCloud& own_;
  const EpochCloud& other_;
  const ChangeOptions& options_;
  int sign_;
};

PointChanges compare_all(const EpochCloud& own, const EpochCloud& other, const ChangeOptions& options,
                         int sign, const Progress& progress) {
  const Comparison comparison(own, other, options, sign);
  const TreeView& tree = own.octree().view();
  const ScratchFolder& scratch = own.octree().scratch();
  PointChanges changes{HugeVector<ChangeClass>(tree.point_count, scratch),
                       HugeVector<float>(tree.point_count, scratch),
                       HugeVector<float>(tree.point_count, scratch)};
  std::atomic<std::uint64_t> without_normal = 0, too_few_points = 0, wider_normals = 0;
  for_each_leaf_in_parallel(tree, progress, [&] {
    return [&, last = std::optional<LatticePosition>(), of_last = Finding()](const Leaf& leaf) mutable {
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const std::uint64_t id = point_id(tree, leaf.first + i);
        const LatticePosition position = position_of(tree, leaf, i);
        Finding finding{ChangeClass::ignored};
        if (own.is_counted(id)) {
          // A scan may have a million points of one position; they have one finding and
          // mostly follow each other.
          if (last != position) of_last = comparison.compare(id, to_world(tree.lattice, position));
          last = position;
          finding = of_last;
        }
        changes.classes[id] = finding.kind;
        changes.distances[id] = finding.distance;
        changes.detection_levels[id] = finding.detection_level;
        if (finding.has_wider_normal) ++wider_normals;
        if (finding.kind == ChangeClass::not_measured)
          ++(finding.has_normal ? too_few_points : without_normal);
      }
    };
  });
  changes.without_normal = without_normal;
  changes.too_few_points = too_few_points;
  changes.wider_normals = wider_normals;
  return changes;
}

void check_epoch(const Epoch& epoch, const char* name) {
  const OccluderOptions& occluders = epoch.occluders.options();
  check_that(epoch.occluders.octree().size() > 0, fmt::format("the epoch {} has no points", name));
  check_that(epoch.occluders.has_surfaces() && !occluders.radius && occluders.transparency == 1 &&
                 !occluders.mesh && !occluders.terrain,
             "unsupported occluders for change detection", "default shape, radius and transparency");
  for (const glm::dvec3& origin : epoch.origins)
    if (!is_finite(origin))
      throw input_error(fmt::format("a scanner position of {} is not finite", name), "");
}

void check_options(const ChangeOptions& options) {
  const auto check = [](const char* name, std::optional<double> value) {
    if (value && !(*value > 0.0 && std::isfinite(*value)))
      throw input_error(fmt::format("invalid {}", name), "a positive length", fmt::format("{}", *value));
  };
  check("radius of normals", options.normal_radius);
  check("radius of cylinders", options.cylinder_radius);
  check("maximum distance", options.max_distance);
  check_that(options.max_range > 0.0, "invalid range of the scanners", "a positive length",
             fmt::format("{}", options.max_range));
  check_that(options.registration_error >= 0.0 && std::isfinite(options.registration_error),
             "invalid registration error", "at least 0", fmt::format("{}", options.registration_error));
}

/// Reorders the values.
std::optional<double> median(HugeVector<float>& values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The hits within a window around t. Requires hits in order of t.
std::span<const Hit> around(std::span<const Hit> hits, double t, double window) {
  const auto begin = std::ranges::lower_bound(hits, t - window, {}, &Hit::t);
  const auto end = std::ranges::upper_bound(hits, t + window, {}, &Hit::t);
  return {begin, end};
}

double mean_of(std::span<const Hit> hits) {
  double sum = 0.0;
  for (const Hit& hit : hits) sum += hit.t;
  return sum / static_cast<double>(hits.size());
}

double deviation_of(std::span<const Hit> hits, double mean) {
  if (hits.size() < 2) return 0.0;
  double sum = 0.0;
  for (const Hit& hit : hits) sum += (hit.t - mean) * (hit.t - mean);
  return std::sqrt(sum / static_cast<double>(hits.size() - 1));
}

}  // namespace

const char* name_of(ChangeClass kind) {
  constexpr std::array<const char*, k_change_classes> k_names{
      "same", "moved", "gone", "new", "never seen", "unmatched", "ignored", "not measured"};
  return k_names[static_cast<std::size_t>(kind)];
}

void check_overlap(const Octree& before_cloud, const Octree& after_cloud) {
  const Bounds &before = before_cloud.bounds(), &after = after_cloud.bounds();
  const auto text = [](const Bounds& box) {
    return fmt::format("{:.2f},{:.2f},{:.2f} to {:.2f},{:.2f},{:.2f}", box.min.x, box.min.y, box.min.z,
                       box.max.x, box.max.y, box.max.z);
  };
  // Bounds of flat ground do not overlap if it has moved vertically.
  constexpr double k_room = 0.1;
  const glm::dvec3 size = glm::max(before.size(), after.size());
  const double room = k_room * std::max({size.x, size.y, size.z});
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis)
    overlap =
        overlap && before.min[axis] - room <= after.max[axis] && after.min[axis] - room <= before.max[axis];
  check_that(overlap, "the epochs do not overlap", "two scans of one site in one reference system",
             fmt::format("before {}, after {}", text(before), text(after)));
}

Changes find_changes(const Epoch& before, const Epoch& after, const ChangeOptions& options) {
  check_epoch(before, "BEFORE");
  check_epoch(after, "AFTER");
  check_options(options);
  check_overlap(before.occluders.octree(), after.occluders.octree());
  const EpochCloud old_cloud(before), new_cloud(after);
  const std::uint64_t old_points = old_cloud.octree().size();
  const std::uint64_t points = old_points + new_cloud.octree().size();
  const auto from = [&](std::uint64_t first) -> Progress {
    if (!options.progress) return {};
    return [&options, first, points](std::uint64_t done, std::uint64_t) {
      return options.progress(first + done, points);
    };
  };
  Changes changes;
  changes.before = compare_all(old_cloud, new_cloud, options, 1, from(0));
  changes.after = compare_all(new_cloud, old_cloud, options, -1, from(old_points));
  return changes;
}

std::vector<ChangeSummary> summaries_of(const PointChanges& changes, const Occluders& occluders) {
  const HugeVector<float> spacings = spacings_in_order(occluders.octree());
  std::vector<ChangeSummary> summaries(k_change_classes);
  for (std::size_t id = 0; id < changes.classes.size(); ++id) {
    ChangeSummary& summary = summaries[static_cast<std::size_t>(changes.classes[id])];
    ++summary.count;
    if (std::isfinite(spacings[id])) summary.area += area_of_point(spacings[id]);
  }
  HugeVector<float> some(occluders.octree().scratch());
  some.reserve(changes.classes.size());
  for (std::size_t kind = 0; kind < summaries.size(); ++kind) {
    const auto median_of = [&](const HugeVector<float>& values) {
      some.clear();
      for (std::size_t id = 0; id < values.size(); ++id)
        if (static_cast<std::size_t>(changes.classes[id]) == kind && !std::isnan(changes.distances[id]))
          some.push_back(values[id]);
      return median(some);
    };
    ChangeSummary& summary = summaries[kind];
    summary.median_distance = median_of(changes.distances);
    summary.measured = some.size();
    for (float& distance : some) distance = std::fabs(distance);
    summary.median_absolute_distance = median(some);
    summary.median_detection_level = median_of(changes.detection_levels);
  }
  return summaries;
}

std::optional<CylinderSurface> nearest_surface(const Octree& octree, const Cylinder& cylinder, double t,
                                               const CountedPoints& counts) {
  constexpr int k_most_steps = 8;
  RayQuery query{.radius = cylinder.radius, .measure = Measure::t};
  if (counts) query.filter = [&counts](const Candidate& point) { return counts(point.point_id); };
  const Ray axis{cylinder.center, cylinder.axis, -cylinder.half_length, cylinder.half_length};
  const std::vector<Hit> all = find(octree, axis, query);
  if (all.empty()) return std::nullopt;
  double mean = std::ranges::min_element(all, {}, [t](const Hit& hit) { return std::fabs(hit.t - t); })->t;
  std::span<const Hit> surface;
  for (int step = 0; step < k_most_steps; ++step) {
    const std::span<const Hit> next = around(all, mean, cylinder.window);
    // The mean of two halves may be far from all points.
    if (next.empty() || (next.data() == surface.data() && next.size() == surface.size())) break;
    surface = next;
    mean = mean_of(surface);
  }
  // Relative to the centre, since sums of map coordinates would lose digits.
  glm::dvec3 sum(0.0);
  for (const Hit& hit : surface) sum += hit.position - cylinder.center;
  return CylinderSurface{surface.size(), mean, deviation_of(surface, mean),
                         cylinder.center + sum / static_cast<double>(surface.size())};
}

double detection_level(const CylinderSurface& one, const CylinderSurface& other, double registration_error) {
  constexpr double k_confidence = 1.96;  // of a normal distribution, 95 % lie within so many deviations
  const auto variance = [](const CylinderSurface& surface) {
    return surface.deviation * surface.deviation / static_cast<double>(surface.count);
  };
  return k_confidence * (std::sqrt(variance(one) + variance(other)) + registration_error);
}

}  // namespace alidade::visibility
