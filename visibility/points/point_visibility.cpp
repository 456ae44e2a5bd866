// SPDX-License-Identifier: MIT
#include "visibility/points/point_visibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "base/checkpoint.h"
#include "base/error.h"
#include "base/exact_math.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "octree/spacing.h"
#include "visibility/point_blocks.h"

namespace alidade::visibility {
namespace {

/// Points in a batch: enough for all threads, few enough for their lines to be near each other. Fewer if
/// there are many lines to each, so that a part of the work is soon finished.
std::size_t batch_size(int sub_rays) {
  constexpr std::size_t k_most = 1 << 17, k_least = 1 << 13;
  return std::max(k_least, k_most / static_cast<std::size_t>(sub_rays));
}

/// Positions that cover a disc of radius 1 evenly, the first one in the middle.
std::vector<glm::dvec2> disc_pattern(int count) {
  std::vector<glm::dvec2> pattern;
  for (int i = 0; i < count; ++i) {
    const double radius = std::sqrt(static_cast<double>(i) / count);
    const SineCosine at = sine_cosine_of_turns(golden_turns(i));
    pattern.emplace_back(radius * at.cosine, radius * at.sine);
  }
  return pattern;
}

/// Some vector at right angles to a unit vector.
glm::dvec3 across(const glm::dvec3& normal) {
  return std::fabs(normal.z) < 0.5 ? glm::dvec3(normal.y, -normal.x, 0.0)
                                   : glm::dvec3(0.0, normal.z, -normal.y);
}

/// What an observer sees of the points of a batch, in their order.
struct BatchAnswers {
  std::vector<std::uint8_t> seen;         ///< 1 or 0
  std::vector<std::uint32_t> blockers;    ///< empty if not requested
  std::vector<std::uint8_t> clear_lines;  ///< of those to the disc; empty if not requested

  BatchAnswers(std::size_t points, const PointVisibility& all)
      : seen(points),
        blockers(all.blockers.empty() ? 0 : points, k_no_blocker),
        clear_lines(all.fractions.empty() ? 0 : points) {}

  void put(PartWriter& writer) const {
    std::vector<std::uint8_t> bits((seen.size() + 7) / 8);
    for (std::size_t i = 0; i < seen.size(); ++i)
      bits[i / 8] = static_cast<std::uint8_t>(bits[i / 8] | seen[i] << (i % 8));
    writer.put_all(bits);
    writer.put_all(blockers);
    writer.put_all(clear_lines);
  }
  void take(PartReader& reader) {
    std::vector<std::uint8_t> bits((seen.size() + 7) / 8);
    reader.take_all(bits);
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = bits[i / 8] >> (i % 8) & 1;
    reader.take_all(blockers);
    reader.take_all(clear_lines);
  }
};

/// What one observer sees, batch by batch.
class View {
 public:
  View(const Occluders& occluders, const Observer& observer, const std::vector<glm::dvec2>& pattern,
       std::function<bool(const glm::dvec3& position)> in_view)
      : occluders_(occluders),
        tree_(occluders.octree().view()),
        observer_(observer),
        field_(observer),
        eye_(end_near_surface(occluders, observer.position)),
        pattern_(pattern),
        in_view_(std::move(in_view)) {}

  void look_at(const std::vector<PlacedPoint>& targets, BatchAnswers& answers) {
    find_in_view(targets);
    viewed_.clear();
    for (std::size_t i = 0; i < targets.size(); ++i) {
      if (is_in_view_[i] != 0) viewed_.push_back({targets[i], i});
    }
    lines_.resize(viewed_.size());
    blocked_.resize(viewed_.size());
    make_lines(0);
    if (answers.blockers.empty())
      blocked(occluders_, lines_, blocked_);
    else
      find_blockers(answers);
    for (std::size_t n = 0; n < viewed_.size(); ++n) answers.seen[viewed_[n].number] = blocked_[n] == 0;
    if (!answers.clear_lines.empty()) test_discs(answers);
  }

 private:
  /// A target of the batch that is in view, and its number in it.
  struct Viewed {
    PlacedPoint target;
    std::size_t number;
  };

