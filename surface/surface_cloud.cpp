// SPDX-License-Identifier: MIT
#include "surface/surface_cloud.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <new>
#include <utility>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "octree/answer_target.h"
#include "octree/check_query.h"
#include "octree/query_targets.h"
#include "octree/ray_batch.h"
#include "octree/spacing.h"
#include "octree/tree_query.h"
#include "surface/decide_point.h"
#include "surface/disc_reach.h"
#include "surface/leaf_fitter.h"
#include "surface/simd/surface_traversal.h"
#include "surface/surface_fitter.h"

namespace alidade {
namespace {

/// In the order of the storage indices, with zeros behind.
SurfaceArrays stored_arrays(const Octree& octree) {
  const std::size_t count = octree.size();
  SurfaceArrays stored(count + k_coordinate_padding, octree.scratch());
  std::fill_n(stored.surfaces.data() + count, k_coordinate_padding, 0u);
  std::fill_n(stored.edges.data() + count, k_coordinate_padding, std::uint8_t{0});
  return stored;
}

class OnDemandFitter : public LeafFitter {
 public:
  /// Requires spacings.
  explicit OnDemandFitter(const Octree& octree) : OnDemandFitter(octree, stored_arrays(octree)) {}

  /// Points to the arrays that are filled in.
  void add_to(SurfaceView& view) const {
    view.layers.surface_unit = unit_;
    view.stored_surfaces = stored_.surfaces.data();
    view.stored_edges = stored_.edges.data();
    view.fitter = this;
  }

 private:
  OnDemandFitter(const Octree& octree, SurfaceArrays stored)
      : LeafFitter(octree.view(), stored.edges.data()),
        octree_(octree),
        unit_(automatic_radius(octree)),
        stored_(std::move(stored)),
        fitters_([this] { return surface_fitter(octree_, unit_); }) {
    constexpr std::uint32_t k_grain = 1 << 16;
    in_blocks(octree.size(), k_grain, [&](std::size_t first, std::size_t end) {
      std::fill(stored_.edges.data() + first, stored_.edges.data() + end, k_untouched);
    });
  }

  void fit(const Leaf& leaf) const override {
    const std::lock_guard lock(mutexes_[leaf.first % mutexes_.size()]);
    const std::atomic_ref state(stored_.edges[leaf.first]);
    if (state.load(std::memory_order_relaxed) != k_untouched) return;
    const LeafSurfaces& fitted = fitters_.local()(leaf);
    std::copy_n(fitted.surfaces, leaf.count, stored_.surfaces.data() + leaf.first);
    std::copy_n(fitted.edges + 1, leaf.count - 1, stored_.edges.data() + leaf.first + 1);
    state.store(fitted.edges[0], std::memory_order_release);
  }

  const Octree octree_;
  const double unit_;
  mutable SurfaceArrays stored_;
  mutable tbb::enumerable_thread_specific<FitLeaf> fitters_;
  mutable std::array<std::mutex, 1021> mutexes_;  ///< each for some of the leaves
};

/// What a view of discs points to.
struct DiscArrays {
  Octree octree;
  std::optional<SurfaceArrays> stored;
  std::unique_ptr<const OnDemandFitter> fitter;  ///< instead of them
  HugeArray<std::uint16_t> coordinates, spacings, reaches;
};

/// Copies what queries of discs read most of a mapped file out of the map if there is room: there pages are
/// small, and most leaves that a ray meets are on another one. A picture of 1e7 points takes 0.955 of the
/// time.
void take_out_of_map(SurfaceView& view, DiscArrays& made) {
  const Octree& octree = made.octree;
  const std::size_t spacings = octree.size() + k_coordinate_padding,
                    coordinates = 3 * octree.size() + k_coordinate_padding;
  const std::uint64_t bytes = (spacings + coordinates) * sizeof(std::uint16_t);
  constexpr std::uint64_t k_room = 6;  // for the file, surfaces and colours as well
  if (!octree.is_mapped() || octree.scratch() || k_room * bytes > available_memory().value_or(0)) return;
  try {
    HugeArray<std::uint16_t> room(coordinates);
    made.spacings = HugeArray<std::uint16_t>(spacings);
    made.coordinates = std::move(room);
  } catch (const std::bad_alloc&) {
    return;
  }
  const auto copy = [](const std::uint16_t*& values, HugeArray<std::uint16_t>& to) {
    constexpr std::size_t k_grain = std::size_t{1} << 20;
    in_blocks(to.size(), k_grain, [&](std::size_t first, std::size_t end) {
      std::copy(values + first, values + end, to.data() + first);
    });
    values = to.data();
  };
  copy(view.tree.coordinates, made.coordinates);
  copy(view.layers.spacings, made.spacings);
}

/// What Algorithm 1 (octree/tree_query.h) takes, with storage indices in place of ids.
class SurfaceTree : public OctreeTree {
 public:
  explicit SurfaceTree(const SurfaceView& view) : OctreeTree(view.tree), view_(view) {}

