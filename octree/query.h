// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <ranges>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/progress.h"
#include "base/ray.h"
#include "octree/targets.h"

// Points that answer a query. A miss is an empty std::optional or list, never a special id.

namespace alidade {

/// A point that answers a ray or cone query.
struct Hit {
  std::uint64_t point_id = 0;  ///< row of the cloud
  glm::dvec3 position{0.0};    ///< of the point, world coordinates
  double t = 0.0;              ///< of the point's projection on the ray, metres
  double distance = 0.0;       ///< of the point to the ray's line, metres
  /// Where the ray enters the sphere around the point whose radius is the query's (for a cone: the limit at
  /// t), metres; -infinity if the radius is infinite.
  double entry = 0.0;

  bool operator==(const Hit&) const = default;
};

/// A point that answers a point, box or half-space query.
struct PointHit {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  /// To the point of the query; of half-spaces: signed distance to the first plane; of boxes: 0. Metres.
  double distance = 0.0;

  bool operator==(const PointHit&) const = default;
};

/// A point that answers a path query.
struct PathHit {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  /// The nearest one, from vertex `segment` to the next; of equally near ones the first.
  std::size_t segment = 0;
  double t = 0.0;         ///< of the nearest point of the path, metres from its first vertex
  double distance = 0.0;  ///< to the nearest point of the path, metres

  bool operator==(const PathHit&) const = default;
};

// Queries on raw points. Targets (ray, cone, path, half-spaces, box, point) and conditions are chosen per
// query; nothing of them is built into the index. All conditions hold together (conjunction).
//
//   const Octree octree = build(cloud);
//   const Ray ray = make_ray({690000, 5325000, 600}, {0, 1, -0.1}, 0.0);
//   if (std::optional<Hit> hit = closest(octree, ray, {.radius = 0.05})) use(hit->point_id, hit->entry);
//   for (const Hit& hit : find(octree, ray, {.measure = Measure::distance, .k = 8})) use(hit);
//   auto veg = [&](const Candidate& point) { return classes[point.point_id] == 5; };
//   std::size_t leaves = count(octree, ray, {.radius = 0.1, .measure = Measure::t, .filter = veg});
//
// For every query:
// - The answer equals that of the function of the same name in octree/brute_force.h bit for bit, whatever
//   the organisation of the octree, the instruction set and the number of threads.
// - Order: by the measure, then by point id; so ties have one answer, too. All limits are inclusive.
// - Empty octree, empty interval (t_min > t_max): no hit, count 0.
// - Targets come from make_ray, make_cone, make_path, make_plane, which reject zero, NaN and infinite input.
//   A target that breaks their promises (direction not of length 1 within 1e-6, numbers not finite) is an
//   Error. Boxes may be infinite; an inverted box holds nothing.
// - Batches run in parallel (oneTBB, as many threads as the caller's arena allows) and answer in the order of
//   the targets. Errors name the number of the target ("ray 17").
// - Common Errors: k = 0; radius negative or NaN; Measure::entry with an infinite radius (of rays) or at all
//   (of paths); max_level negative, or given for an octree that is not layered; room for answers that is not
//   as long as the targets. A batch with Errors leaves its answers incomplete.
//
// Of points with radii of their own, or discs, surface/surface_cloud.h answers what rays meet.

class Octree;

/// What orders the points along a ray, cone or path.
enum class Measure {
  distance,  ///< to the line of the ray or to the path
  t,         ///< of the projection (the paper's "closest")
  entry,     ///< where the ray enters the sphere around the point, see Hit::entry; not for paths
};

struct PointDisc;

/// A point that meets all other conditions of a query, as its filter sees it.
struct Candidate {
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  double t = 0.0;  ///< 0 for points, boxes and half-spaces
  double distance = 0.0;
  double radius = 0.0;              ///< of ray queries: the point's; 0 for others
  const PointDisc* disc = nullptr;  ///< what the ray meets of a SurfaceCloud; null of spheres and of others
  std::size_t query_index = 0;      ///< number of the target in a batch
};

/// Whether a candidate counts: for classes, times, oriented discs. Its functions must return the same for the
/// same candidate whenever called, in any order and from several threads at once. They may be called for
/// points that then are no part of the answer, and not for every point that meets the other conditions.
///
/// `closest` of rays promises more, so that a filter can collect what a ray passes: it calls the filter for
/// every such point before its answer, or for all of them if there is no answer, perhaps twice for a point,
/// and for one query_index from one thread at a time. There a filter may first reject a point and admit it
/// when called again, but must not reject a point that it has admitted.
struct CandidateFilter {
  using Function = std::function<bool(const Candidate&)>;

