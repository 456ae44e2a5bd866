// SPDX-License-Identifier: MIT
#include "tools/query/queried_cloud.h"

#include <fmt/format.h>
#include <cmath>
#include <glm/geometric.hpp>

#include "tools/cloud/load_cloud.h"
#include "tools/query/target_reader.h"

namespace alidade::tools {
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

/// The part of the interval on t in which the axis lies in the box; inverted if there is none.
void clip(const Ray& axis, const Bounds& box, double& t_min, double& t_max) {
  for (int i = 0; i < 3; ++i) {
    const double low = box.min[i] - axis.origin[i], high = box.max[i] - axis.origin[i];
    if (axis.direction[i] == 0.0) {
      if (low > 0.0 || high < 0.0) t_max = -std::numeric_limits<double>::infinity();
      continue;
    }
    const double a = low / axis.direction[i], b = high / axis.direction[i];
    t_min = std::max(t_min, std::min(a, b));
    t_max = std::min(t_max, std::max(a, b));
  }
}

// target_bounds() is a box around all points that can answer a target, which are at most `radius` from it, of
// a cloud in the box `within`. It is a little larger than necessary, so that rounding leaves no point out;
// empty if there are none. `radius` does not apply to cones, half-spaces and boxes.

Bounds target_bounds(const Ray& ray, double radius, const Bounds& within) {
  if (within.empty() || !(ray.t_min <= ray.t_max)) return {};
  // A point in the box projects to a position on the ray that is at most `radius` outside of the box.
  const double margin = margin_of({ray.origin, within.min, within.max}, radius);
  double t_min = ray.t_min, t_max = ray.t_max;
  clip(ray, widened(within, radius + margin), t_min, t_max);
  if (t_min > t_max) return {};
  Bounds bounds;
  bounds.grow(ray.position(t_min));
  bounds.grow(ray.position(t_max));
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
bool can_be_surveyed(const QueryCommand& command) {
  constexpr bool needs_radius =
      std::is_same_v<Target, Ray> || std::is_same_v<Target, Path> || std::is_same_v<Target, glm::dvec3>;
  std::error_code error;
  const std::string& text = command.given().text;
  return (!needs_radius || command.radius) && (text.empty() || std::filesystem::is_regular_file(text, error));
}

}  // namespace

bool queries_in_place(const QueryCommand& command, AnswerForm form) {
  if (command.is_loaded || command.partial || command.max_level || form == AnswerForm::las) return false;
  if (command.files.only(k_copc_format) != nullptr) return true;
  return std::ranges::all_of(command.files.inputs, [](const CloudInput& input) {
    return input.is(k_copc_format) && input.stated && !input.is_changed();
  });
}

std::unique_ptr<CopcTiles> open_copc(const QueryCommand& command) {
  CopcCache::Options options;
  options.classes = command.classes;
  if (command.memory) options.byte_count = *command.memory;
  options.progress = [](std::uint64_t, std::uint64_t) { return !interrupted(); };
  return std::make_unique<CopcTiles>(command.files, options);
}

std::string copc_table(const CopcTiles& tiles) {
  const CopcTiles::Work work = tiles.work();
  const auto row = [](const char* name, std::uint64_t part, std::uint64_t all) {
    const double share = all > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(all) : 0.0;
    return fmt::format("{:<22}{:>16}{:>15.2f}%\n", name, part, share);
  };
  std::string text;
  if (tiles.size() > 1) text += row("files opened", work.files_opened, tiles.size());
  return text +
         row(tiles.size() > 1 ? "their chunks read" : "chunks read", work.reads.chunks_met,
             work.chunk_count) +
         fmt::format("{:<22}{:>16}\n", "chunks decoded", work.reads.chunks_decoded) +
         row("points decoded", work.reads.points_decoded, tiles.point_count());
}

template <class Target>
std::optional<Bounds> query_region(const QueryCommand& command, AnswerForm form) {
  if (command.files.size() < 2 || std::is_same_v<Target, HalfSpaces> || command.partial ||
      command.max_level || form == AnswerForm::las || !can_be_surveyed<Target>(command))
    return std::nullopt;
  const Bounds within = stated_box(command.files);
  TargetReader<Target> reader(open_targets(command), {command.t_min, command.t_max});
  TargetBatch<Target> batch;
  Bounds region;
  for (std::uint64_t count = 0; reader.next(k_batch, batch); count += batch.targets.size()) {
    if (count > k_most_surveyed) return std::nullopt;
    for (const Target& target : batch.targets)
      region.grow(target_bounds(target, command.radius.value_or(0.0), within));
    if (region.contains(within.min) && region.contains(within.max)) return std::nullopt;
  }
  return region;
}

template std::optional<Bounds> query_region<Ray>(const QueryCommand&, AnswerForm);
template std::optional<Bounds> query_region<Cone>(const QueryCommand&, AnswerForm);
template std::optional<Bounds> query_region<Path>(const QueryCommand&, AnswerForm);
template std::optional<Bounds> query_region<HalfSpaces>(const QueryCommand&, AnswerForm);
template std::optional<Bounds> query_region<Bounds>(const QueryCommand&, AnswerForm);
template std::optional<Bounds> query_region<glm::dvec3>(const QueryCommand&, AnswerForm);

template <class Target>
QueryPart read_query_part(const QueryCommand& command, AttributeSet attributes, const Progress& progress) {
  if (command.files.size() != 1 || command.partial || command.max_level ||
      !has_parts(command.files.inputs.front()) || !can_be_surveyed<Target>(command))
    return std::nullopt;
  const Bounds within = stated_size(command.files).box;
  TargetReader<Target> reader(open_targets(command), {command.t_min, command.t_max});
  TargetBatch<Target> batch;
  std::vector<database::PointFilter> filters;
  Bounds region;
  std::uint64_t count = 0;
  while (reader.next(k_most_filters, batch)) {
    count += batch.targets.size();
    if (count > k_most_surveyed) return std::nullopt;
    for (const Target& target : batch.targets) {
      const double radius = command.radius.value_or(0.0);
      if (count <= k_most_filters) filters.push_back(filter_of(target, radius, within));
      region.grow(target_bounds(target, radius, within));
    }
  }
  if (count > k_most_filters) {
    filters.resize(1);
    filters.front() = database::PointFilter{.box = region};
  }
  return read_database_part(command.files.inputs.front(), filters, attributes, progress);
}

template QueryPart read_query_part<Ray>(const QueryCommand&, AttributeSet, const Progress&);
template QueryPart read_query_part<Cone>(const QueryCommand&, AttributeSet, const Progress&);
template QueryPart read_query_part<Path>(const QueryCommand&, AttributeSet, const Progress&);
template QueryPart read_query_part<HalfSpaces>(const QueryCommand&, AttributeSet, const Progress&);
template QueryPart read_query_part<Bounds>(const QueryCommand&, AttributeSet, const Progress&);
template QueryPart read_query_part<glm::dvec3>(const QueryCommand&, AttributeSet, const Progress&);

}  // namespace alidade::tools