  template <class Visit>
  void for_each_point(const Node& node, const Visit& visit) const {
    if (node.inner) return;
    touch(view_, node.leaf);
    for (std::uint32_t i = 0; i < node.leaf.count; ++i) {
      if (!visit(std::uint64_t{node.leaf.first} + i,
                 to_world(view_.tree.lattice, position_of(view_.tree, node.leaf, i))))
        return;
    }
  }

 private:
  const SurfaceView& view_;
};

/// The target to it. No point's radius is above the query's.
class SurfaceTarget {
 public:
  using Answer = SurfaceHit;

  SurfaceTarget(const SurfaceView& view, const Ray& ray, const SurfaceQuery& query, std::size_t query_index)
      : view_(view), ray_(ray), query_(query), query_index_(query_index) {}

  std::optional<SurfaceHit> evaluate(const glm::dvec3& position, std::uint64_t point) const {
    const auto index = static_cast<std::uint32_t>(point);
    const auto hit = alidade::evaluate(ray_, query_, view_, index, position, query_index_);
    return hit ? std::optional(SurfaceHit{*hit, index}) : std::nullopt;
  }
  double measured(const Hit& hit) const { return alidade::measured(order_of(query_), hit); }
  bool precedes(const Hit& a, const Hit& b) const { return alidade::precedes(order_of(query_), a, b); }

  Reach reach(const Bounds& box, DistanceBound) const {
    const RayReach projected = project(ray_, box);
    return {projected.distance.low, projected.t};
  }
  bool too_far(const Reach& reach) const { return reach.distance > query_.radius; }
  bool outside_interval(const Reach& reach) const {
    if (!query_.discs)
      return reach.t.high < std::max(query_.entry_min, ray_.t_min) || reach.t.low > ray_.t_max;
    // A disc is crossed at most its radius from the projection of its point.
    const double beside =
        query_.radius + 0x1p-40 * (query_.radius + std::fabs(reach.t.low) + std::fabs(reach.t.high));
    return reach.t.low - beside > ray_.t_max ||
           reach.t.high + beside < std::max(ray_.t_min, query_.entry_min);
  }
  double least_measure(const Reach& reach) const {
    // Crossings order as entries do, and are not before them.
    if (!query_.discs && query_.measure == Measure::t) return reach.t.low;
    return entry({reach.t.low, reach.distance}, query_.radius);
  }