  /// Called first, for what depends on where a point is: the same for all points of one position, whose
  /// spacings and surfaces are equal, too. Of a million such points `closest` and `occluded` then test a few,
  /// perhaps only the one with the lowest id, as they do without a filter; of_point is called for each.
  Function of_position{};
  Function of_point{};

  CandidateFilter() = default;
  /// For single points.
  template <class F>
  requires(!std::same_as<std::remove_cvref_t<F>, CandidateFilter> && std::constructible_from<Function, F>)
      CandidateFilter(F&& function)
      : of_point(std::forward<F>(function)) {}

  explicit operator bool() const { return of_position || of_point; }
  bool admits(const Candidate& candidate) const {
    return (!of_position || of_position(candidate)) && (!of_point || of_point(candidate));
  }
};

constexpr double k_unlimited_radius = std::numeric_limits<double>::infinity();
constexpr std::size_t k_all = std::numeric_limits<std::size_t>::max();
constexpr int k_all_levels = std::numeric_limits<int>::max();

/// Conditions of a ray query.
struct RayQuery {
  /// Points with distance <= radius count. Metres.
  double radius = k_unlimited_radius;
  Measure measure = Measure::entry;
  /// At most so many points: the first ones by the measure. `closest` is k = 1 whatever this is.
  std::size_t k = k_all;
  /// Only spheres that the ray enters at or after this t (entry >= entry_min). The default admits
  /// spheres the ray starts in, whose entry lies before t_min. A renderer sets a small positive value: rays
  /// that leave a surface then never hit it again.
  double entry_min = -std::numeric_limits<double>::infinity();
  /// Only points of the levels 0 to max_level of a layered octree (coarse to fine): a thinned cloud. Level of
  /// a point: TreeView::level_count.
  int max_level = k_all_levels;
  CandidateFilter filter{};
};

/// Conditions of a cone query; the limit on the distance is the cone's own.
struct ConeQuery {
  Measure measure = Measure::distance;
  std::size_t k = k_all;
  int max_level = k_all_levels;
  CandidateFilter filter{};
};

/// Conditions of a path query. Points count by their distance to the nearest point of the path, each once.
struct PathQuery {
  double radius = k_unlimited_radius;
  Measure measure = Measure::t;
  std::size_t k = k_all;
  int max_level = k_all_levels;
  CandidateFilter filter{};
};

/// Conditions of point, box and half-space queries. Order: by PointHit::distance, then by point id (of boxes:
/// by point id).
struct PointQuery {
  double radius = k_unlimited_radius;  ///< of boxes and half-spaces: must stay unlimited
  std::size_t k = k_all;
  int max_level = k_all_levels;
  CandidateFilter filter{};
};

/// What a query orders by; distance if it has one order only.
template <class Query>
Measure measure_of(const Query& query) {
  if constexpr (requires { query.measure; }) return query.measure;
  return Measure::distance;
}

/// Answers to a batch: those of target i are answers[i]. Contiguous in memory.
template <class Answer>
struct Answers {
  std::vector<Answer> all;
  std::vector<std::size_t> begin{0};  ///< first of every target's answers; one more than there are targets

