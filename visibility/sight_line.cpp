// SPDX-License-Identifier: MIT
#include "visibility/sight_line.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "base/ray.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "visibility/crossing.h"

namespace alidade::visibility {

Occluders::Occluders(const Octree& octree, const OccluderOptions& options, const Progress& progress)
    : octree_(octree), options_(options) {
  for (const double radius : {options.radius.value_or(1.0), options.radius_max.value_or(1.0)}) {
    check_that(std::isfinite(radius) && radius > 0.0, "invalid occluder radius", "a positive length",
               std::to_string(radius));
  }
  check_that(!options.radius || !options.radius_max, "occluders have one radius or a largest one",
             "one of them", "both");
  check_that(options.transparency >= 1, "invalid transparency", "at least 1",
             std::to_string(options.transparency));
  if (has_surfaces() || !options.radius) {
    // Spacings of other neighbours make other discs.
    octree_ = with_spacings(octree_, k_surface_neighbours, progress);
  }
  if (has_surfaces()) octree_ = with_surfaces(octree_, progress);
  if (!options.radius) {
    surfaces_ = has_surfaces() ? SurfaceCloud::of_discs(octree_) : SurfaceCloud::of_spheres(octree_);
    octree_ = surfaces_.octree();
  }
  if (options.radius) {
    typical_radius_ = largest_radius_ = *options.radius;
  } else {
    typical_radius_ = automatic_radius(octree_);
    largest_radius_ = (has_surfaces() ? k_widest_disc : 1.0) * typical_radius_;
  }
}

namespace {

constexpr double k_lift = 1.0;  // thicknesses

/// How far the surface of an end reaches around it, metres.
double own_reach(const Occluders& occluders) {
  constexpr double k_radii = 3.0, k_typical = 4.0;
  return occluders.options().radius ? k_radii * *occluders.options().radius
                                    : k_typical * occluders.typical_radius();
}

/// Thickness of the surface of an end around its sheet. At least a diagonal of the lattice: the point and
/// those around it are rounded by up to half of one each, all in the same direction where few steps lie
/// across the surface, so that the fitted thickness does not show it. And doubles have rounded coordinates,
/// of UTM for example, several times before.
double own_thickness(const Occluders& occluders, const PointSurface& surface, const glm::dvec3& position) {
  constexpr double k_thicknesses = 3.0, k_roundings = 8.0 * std::numeric_limits<double>::epsilon();
  const double diagonal = glm::length(occluders.octree().lattice().scale);
  return std::max(k_thicknesses * surface.thickness + 0.5 * diagonal, diagonal) +
         k_roundings * glm::length(position);
}

void check_end(const SightEnd& end) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(end.position[axis]))
      throw Error({.problem = "an end of a line of sight is not finite"});
  }
}

constexpr std::size_t k_grain = 1024;

/// The part of a line that the surfaces beside the points may block.
Ray ray_between_ends(const SightLine& line) {
  return {line.from.position, line.direction, 0.0, line.length};
}

/// Whether a line remains within this distance of a surface, from where it meets it to an end that lies on
/// the plane there. Triangles are that plane.
bool keeps_to(const TriangleTree&, const Ray&, double) {
  return true;
}
bool keeps_to(const geo::TerrainSurface& terrain, const Ray& between, double distance) {
  // Lines this far above and below must not cross the surface.
  for (const double side : {-distance, distance}) {
    Ray beside = between;
    beside.origin.z += side;
    if (terrain.occluded(beside)) return false;
  }
  return true;
}

/// A filter of crossings with a surface: those block that neither end lies on. Both must
/// outlive what is returned.
template <class Surface>
auto crossings_that_block(const Surface& surface, const SightLine& line) {
  return [&surface, &line](const auto& hit) {
    const auto lies_on = [&](const SightEnd& end, double t) {
      const glm::dvec3 met = line.from.position + hit.t * line.direction;
      return std::fabs(glm::dot(end.position - met, hit.normal)) < end.mesh_contact &&
             keeps_to(surface, {line.from.position, line.direction, std::min(t, hit.t), std::max(t, hit.t)},
                      end.mesh_contact);
    };
    return !lies_on(line.from, 0.0) && (!line.has_end() || !lies_on(line.to, line.length));
  };
}