  void find_in_view(const std::vector<PlacedPoint>& targets) {
    is_in_view_.resize(targets.size());
    in_parallel(targets.size(), 256, [&](std::size_t i) {
      const glm::dvec3& position = targets[i].position;
      is_in_view_[i] = field_.reaches(position - observer_.position) && (!in_view_ || in_view_(position));
    });
  }

  /// Makes the lines to the requested points, or beside them on their discs.
  void make_lines(std::size_t sub_ray) {
    in_parallel(viewed_.size(), 64, [&](std::size_t n) {
      const PlacedPoint& target = viewed_[n].target;
      SightEnd end = end_on_point(occluders_, target.point_id, target.position, observer_.position);
      if (sub_ray > 0) shift(end, target, pattern_[sub_ray]);
      lines_[n] = sight_line(eye_, end);
    });
  }

  /// Moves an end over the disc of its point.
  void shift(SightEnd& end, const PlacedPoint& target, const glm::dvec2& by) const {
    const PointSurface surface = occluders_.surface(target.point_id);
    glm::dvec3 normal = surface.normal;
    if (!surface.exists && target.position != observer_.position)
      normal = glm::normalize(target.position - observer_.position);
    double radius = occluders_.largest_radius();
    const PointLayers& layers = occluders_.octree().layers();
    if (layers.spacings != nullptr) radius = std::min(radius, spacing_at(layers, target.index) / 3.0);
    const glm::dvec3 first = glm::normalize(across(normal)), second = glm::cross(normal, first);
    end.position += radius * (by.x * first + by.y * second);
    end.own_reach += radius;
  }

  void find_blockers(BatchAnswers& answers) {
    first_.resize(lines_.size());
    first_blockers(occluders_, lines_, first_);
    for (std::size_t n = 0; n < lines_.size(); ++n) {
      blocked_[n] = first_[n].has_value();
      if (!first_[n]) continue;
      answers.blockers[viewed_[n].number] =
          first_[n]->is_mesh() ? k_blocked_by_mesh : static_cast<std::uint32_t>(first_[n]->point_id);
    }
  }

  void test_discs(BatchAnswers& answers) {
    std::vector<std::uint8_t> clear(viewed_.size());
    for (std::size_t n = 0; n < viewed_.size(); ++n) clear[n] = blocked_[n] == 0;
    for (std::size_t sub_ray = 1; sub_ray < pattern_.size(); ++sub_ray) {
      make_lines(sub_ray);
      blocked(occluders_, lines_, blocked_);
      for (std::size_t n = 0; n < viewed_.size(); ++n)
        clear[n] = static_cast<std::uint8_t>(clear[n] + (blocked_[n] == 0));
    }
    for (std::size_t n = 0; n < viewed_.size(); ++n) answers.clear_lines[viewed_[n].number] = clear[n];
  }