  std::size_t size() const { return begin.size() - 1; }
  std::span<const Answer> operator[](std::size_t i) const {
    return std::span(all).subspan(begin[i], begin[i + 1] - begin[i]);
  }
};

/// The family of a target: the query it takes, what answers, its name in errors, and whether the target
/// limits its points itself, so that it may go without conditions. No member: not a target.
template <class Target>
struct QueryFamily {};

template <std::size_t size>
struct FamilyName {
  char text[size];
  constexpr FamilyName(const char (&name)[size]) { std::copy_n(name, size, text); }
};

template <FamilyName family_name, class Query_, class Answer_, bool limits = false>
struct FamilyOf {
  using Query = Query_;
  using Answer = Answer_;
  static constexpr const char* name = family_name.text;
  static constexpr bool limits_itself = limits;
};

// clang-format off
template <> struct QueryFamily<Ray> : FamilyOf<"ray", RayQuery, Hit> {};
template <> struct QueryFamily<Cone> : FamilyOf<"cone", ConeQuery, Hit, true> {};
template <> struct QueryFamily<Path> : FamilyOf<"path", PathQuery, PathHit> {};
template <> struct QueryFamily<HalfSpaces> : FamilyOf<"region", PointQuery, PointHit, true> {};
template <> struct QueryFamily<Bounds> : FamilyOf<"box", PointQuery, PointHit, true> {};
template <> struct QueryFamily<glm::dvec3> : FamilyOf<"point", PointQuery, PointHit> {};
// clang-format on

/// Ray, Cone, Path, HalfSpaces, Bounds and glm::dvec3 (a point).
template <class T>
concept TargetGeometry = requires {
  typename QueryFamily<T>::Query;
};
template <TargetGeometry T>
using QueryOf = typename QueryFamily<T>::Query;
template <TargetGeometry T>
using AnswerOf = typename QueryFamily<T>::Answer;

/// Rays and cones: of their points one comes first.
template <class T>
concept LineGeometry = TargetGeometry<T> && std::same_as<AnswerOf<T>, Hit>;

/// Many targets: a vector, array or span of them.
template <class T>
concept TargetRange = std::ranges::contiguous_range<const T> && std::ranges::sized_range<const T> &&
    TargetGeometry<std::ranges::range_value_t<const T>>;
template <TargetRange T>
using TargetIn = std::ranges::range_value_t<const T>;

/// Of targets that limit themselves; all others must come with a query.
template <TargetGeometry T>
QueryOf<T> no_conditions() {
  static_assert(QueryFamily<T>::limits_itself, "this target requires a query");
  return {};
}

/// The first point by the measure among those with distance <= radius, t_min <= t <= t_max (the ray's closed
/// interval, on the projection t whatever the measure), entry >= entry_min, that the filter admits. Cost: a
/// few hundred nanoseconds to microseconds; grows with the number of points in the ray's cylinder before the
/// hit.
template <LineGeometry T>
std::optional<Hit> closest(const Octree& octree, const T& target,
                           const QueryOf<T>& query = no_conditions<T>());
void closest(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
             std::span<std::optional<Hit>> hits);

/// Whether any point fulfils the conditions; stops at the first it finds. k, and the measure but for its
/// Errors, do not matter.
template <LineGeometry T>
bool occluded(const Octree& octree, const T& target, const QueryOf<T>& query = no_conditions<T>());
void occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<std::uint8_t> answers);

/// `find` and `count` of one family, as they are compiled once.
template <TargetGeometry T>
struct FamilyAnswers {
  static std::vector<AnswerOf<T>> find(const Octree& octree, const T& target, const QueryOf<T>& query);
  static Answers<AnswerOf<T>> find(const Octree& octree, std::span<const T> targets, const QueryOf<T>& query);
  static std::size_t count(const Octree& octree, const T& target, const QueryOf<T>& query);
  static void count(const Octree& octree, std::span<const T> targets, const QueryOf<T>& query,
                    std::span<std::size_t> counts);
};

/// The k first points by the measure, in its order. Cost with k: like `closest` (of many rays with k = 1 the
/// same), and grows with k; without: with the number of points in reach. Of many points with k up to 64 and
/// no filter: a fraction of that where targets are near each other, whatever their order.
template <TargetGeometry T>
std::vector<AnswerOf<T>> find(const Octree& octree, const T& target,
                              const QueryOf<T>& query = no_conditions<T>()) {
  return FamilyAnswers<T>::find(octree, target, query);
}
template <TargetRange Targets, TargetGeometry T = TargetIn<Targets>>
Answers<AnswerOf<T>> find(const Octree& octree, const Targets& targets,
                          const QueryOf<T>& query = no_conditions<T>()) {
  return FamilyAnswers<T>::find(octree, std::span<const T>(targets), query);
}