/// Where a line with an end on the surface is in the ground, metres from its start.
std::optional<double> in_ground(const TriangleTree&, const SightLine&) {
  return {};
}
/// An end lies on the upper side of a terrain. A line that goes into the ground there and leaves it at the
/// terrain's edge, or ends on the terrain again, meets it only at its ends. The line raised by
/// k_mesh_contact meets it between.
std::optional<double> in_ground(const geo::TerrainSurface& terrain, const SightLine& line) {
  const auto lies_on = [&](const SightEnd& end) {
    const glm::dvec3 top = end.position + glm::dvec3(0.0, 0.0, end.mesh_contact);
    return end.mesh_contact > 0.0 && terrain.occluded({top, {0.0, 0.0, -1.0}, 0.0, 2.0 * end.mesh_contact});
  };
  // From below, a line from an end in the air reaches one on the surface only through a hole.
  const bool begins_in_air = line.from.mesh_contact == 0.0;
  const bool ends_in_air = !line.has_end() || line.to.mesh_contact == 0.0;
  if (!(lies_on(line.from) && (ends_in_air || lies_on(line.to))) &&
      !(begins_in_air && !ends_in_air && lies_on(line.to)))
    return {};
  Ray above = ray_between_ends(line);
  above.origin.z += k_mesh_contact;
  const auto hit = terrain.closest(above);
  return hit ? std::optional(hit->t) : std::nullopt;
}

/// Calls visit(surface) for the surfaces beside the points: the mesh and the terrain.
template <class Visit>
void for_surfaces(const OccluderOptions& options, const Visit& visit) {
  if (options.mesh != nullptr) visit(*options.mesh);
  if (options.terrain != nullptr) visit(*options.terrain);
}

bool has_surfaces_beside(const OccluderOptions& options) {
  return options.mesh != nullptr || options.terrain != nullptr;
}

/// Replaces the blockers of lines that such a surface blocks before.
template <class Surface>
void put_before(const Surface& surface, const ChordLines& lines, std::span<std::optional<Blocker>> blockers) {
  in_parallel(blockers.size(), k_grain, [&](std::size_t line) {
    for (std::size_t chord = lines.begin[line]; chord < lines.begin[line + 1]; ++chord) {
      const Ray ray = ray_between_ends(lines.chords[chord]);
      const auto hit = surface.closest(ray, crossings_that_block(surface, lines.chords[chord]));
      const std::optional<double> t = hit ? hit->t : in_ground(surface, lines.chords[chord]);
      if (!t) continue;
      const Blocker blocker{k_mesh_blocker, ray.position(*t), lines.starts[chord] + *t};
      if (!blockers[line] || blocker.distance < blockers[line]->distance) blockers[line] = blocker;
      return;
    }
  });
}

std::vector<Ray> rays_of(const Occluders& occluders, std::span<const SightLine> lines) {
  std::vector<Ray> rays(lines.size());
  in_parallel(lines.size(), k_grain, [&](std::size_t i) { rays[i] = ray_of(occluders, lines[i]); });
  return rays;
}

/// Calls use(cloud, query) with the query for the points that block the lines of rays_of().
template <class Use>
void with_query(const Occluders& occluders, std::span<const SightLine> lines, const Use& use) {
  with_query(occluders, [&](const auto& cloud, auto query) {
    query.filter.of_position = [&occluders, lines](const Candidate& candidate) {
      return position_crossing(occluders, lines[candidate.query_index], candidate).has_value();
    };
    query.filter.of_point = counted_alone(occluders);
    use(cloud, query);
  });
}