  const Occluders& occluders_;
  const TreeView& tree_;
  const Observer& observer_;
  const FieldOfView field_;
  const SightEnd eye_;
  const std::vector<glm::dvec2>& pattern_;
  const std::function<bool(const glm::dvec3& position)> in_view_;
  // Of the current batch.
  std::vector<std::uint8_t> is_in_view_;
  std::vector<Viewed> viewed_;
  std::vector<SightLine> lines_;
  std::vector<std::uint8_t> blocked_;
  std::vector<std::optional<Blocker>> first_;
};

/// Adds what observer `number` sees of some points to what all see, and to `seen` unless that is empty.
void add_answers(const std::vector<PlacedPoint>& targets, const BatchAnswers& answers, std::size_t number,
                 int lines_per_point, PointVisibility& all, std::vector<std::uint8_t>& seen) {
  // No two targets of a batch are the same point.
  in_parallel(targets.size(), 256, [&](std::size_t i) {
    const std::uint64_t id = targets[i].point_id;
    if (answers.seen[i] != 0) {
      if (!seen.empty()) seen[id] = 1;
      ++all.counts[id];
      if (!all.masks.empty()) all.masks[id] |= std::uint64_t{1} << number;
    }
    if (!all.blockers.empty()) all.blockers[number][id] = answers.blockers[i];
    if (all.fractions.empty()) return;
    const float share = static_cast<float>(answers.clear_lines[i]) / static_cast<float>(lines_per_point);
    all.fractions[id] = std::max(all.fractions[id], share);
  });
}

bool has_masks(std::size_t observers) {
  return observers > 1 && observers <= k_most_mask_observers;
}

/// The further limit of an observer's view (PointVisibilityOptions); empty: none.
std::function<bool(const glm::dvec3&)> in_view_of(const PointVisibilityOptions& options,
                                                  std::size_t observer) {
  if (!options.in_view) return {};
  return [&in_view = options.in_view, observer](const glm::dvec3& position) {
    return in_view(observer, position);
  };
}

PointVisibility make_columns(std::size_t points, std::size_t observers,
                             const PointVisibilityOptions& options) {
  PointVisibility all;
  all.counts.resize(points);
  if (has_masks(observers)) all.masks.resize(points);
  if (options.sub_rays > 1) all.fractions.resize(points);
  if (options.with_blockers) all.blockers.assign(observers, std::vector<std::uint32_t>(points, k_no_blocker));
  return all;
}

}  // namespace

void check_point_visibility(std::uint64_t points, std::size_t observers,
                            const PointVisibilityOptions& options) {
  constexpr std::uint64_t k_always = 5, k_to_write = 12;
  check_that(options.sub_rays >= 1 && options.sub_rays <= k_most_sub_rays,
             "number of lines to a disc out of range", fmt::format("1 to {}", k_most_sub_rays),
             std::to_string(options.sub_rays));
  const std::uint64_t bytes_per_point =
      k_always + k_to_write + (has_masks(observers) ? sizeof(std::uint64_t) : 0) +
      (options.sub_rays > 1 ? sizeof(float) : 0) +
      (options.with_blockers ? sizeof(std::uint32_t) * std::uint64_t{observers} : 0);
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(points, bytes_per_point, &bytes))
    bytes = std::numeric_limits<std::uint64_t>::max();
  check_memory(bytes, options.with_blockers
                          ? "the visibility of all points and a column of blockers for each observer"
                          : "the visibility of all points");
}

PointVisibility point_visibility(const Occluders& occluders, std::span<const Observer> observers,
                                 const PointVisibilityOptions& options) {
  check_point_visibility(occluders.octree().size(), observers.size(), options);
  const TreeView& tree = occluders.octree().view();
  const auto lines_per_point = static_cast<std::uint64_t>(options.sub_rays);
  const std::uint64_t total = lines_per_point * tree.point_count * observers.size();
  const std::vector<glm::dvec2> pattern = disc_pattern(options.sub_rays);
  std::vector<std::vector<Leaf>> batches = leaf_blocks(tree, batch_size(options.sub_rays));
  if (batches.empty()) batches.emplace_back();
  PointVisibility all = make_columns(tree.point_count, observers.size(), options);
  std::uint64_t done = 0;
  std::optional<View> view;
  std::size_t viewer = observers.size();
  std::vector<PlacedPoint> targets;
  std::size_t targets_batch = batches.size();
  const auto fetch_targets = [&](std::size_t batch) {
    if (targets_batch != batch) targets = placed_points(tree, batches[batch]);
    targets_batch = batch;
  };
  // By point id, if requested.
  std::vector<std::uint8_t> seen(options.each_observer ? tree.point_count : 0);
  run_parts(
      options.parts, batches.size() * observers.size(),
      [&](std::uint64_t part, PartWriter& writer) {
        const std::size_t number = part / batches.size();
        if (viewer != number)
          view.emplace(occluders, observers[number], pattern, in_view_of(options, number));
        viewer = number;
        fetch_targets(part % batches.size());
        BatchAnswers answers(targets.size(), all);
        view->look_at(targets, answers);
        answers.put(writer);
      },
      [&](std::uint64_t part, PartReader& reader) {
        const std::size_t number = part / batches.size(), batch = part % batches.size();
        if (batch == 0) std::ranges::fill(seen, std::uint8_t{0});
        fetch_targets(batch);
        BatchAnswers answers(targets.size(), all);
        answers.take(reader);
        add_answers(targets, answers, number, options.sub_rays, all, seen);
        done += lines_per_point * targets.size();
        report(options.progress, done, total);
        if (batch + 1 == batches.size() && options.each_observer) options.each_observer(number, seen);
      });
  return all;
}

}  // namespace alidade::visibility
