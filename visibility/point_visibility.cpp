// SPDX-License-Identifier: MIT
#include "visibility/point_visibility.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "octree/error.h"
#include "octree/point_surface.h"
#include "octree/tree_walk.h"
#include "renderer/deterministic_math.h"
#include "visibility/sight_line.h"

namespace alidade {
namespace {

/// Points asked for at once: enough for all threads, few enough for their lines to stay near.
constexpr std::size_t k_batch = 1 << 16;

/// Places that cover a disc of radius 1 evenly, the first one in the middle.
std::vector<glm::dvec2> disc_pattern(int count) {
  const double golden_turn = 0.5 * (3.0 - std::sqrt(5.0));
  std::vector<glm::dvec2> pattern;
  for (int i = 0; i < count; ++i) {
    const double radius = std::sqrt(static_cast<double>(i) / count);
    const SineCosine at = sine_cosine_of_turns(i * golden_turn);
    pattern.emplace_back(radius * at.cosine, radius * at.sine);
  }
  return pattern;
}

/// Some vector that stands on a unit vector.
glm::dvec3 across(const glm::dvec3& normal) {
  return std::fabs(normal.z) < 0.5 ? glm::dvec3(normal.y, -normal.x, 0.0)
                                   : glm::dvec3(0.0, normal.z, -normal.y);
}

/// A point that is looked at.
struct Target {
  glm::dvec3 position{0.0};
  std::uint32_t place = 0;
  std::uint64_t point_id = 0;
};

/// Points in the order of the octree, some leaves at a time.
class Batch {
 public:
  explicit Batch(const TreeView& tree) : tree_(tree) {}

  void add(const Leaf& leaf) {
    leaves_.push_back(leaf);
    begins_.push_back(size_);
    size_ += leaf.count;
  }
  std::size_t size() const { return size_; }

  /// The points of the leaves, which are given up.
  const std::vector<Target>& take() {
    targets_.resize(size_);
    tbb::parallel_for(std::size_t{0}, leaves_.size(), [&](std::size_t l) {
      const Leaf& leaf = leaves_[l];
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        targets_[begins_[l] + i] = {to_world(tree_.lattice, position_of(tree_, leaf, i)), leaf.place + i,
                                    point_id(tree_, leaf.place + i)};
      }
    });
    leaves_.clear();
    begins_.clear();
    size_ = 0;
    return targets_;
  }

 private:
  const TreeView& tree_;
  std::vector<Leaf> leaves_;
  std::vector<std::size_t> begins_;  ///< of the points of each leaf among all
  std::size_t size_ = 0;
  std::vector<Target> targets_;
};

/// What one observer sees, asked batch by batch.
class View {
 public:
  View(const Occluders& occluders, const Observer& observer, std::size_t number,
       const std::vector<glm::dvec2>& pattern, PointVisibility& all)
      : occluders_(occluders),
        tree_(occluders.octree().view()),
        observer_(observer),
        number_(number),
        field_(observer),
        eye_(end_near_surface(occluders, observer.position)),
        pattern_(pattern),
        all_(all),
        seen_(tree_.point_count) {}

  void look_at(const std::vector<Target>& targets) {
    asked_.clear();
    for (const Target& target : targets) {
      if (is_in_view(target.position)) asked_.push_back(target);
    }
    lines_.resize(asked_.size());
    blocked_.resize(asked_.size());
    make_lines(0);
    if (all_.blockers.empty())
      blocked(occluders_, lines_, blocked_);
    else
      ask_for_blockers();
    for (std::size_t n = 0; n < asked_.size(); ++n) {
      if (blocked_[n] != 0) continue;
      const std::uint64_t id = asked_[n].point_id;
      seen_[id] = 1;
      ++all_.counts[id];
      if (!all_.masks.empty()) all_.masks[id] |= std::uint64_t{1} << number_;
    }
    if (!all_.fractions.empty()) ask_for_fractions();
  }

  std::span<const std::uint8_t> seen() const { return seen_; }

 private:
  bool is_in_view(const glm::dvec3& position) const {
    const glm::dvec3 offset = position - observer_.position;
    return glm::dot(offset, offset) <= observer_.max_distance * observer_.max_distance &&
           field_.contains(offset);
  }

  /// The lines to the points that are asked for, or beside them on their discs.
  void make_lines(std::size_t sub_ray) {
    tbb::parallel_for(std::size_t{0}, asked_.size(), [&](std::size_t n) {
      const Target& target = asked_[n];
      SightEnd end = end_on_point(occluders_, target.point_id, target.position, observer_.position);
      if (sub_ray > 0) shift(end, target, pattern_[sub_ray]);
      lines_[n] = sight_line(eye_, end);
    });
  }