/// hit: a point that blocks the line.
Blocker blocker_of(const Occluders& occluders, const SightLine& line, const Hit& hit) {
  const PointSurface surface = occluders.surface(hit.point_id);
  double distance = hit.t;
  if (!surface.exists)
    distance = glm::dot(hit.position - line.from.position, line.direction);
  else if (!has_own_discs(occluders))
    distance = *plane_crossing(point_disc(hit.position, surface, 0.0), line.from.position, line.direction);
  return {hit.point_id, hit.position, distance};
}

/// Calls work(some lines, their answers) for one part after another. Errors: Cancelled, by
/// OccluderOptions::is_given_up.
template <class Answer, class Work>
void in_parts(const Occluders& occluders, std::span<const SightLine> lines, std::span<Answer> answers,
              const Work& work) {
  constexpr std::size_t k_at_once = 1 << 14;
  for (std::size_t first = 0; first < lines.size(); first += k_at_once) {
    occluders.check_given_up();
    const std::size_t count = std::min(k_at_once, lines.size() - first);
    work(lines.subspan(first, count), answers.subspan(first, count));
  }
}

/// The first points that block lines at their first crossing.
void first_points(const Occluders& occluders, std::span<const SightLine> all,
                  std::span<std::optional<Blocker>> all_blockers) {
  in_parts(occluders, all, all_blockers, [&](std::span<const SightLine> lines, auto blockers) {
    with_query(occluders, lines, [&](const auto& cloud, const auto& query) {
      const std::vector<Ray> rays = rays_of(occluders, lines);
      std::vector<decltype(closest(cloud, rays.front(), query))> hits(lines.size());
      closest(cloud, rays, query, hits);
      in_parallel(lines.size(), k_grain, [&](std::size_t i) {
        blockers[i].reset();
        if (hits[i]) blockers[i] = blocker_of(occluders, lines[i], *hits[i]);
      });
    });
  });
}

/// As first_points() of straight lines, for lines of chords.
void first_points(const Occluders& occluders, const ChordLines& lines,
                  std::span<std::optional<Blocker>> blockers) {
  std::vector<std::optional<Blocker>> of_chords(lines.chords.size());
  first_points(occluders, lines.chords, of_chords);
  for (std::size_t line = 0; line < blockers.size(); ++line) {
    std::size_t chord = lines.begin[line];
    while (chord < lines.begin[line + 1] && !of_chords[chord]) ++chord;
    blockers[line].reset();
    if (chord == lines.begin[line + 1]) continue;
    blockers[line] = of_chords[chord];
    blockers[line]->distance += lines.starts[chord];
  }
}

void check_room(std::size_t lines, std::size_t answers) {
  if (lines == answers) return;
  throw Error({.problem = "the span of answers does not match the lines of sight",
               .expected = std::to_string(lines),
               .found = std::to_string(answers)});
}

}  // namespace

SightLine sight_line(const SightEnd& from, const SightEnd& to) {
  check_end(from);
  check_end(to);
  const glm::dvec3 way = to.position - from.position;
  SightLine line{from, to, {0.0, 0.0, 1.0}, glm::length(way)};
  if (line.length > 0.0) line.direction = unit_direction(way);
  return line;
}

SightLine sight_ray(const SightEnd& from, const glm::dvec3& direction, double length) {
  if (!(length >= 0.0)) {
    throw Error({.problem = "invalid length of a line of sight",
                 .expected = "at least 0 metres",
                 .found = std::to_string(length)});
  }
  const Ray ray = make_ray(from.position, direction);
  SightLine line{from, chord_end({}), ray.direction, length};
  // No surface of its own is known at its end.
  if (std::isfinite(length)) line.to.position = ray.position(length);
  return line;
}