 private:
  const SurfaceView& view_;
  const Ray& ray_;
  const SurfaceQuery& query_;
  const std::size_t query_index_;
};

bool has_traversal(const SurfaceView& view, const SurfaceQuery& query) {
  return query.radius < k_longest && query.spacing_factor < k_longest && suits_traversal(view.tree);
}

/// By Algorithm 1, for rays that lanes do not answer.
std::optional<SurfaceHit> first_by_walk(const SurfaceView& view, const Ray& ray, const SurfaceQuery& query,
                                        std::size_t query_index) {
  const SurfaceTarget target(view, ray, query, query_index);
  Nearest first(target, 1);
  tree_query(SurfaceTree(view), target, first);
  const std::vector<SurfaceHit> hits = first.in_order();
  return hits.empty() ? std::nullopt : std::optional(hits.front());
}

bool any_by_walk(const SurfaceView& view, const Ray& ray, const SurfaceQuery& query,
                 std::size_t query_index) {
  const SurfaceTarget target(view, ray, query, query_index);
  Counter any(1);
  tree_query(SurfaceTree(view), target, any);
  return any.count() > 0;
}

void check_all(const SurfaceCloud& cloud, std::size_t rays, const SurfaceQuery& query) {
  check(query, rays);
  if (cloud.size() > 0 && query.discs && !cloud.has_discs())
    throw input_error("discs require a cloud that has them", "SurfaceCloud::of_discs()");
}

template <class Answer, class Stream, class AnswerOne>
void answer_batch(const SurfaceCloud& cloud, std::span<const Ray> rays, const SurfaceQuery& query,
                  std::span<Answer> answers, Stream* stream, const AnswerOne& answer_one) {
  check_all(cloud, rays.size(), query);
  const SurfaceView& view = cloud.view();
  const bool by_index = query.filter || (query.discs && !query.discs->begins.empty());
  const auto some = [&](std::span<const Ray> part, std::size_t first_index, std::span<Answer> room) {
    stream(view, part, query, first_index, room);
  };
  trace_batch(view.tree, RaysInMemory<Answer>(rays, answers), has_traversal(view, query), by_index, some,
              [&](const Ray& ray, std::size_t index) { return answer_one(view, ray, query, index); });
}

template <class Answer>
Answer answer_one(const SurfaceCloud& cloud, const Ray& ray, const SurfaceQuery& query,
                  Answer in_lanes(const SurfaceView&, const Ray&, const SurfaceQuery&, std::size_t),
                  Answer otherwise(const SurfaceView&, const Ray&, const SurfaceQuery&, std::size_t)) {
  check_all(cloud, 1, query);
  check(ray);
  if (cloud.size() == 0) return Answer();
  const bool suits = has_traversal(cloud.view(), query) && suits_traversal(ray);
  return (suits ? in_lanes : otherwise)(cloud.view(), ray, query, 0);
}

void check_spacings(const Octree& octree) {
  if (octree.size() > 0 && octree.layers().spacings == nullptr)
    throw input_error("radii of the points' own require an octree with spacings", "with_spacings()");
}

}  // namespace

SurfaceCloud SurfaceCloud::of_spheres(const Octree& octree) {
  check_spacings(octree);
  return {octree, {.tree = octree.view(), .layers = octree.layers()}};
}

SurfaceCloud SurfaceCloud::of_discs(const Octree& octree) {
  check_spacings(octree);
  SurfaceView view{.tree = octree.view(), .layers = octree.layers()};
  if (octree.size() == 0) return {octree, view};
  const auto made = std::make_shared<DiscArrays>();
  made->octree = octree;
  if (octree.layers().surfaces == nullptr) {
    made->fitter = std::make_unique<const OnDemandFitter>(octree);
    made->fitter->add_to(view);
  } else {
    take_out_of_map(view, *made);
    SurfaceArrays& stored = made->stored.emplace(stored_arrays(octree));
    constexpr std::uint32_t k_grain = 1 << 16;
    in_parallel(view.tree.point_count, k_grain, [&](std::uint32_t index) {
      const std::uint64_t id = point_id(view.tree, index);
      stored.surfaces[index] = view.layers.surfaces[id];
      stored.edges[index] = view.layers.sheet_edges[id];
    });
    view.stored_surfaces = stored.surfaces.data();
    view.stored_edges = stored.edges.data();
    made->reaches = slot_reaches(octree, view);
    view.slot_reaches = made->reaches.data();
  }
  PointLayers layers = octree.layers();
  layers.spacings = view.layers.spacings;
  const bool is_mapped = octree.is_mapped() && made->coordinates.size() == 0;
  return {Octree(view.tree, made, octree.instruction_set())
              .with_layers(layers)
              .with_mapped(is_mapped)
              .with_scratch(octree.scratch()),
          view};
}

void SurfaceCloud::fit_all(const Progress& progress) const {
  if (view_.fitter != nullptr) view_.fitter->touch_all(progress);
}

void check(const SurfaceQuery& query, std::size_t rays) {
  if (query.discs && std::isinf(query.radius))
    throw input_error("discs require a radius", "a finite radius", "none");
  check_radius_along_ray(query.radius, query.measure, query.entry_min);
  if (query.measure == Measure::distance)
    throw input_error("surfaces are not met by measure distance", "measure t or entry");
  const auto require = [](bool holds, const char* what, const char* expected, double found) {
    if (!holds) throw input_error(fmt::format("{} out of range", what), expected, fmt::format("{}", found));
  };
  require(query.spacing_factor > 0.0 && std::isfinite(query.spacing_factor), "spacing_factor",
          "a finite number above 0", query.spacing_factor);
  if (!query.discs) return;
  const DiscQuery& discs = *query.discs;
  require(discs.lone_factor >= 0.0 && std::isfinite(discs.lone_factor), "lone_factor",
          "a finite number, at least 0", discs.lone_factor);
  require(std::isfinite(discs.edge_shift), "edge_shift", "a finite number", discs.edge_shift);
  require(discs.lone_radius >= 0.0, "lone_radius", "at least 0", discs.lone_radius);
  if (!discs.begins.empty() && discs.begins.size() != rays) {
    throw input_error("the sheets that rays begin on do not match the rays", fmt::format("{}, or none", rays),
                      fmt::format("{}", discs.begins.size()));
  }
}

void closest(const SurfaceCloud& cloud, std::span<const Ray> rays, const SurfaceQuery& query,
             std::span<std::optional<SurfaceHit>> hits) {
  answer_batch(cloud, rays, query, hits,
               simd::surface_traversal(cloud.octree().instruction_set()).closest_stream, first_by_walk);
}

void occluded(const SurfaceCloud& cloud, std::span<const Ray> rays, const SurfaceQuery& query,
              std::span<std::uint8_t> answers) {
  answer_batch(cloud, rays, query, answers,
               simd::surface_traversal(cloud.octree().instruction_set()).occluded_stream, any_by_walk);
}

std::optional<SurfaceHit> closest(const SurfaceCloud& cloud, const Ray& ray, const SurfaceQuery& query) {
  return answer_one(cloud, ray, query, simd::surface_traversal(cloud.octree().instruction_set()).closest,
                    first_by_walk);
}

bool occluded(const SurfaceCloud& cloud, const Ray& ray, const SurfaceQuery& query) {
  return answer_one(cloud, ray, query, simd::surface_traversal(cloud.octree().instruction_set()).occluded,
                    any_by_walk);
}

}  // namespace alidade