  /// Moves an end over the disc of its point.
  void shift(SightEnd& end, const Target& target, const glm::dvec2& by) const {
    PointSurface surface;
    if (occluders_.has_surfaces()) surface = surface_of(tree_, target.point_id);
    glm::dvec3 normal = surface.normal;
    if (!surface.exists && target.position != observer_.position)
      normal = glm::normalize(target.position - observer_.position);
    double radius = occluders_.largest_radius();
    if (tree_.spacings != nullptr) radius = std::min(radius, spacing_at(tree_, target.place) / 3.0);
    const glm::dvec3 first = glm::normalize(across(normal)), second = glm::cross(normal, first);
    end.position += radius * (by.x * first + by.y * second);
    end.own_reach += radius;
  }

  void ask_for_blockers() {
    first_.resize(lines_.size());
    first_blockers(occluders_, lines_, first_);
    for (std::size_t n = 0; n < lines_.size(); ++n) {
      blocked_[n] = first_[n].has_value();
      if (first_[n])
        all_.blockers[number_][asked_[n].point_id] = static_cast<std::uint32_t>(first_[n]->point_id);
    }
  }

  void ask_for_fractions() {
    std::vector<std::uint32_t> clear(asked_.size());
    for (std::size_t n = 0; n < asked_.size(); ++n) clear[n] = blocked_[n] == 0;
    for (std::size_t sub_ray = 1; sub_ray < pattern_.size(); ++sub_ray) {
      make_lines(sub_ray);
      blocked(occluders_, lines_, blocked_);
      for (std::size_t n = 0; n < asked_.size(); ++n) clear[n] += blocked_[n] == 0;
    }
    for (std::size_t n = 0; n < asked_.size(); ++n) {
      float& fraction = all_.fractions[asked_[n].point_id];
      fraction = std::max(fraction, static_cast<float>(clear[n]) / static_cast<float>(pattern_.size()));
    }
  }

  const Occluders& occluders_;
  const TreeView& tree_;
  const Observer& observer_;
  const std::size_t number_;
  const FieldOfView field_;
  const SightEnd eye_;
  const std::vector<glm::dvec2>& pattern_;
  PointVisibility& all_;
  std::vector<std::uint8_t> seen_;
  // Of the batch that is looked at.
  std::vector<Target> asked_;
  std::vector<SightLine> lines_;
  std::vector<std::uint8_t> blocked_;
  std::vector<std::optional<Blocker>> first_;
};

PointVisibility make_columns(std::size_t points, std::size_t observers,
                             const PointVisibilityOptions& options) {
  PointVisibility all;
  all.counts.resize(points);
  if (observers > 1 && observers <= k_most_mask_observers) all.masks.resize(points);
  if (options.sub_rays > 1) all.fractions.resize(points);
  if (options.with_blockers) all.blockers.assign(observers, std::vector<std::uint32_t>(points, k_no_blocker));
  return all;
}

}  // namespace

PointVisibility point_visibility(const Occluders& occluders, std::span<const Observer> observers,
                                 const PointVisibilityOptions& options) {
  if (options.sub_rays < 1 || options.sub_rays > k_most_sub_rays) {
    throw Error({.problem = "lines to a point's disc are out of range",
                 .expected = fmt::format("1 to {}", k_most_sub_rays),
                 .found = std::to_string(options.sub_rays)});
  }
  const TreeView& tree = occluders.octree().view();
  const auto lines_per_point = static_cast<std::uint64_t>(options.sub_rays);
  const std::uint64_t total = lines_per_point * tree.point_count * observers.size();
  const std::vector<glm::dvec2> pattern = disc_pattern(options.sub_rays);
  PointVisibility all = make_columns(tree.point_count, observers.size(), options);
  std::uint64_t done = 0;
  Batch batch(tree);
  for (std::size_t number = 0; number < observers.size(); ++number) {
    View view(occluders, observers[number], number, pattern, all);
    const auto look = [&] {
      done += lines_per_point * batch.size();
      view.look_at(batch.take());
      report(options.progress, done, total);
    };
    for_each_leaf(tree, [&](const Leaf& leaf) {
      batch.add(leaf);
      if (batch.size() >= k_batch) look();
    });
    if (batch.size() > 0) look();
    if (options.each_observer) options.each_observer(number, view.seen());
  }
  return all;
}

}  // namespace alidade