SightEnd end_on_point(const Occluders& occluders, std::uint64_t point_id, const glm::dvec3& position,
                      const glm::dvec3& seen_from) {
  const PointSurface surface = occluders.surface(point_id);
  if (!surface.exists) return {.position = position, .is_lone = occluders.has_surfaces()};
  const glm::dvec3 way = seen_from - position;
  double rise = glm::dot(way, surface.normal);
  // Where sight grazes the surface, the error of the normal leaves the side open; the
  // upper one is more likely.
  constexpr double k_grazing = 0.02;
  if (std::fabs(rise) < k_grazing * glm::length(way)) rise = surface.normal.z;
  const double lift = std::copysign(k_lift * surface.thickness, rise);
  return {position + (lift - surface.height) * surface.normal, own_reach(occluders),
          own_thickness(occluders, surface, position)};
}

SightEnd end_near_surface(const Occluders& occluders, const glm::dvec3& position) {
  if (!occluders.has_surfaces()) return {position};
  const std::vector<PointHit> nearest =
      find(occluders.octree(), position, PointQuery{.radius = occluders.typical_radius(), .k = 1});
  if (nearest.empty()) return {position};
  const PointSurface surface = occluders.surface(nearest.front().point_id);
  if (!surface.exists) return {position};
  const glm::dvec3 center = nearest.front().position - surface.height * surface.normal;
  const double above = std::fabs(glm::dot(position - center, surface.normal));
  return {position, own_reach(occluders), above + own_thickness(occluders, surface, position)};
}

std::optional<Blocker> first_blocker(const Occluders& occluders, const SightLine& line) {
  std::optional<Blocker> blocker;
  first_blockers(occluders, {&line, 1}, {&blocker, 1});
  return blocker;
}

void first_blockers(const Occluders& occluders, std::span<const SightLine> lines,
                    std::span<std::optional<Blocker>> blockers) {
  check_room(lines.size(), blockers.size());
  const OccluderOptions& options = occluders.options();
  if (options.transparency == 1 && !has_surfaces_beside(options))
    return first_points(occluders, lines, blockers);
  const std::vector<double> starts(lines.size());
  std::vector<std::size_t> begin(lines.size() + 1);
  std::iota(begin.begin(), begin.end(), std::size_t{0});
  first_blockers(occluders, ChordLines{lines, starts, begin}, blockers);
}

void first_blockers(const Occluders& occluders, const ChordLines& lines,
                    std::span<std::optional<Blocker>> blockers) {
  check_room(lines.begin.size() - 1, blockers.size());
  const OccluderOptions& options = occluders.options();
  options.transparency == 1 ? first_points(occluders, lines, blockers)
                            : find_separate_blockers(occluders, lines, blockers);
  for_surfaces(options, [&](const auto& surface) { put_before(surface, lines, blockers); });
}

void blocked(const Occluders& occluders, std::span<const SightLine> lines, std::span<std::uint8_t> answers) {
  check_room(lines.size(), answers.size());
  const OccluderOptions& options = occluders.options();
  if (options.transparency > 1) {
    std::vector<std::optional<Blocker>> blockers(lines.size());
    first_blockers(occluders, lines, blockers);
    std::ranges::transform(blockers, answers.begin(),
                           [](const std::optional<Blocker>& blocker) { return blocker ? 1 : 0; });
    return;
  }
  in_parts(occluders, lines, answers, [&](std::span<const SightLine> some, auto some_answers) {
    with_query(occluders, some, [&](const auto& cloud, const auto& query) {
      occluded(cloud, rays_of(occluders, some), query, some_answers);
    });
  });
  for_surfaces(options, [&](const auto& surface) {
    in_parallel(lines.size(), k_grain, [&](std::size_t i) {
      if (answers[i] != 0) return;
      const bool blocks =
          surface.occluded(ray_between_ends(lines[i]), crossings_that_block(surface, lines[i])) ||
          in_ground(surface, lines[i]).has_value();
      answers[i] = blocks ? 1 : 0;
    });
  });
}

}  // namespace alidade::visibility
