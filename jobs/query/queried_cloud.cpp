// SPDX-License-Identifier: MIT
#include "jobs/query/queried_cloud.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "base/error.h"
#include "base/ray_slabs.h"
#include "cloud/read_cloud.h"
#include "cloud/rows.h"
#include "jobs/cloud_formats.h"
#include "jobs/load_cloud.h"
#include "jobs/query/targets.h"
#include "octree/build.h"

namespace alidade::jobs {
namespace {

/// A margin above the rounding errors of coordinates of this size.
double margin_of(std::initializer_list<glm::dvec3> positions, double radius) {
  constexpr double k_share = 1e-9;
  double largest = radius;
  for (const glm::dvec3& position : positions)
    largest = std::max({largest, std::fabs(position.x), std::fabs(position.y), std::fabs(position.z)});
  return k_share * largest;
}

Bounds widened(const Bounds& box, double by) {
  return box.empty() ? box : Bounds{box.min - by, box.max + by};
}

// target_bounds() is a box around all points that can answer a target, which are at most `radius` from it, of
// a cloud in the box `within`. It is a little larger than necessary, so that rounding leaves no point out;
// it is empty if no point can answer. Cones, half-spaces and boxes ignore `radius`.

Bounds target_bounds(const Ray& ray, double radius, const Bounds& within) {
  if (within.empty() || !(ray.t_min <= ray.t_max)) return {};
  // A point in the box projects to a position on the ray that is at most `radius` outside of the box.
  const double margin = margin_of({ray.origin, within.min, within.max}, radius);
  const Bounds box = widened(within, radius + margin);
  const RaySlabs slabs(ray.origin, ray.direction);
  Stretch inside{ray.t_min, ray.t_max};
  for (int axis = 0; axis < 3; ++axis) inside.cut(slabs.between(axis, box.min[axis], box.max[axis]));
  if (inside.empty()) return {};
  Bounds bounds;
  bounds.grow(ray.position(inside.begin));
  bounds.grow(ray.position(inside.end));
  return widened(bounds, radius + margin);
}

Bounds target_bounds(const Cone& cone, double, const Bounds& within) {
  if (within.empty()) return {};
  // The farthest position along the axis that a point can project to is that of a corner; there the cone is
  // widest.
  Ray axis = cone.axis;
  double farthest = -std::numeric_limits<double>::infinity();
  for (const glm::dvec3& corner : corners(within))
    farthest = std::max(farthest, glm::dot(corner - axis.origin, axis.direction));
  axis.t_max = std::min(axis.t_max, farthest + margin_of({axis.origin, within.min, within.max}, 0.0));
  const double widest = cone.limit(axis.t_max);
  if (!(widest >= 0.0)) return {};
  return target_bounds(axis, widest, within);
}

Bounds target_bounds(const Path& path, double radius, const Bounds&) {
  Bounds bounds;
  for (const glm::dvec3& vertex : path.vertices) bounds.grow(vertex);
  return widened(bounds, radius + margin_of({bounds.min, bounds.max}, radius));
}

Bounds target_bounds(const HalfSpaces&, double, const Bounds& within) {
  return within;
}

Bounds target_bounds(const Bounds& box, double, const Bounds&) {
  return box;
}

Bounds target_bounds(const glm::dvec3& position, double radius, const Bounds&) {
  return widened({position, position}, radius + margin_of({position}, radius));
}

constexpr std::size_t k_batch = 4096;

/// A first pass through the targets gives up beyond so many.
constexpr std::uint64_t k_most_surveyed = 1'000'000;

/// Of more targets, one box around all is the filter.
constexpr std::size_t k_most_filters = 4096;

/// A filter that admits all points that can answer a target, and maybe some more.
template <class Target>
database::PointFilter filter_of(const Target& target, double radius, const Bounds& within) {
  database::PointFilter filter;
  if constexpr (std::is_same_v<Target, Ray>) {
    filter.lines.push_back({target, {0.0, radius}, {target.t_min - radius, target.t_max + radius}});
  } else if constexpr (std::is_same_v<Target, HalfSpaces>) {
    for (const Plane& plane : target.planes)
      filter.planes.push_back({plane, {0.0, std::numeric_limits<double>::infinity()}});
  } else {
    filter.box = target_bounds(target, radius, within);
  }
  return filter;
}

/// Whether targets can be read twice, and the distance of their answers is limited.
template <class Target>
bool can_be_surveyed(const CheckedQuery& query) {
  return (QueryFamily<Target>::limits_itself || query.radius) && query.given_targets().can_be_reread();
}

/// What a first pass through the targets finds.
struct Survey {
  Bounds region;                               ///< all points that can answer are in here
  std::vector<database::PointFilter> filters;  ///< and one of these holds for each
};

/// Surveys the targets on a cloud in the box `within`. Empty if they are too many, or, without `filters`, if
/// their region is the whole box.
template <class Target>
std::optional<Survey> survey(const CheckedQuery& query, const Bounds& within, bool with_filters,
                             Listener& listener) {
  const double radius = query.radius.value_or(0.0);
  TargetReader<Target> reader(query, [&listener] { return listener.stops(); });
  TargetBatch<Target> batch;
  Survey found;
  for (std::uint64_t count = 0; reader.next(k_batch, batch);) {
    count += batch.targets.size();
    if (count > k_most_surveyed) return std::nullopt;
    for (const Target& target : batch.targets) {
      if (with_filters && found.filters.size() <= k_most_filters)
        found.filters.push_back(filter_of(target, radius, within));
      found.region.grow(target_bounds(target, radius, within));
    }
    if (!with_filters && found.region.contains(within.min) && found.region.contains(within.max))
      return std::nullopt;
  }
  if (found.filters.size() > k_most_filters) found.filters = {database::PointFilter{.box = found.region}};
  return found;
}

/// A box that contains all points that can answer; empty if it is unknown.
template <class Target>
std::optional<Bounds> query_region(const CheckedQuery& query, Listener& listener) {
  if (query.files.size() < 2 || std::is_same_v<Target, HalfSpaces> || query.partial || query.max_level ||
      query.form == AnswerForm::las || !can_be_surveyed<Target>(query))
    return std::nullopt;
  const std::optional<Survey> found = survey<Target>(query, stated_box(query.files), false, listener);
  return found ? std::optional(found->region) : std::nullopt;
}

AttributeSet needed_attributes(const CheckedQuery& query) {
  if (query.form == AnswerForm::las) return AttributeSet::all();
  return query.classes ? AttributeSet(Attribute::classification) : AttributeSet();
}

/// The part of a cloud in a database that can answer; empty if that is the whole cloud, or unknown.
template <class Target>
std::optional<database::CloudPart> read_part(const CheckedQuery& query, Listener& listener) {
  const CloudInput& input = query.files.inputs.front();
  if (query.files.size() != 1 || query.partial || query.max_level || !has_parts(input) ||
      !can_be_surveyed<Target>(query))
    return std::nullopt;
  const std::optional<Survey> found = survey<Target>(query, stated_size(query.files).box, true, listener);
  if (!found) return std::nullopt;
  const std::string unit = part_unit(input);
  const auto stage = listener.begin("loading " + unit, unit);
  database::CloudPart part =
      read_database_part(input, found->filters, needed_attributes(query), stage->callback());
  // A LAS file has the columns of the cloud even if it has no points.
  if (part.ids.empty() && query.form == AnswerForm::las) return std::nullopt;
  stage->finish();
  return part;
}

[[noreturn]] void reject_classes(const CheckedQuery& query) {
  throw file_error(query.files.first_name(), "--classes requires classification", "a classified cloud");
}

IndexedCloud load_files(const CheckedQuery& query, const std::optional<Bounds>& region, Listener& listener) {
  IndexCloudOptions options;
  options.read.region = region;
  options.read.attributes = needed_attributes(query);
  if (query.max_level) options.build.organisation = Organisation::layered;
  IndexedCloud cloud = load_cloud(query.files, query.partial, options, listener);
  const std::size_t all_files = cloud.cloud.files.size();
  const std::size_t skipped_files = RowIds(cloud.cloud.files).skipped_files();
  if (skipped_files > 0)
    listener.note(fmt::format("read {} of {} files: no target reaches the bounds of the others",
                              all_files - skipped_files, all_files));
  return cloud;
}

}  // namespace

bool queries_in_place(const CheckedQuery& query) {
  if (query.is_loaded || query.partial || query.max_level || query.form == AnswerForm::las) return false;
  if (query.files.only(k_copc_format) != nullptr) return true;
  return std::ranges::all_of(query.files.inputs, [](const CloudInput& input) {
    return input.is(k_copc_format) && input.stated && !input.is_changed();
  });
}

std::unique_ptr<CopcTiles> open_copc(const CheckedQuery& query, Listener& listener) {
  CopcCache::Options options;
  options.classes = query.classes;
  if (query.memory) options.byte_count = *query.memory;
  options.progress = [&listener](std::uint64_t, std::uint64_t) { return !listener.stops(); };
  auto tiles = std::make_unique<CopcTiles>(query.files, options);
  warn_all(listener, tiles->warnings());
  return tiles;
}

std::function<std::uint64_t(std::uint64_t)> QueriedCloud::ids() const {
  if (part) return [&ids = part->ids](std::uint64_t row) { return ids[row]; };
  RowIds ids(indexed.cloud.files);
  if (ids.skipped_files() == 0) return {};
  return ids;
}

CandidateFilter QueriedCloud::class_filter(const CheckedQuery& query) const {
  if (!query.classes || indexed.octree.size() == 0) return {};
  const std::span<const std::uint8_t> classifications = indexed.columns().classifications;
  if (classifications.empty()) {
    // Points of files without classes have class 0 beside files with classes, even if none of these was read.
    if (RowIds(indexed.cloud.files).skipped_files() > 0)
      return [is_wanted = query.classes->test(0)](const Candidate&) { return is_wanted; };
    reject_classes(query);
  }
  return [classes = *query.classes, classifications](const Candidate& point) {
    return classes.test(classifications[point.point_id]);
  };
}

template <class Target>
QueriedCloud load_queried(const CheckedQuery& query, Listener& listener) {
  QueriedCloud cloud;
  cloud.part = read_part<Target>(query, listener);
  if (!cloud.part) {
    cloud.indexed = load_files(query, query_region<Target>(query, listener), listener);
    return cloud;
  }
  if (query.classes && !cloud.part->attributes.contains(Attribute::classification)) reject_classes(query);
  cloud.indexed.cloud = std::move(cloud.part->cloud);
  cloud.indexed.octree = build(std::move(cloud.indexed.cloud));
  return cloud;
}

template QueriedCloud load_queried<Ray>(const CheckedQuery&, Listener&);
template QueriedCloud load_queried<Cone>(const CheckedQuery&, Listener&);
template QueriedCloud load_queried<Path>(const CheckedQuery&, Listener&);
template QueriedCloud load_queried<HalfSpaces>(const CheckedQuery&, Listener&);
template QueriedCloud load_queried<Bounds>(const CheckedQuery&, Listener&);
template QueriedCloud load_queried<glm::dvec3>(const CheckedQuery&, Listener&);

}  // namespace alidade::jobs
