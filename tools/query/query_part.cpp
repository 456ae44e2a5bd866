// SPDX-License-Identifier: MIT
#include "tools/query/query_part.h"

#include <algorithm>
#include <type_traits>

#include "cloud/cloud_inputs.h"
#include "cloud/read_cloud.h"
#include "tools/cloud/load_cloud.h"
#include "tools/query/queried_cloud.h"
#include "tools/query/target_bounds.h"
#include "tools/query/target_reader.h"

namespace alidade {
namespace {

/// More than these are asked for by one box around all.
constexpr std::size_t k_most_filters = 4096;

/// What holds for all points that can answer a target; maybe for some more.
template <class Target>
PointFilter filter_of(const Target& target, double radius, const Bounds& within) {
  PointFilter filter;
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

/// Whether the only cloud lies in a database that can be asked for a part of it.
bool lies_in_asked_database(const QueryCommand& command) {
  return command.files.size() == 1 && !command.partial && !command.max_level &&
         has_parts(command.files.front());
}

}  // namespace

template <class Target>
std::optional<CloudPart> read_query_part(const QueryCommand& command, TargetFamily family,
                                         AttributeSet attributes, const Progress& progress) {
  constexpr bool needs_radius =
      std::is_same_v<Target, Ray> || std::is_same_v<Target, Path> || std::is_same_v<Target, glm::dvec3>;
  if (!lies_in_asked_database(command) || (needs_radius && !command.radius) ||
      !can_be_read_twice(command.targets[static_cast<std::size_t>(family)]))
    return std::nullopt;
  const Bounds within = stated_box(command.files);
  TargetReader<Target> reader(open_targets(command, family), {command.t_min, command.t_max});
  TargetBatch<Target> batch;
  std::vector<PointFilter> filters;
  Bounds region;
  std::uint64_t count = 0;
  while (reader.next(k_most_filters, batch)) {
    count += batch.targets.size();
    if (count > k_most_looked_through) return std::nullopt;
    for (const Target& target : batch.targets) {
      const double radius = command.radius.value_or(0.0);
      if (count <= k_most_filters) filters.push_back(filter_of(target, radius, within));
      region.grow(target_bounds(target, radius, within));
    }
  }
  if (count > k_most_filters) {
    filters.resize(1);
    filters.front() = PointFilter{.box = region};
  }
  return read_database_part(command.files.front(), filters, attributes, progress);
}

template std::optional<CloudPart> read_query_part<Ray>(const QueryCommand&, TargetFamily, AttributeSet,
                                                       const Progress&);
template std::optional<CloudPart> read_query_part<Cone>(const QueryCommand&, TargetFamily, AttributeSet,
                                                        const Progress&);
template std::optional<CloudPart> read_query_part<Path>(const QueryCommand&, TargetFamily, AttributeSet,
                                                        const Progress&);
template std::optional<CloudPart> read_query_part<HalfSpaces>(const QueryCommand&, TargetFamily, AttributeSet,
                                                              const Progress&);
template std::optional<CloudPart> read_query_part<Bounds>(const QueryCommand&, TargetFamily, AttributeSet,
                                                          const Progress&);
template std::optional<CloudPart> read_query_part<glm::dvec3>(const QueryCommand&, TargetFamily, AttributeSet,
                                                              const Progress&);

}  // namespace alidade