/// How many points `find` would answer; stops at k.
template <TargetGeometry T>
std::size_t count(const Octree& octree, const T& target, const QueryOf<T>& query = no_conditions<T>()) {
  return FamilyAnswers<T>::count(octree, target, query);
}
template <TargetRange Targets, TargetGeometry T = TargetIn<Targets>>
void count(const Octree& octree, const Targets& targets, const QueryOf<T>& query,
           std::span<std::size_t> counts) {
  FamilyAnswers<T>::count(octree, std::span<const T>(targets), query, counts);
}

// Batches as columns of numbers, such as arrays of Python, and their answers as columns. Each task makes its
// rays and writes its answers itself, so that neither takes memory a second time.

/// A ray for each row. Each row of a column begins `stride` numbers behind the row before; with a stride of
/// 0, all rows are the same. Directions may have any length. The numbers must not change while a query runs:
/// it may end with an Error, or answer for rays that never were.
struct RayColumns {
  struct Column {
    const double* values = nullptr;
    std::size_t stride = 0;
    const double* operator[](std::size_t row) const { return values + stride * row; }
  };

  std::size_t count = 0;
  Column origins, directions;  ///< three numbers a row
  Column t_min, t_max;         ///< one number a row

  glm::dvec3 origin(std::size_t row) const { return {origins[row][0], origins[row][1], origins[row][2]}; }
  /// As given, of any length.
  glm::dvec3 direction(std::size_t row) const {
    return {directions[row][0], directions[row][1], directions[row][2]};
  }
  /// Errors: those of make_ray, with the number of the row.
  Ray ray(std::size_t row) const;
};

/// Members of Hit, a row for each ray.
struct HitColumns {
  std::int64_t* point_ids = nullptr;  ///< -1 without a hit
  double* t = nullptr;                ///< this and those below: NaN without a hit
  double* distance = nullptr;
  double* entry = nullptr;

  void set(std::size_t row, const Hit& hit) const {
    point_ids[row] = static_cast<std::int64_t>(hit.point_id);
    t[row] = hit.t;
    distance[row] = hit.distance;
    entry[row] = hit.entry;
  }
  void set_none(std::size_t row) const {
    point_ids[row] = -1;
    t[row] = distance[row] = entry[row] = std::numeric_limits<double>::quiet_NaN();
  }
};

/// `closest` of the rays that make_ray makes of the rows, bit for bit. `progress` is in rays. Errors beside
/// those of batches: those of make_ray, of the first row that has any.
void closest(const Octree& octree, const RayColumns& rays, const RayQuery& query, const HitColumns& hits,
             const Progress& progress = {});
void occluded(const Octree& octree, const RayColumns& rays, const RayQuery& query,
              std::span<std::uint8_t> answers, const Progress& progress = {});

/// Members of PointHit: row k * i + j of the j-th point of target i, from 0.
struct PointHitColumns {
  std::int64_t* point_ids = nullptr;  ///< -1 where there are fewer than k points
  double* distance = nullptr;         ///< infinity there

  void set(std::size_t k, std::size_t target, std::span<const PointHit> hits) const {
    for (std::size_t j = 0, row = k * target; j < k; ++j, ++row) {
      const bool is_hit = j < hits.size();
      point_ids[row] = is_hit ? static_cast<std::int64_t>(hits[j].point_id) : -1;
      distance[row] = is_hit ? hits[j].distance : std::numeric_limits<double>::infinity();
    }
  }
};

/// `find` without positions, in k rows for each target. `progress` is in targets. Errors beside those of
/// batches: no k. Cost: that of `find`, or up to a fifth less for millions of targets.
void find(const Octree& octree, std::span<const glm::dvec3> targets, const PointQuery& query,
          const PointHitColumns& hits, const Progress& progress = {});

}  // namespace alidade
