// SPDX-License-Identifier: MIT
#include "extensions/radiation/bounced_light.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <numbers>

#include "base/error.h"
#include "base/parallel.h"
#include "extensions/radiation/sky_patches.h"
#include "visibility/point_blocks.h"

namespace alidade::visibility {
namespace {

constexpr std::uint32_t k_no_slot = std::numeric_limits<std::uint32_t>::max();

/// A part of the sphere around a receiver that one line of sight represents.
struct Part {
  glm::dvec3 direction, integral;  ///< of direction over the solid angle
};

/// The patches of the sky, then their mirror images.
std::vector<Part> parts_of_sphere() {
  std::vector<Part> parts;
  for (const double sign : {1.0, -1.0}) {
    const glm::dvec3 mirror(1.0, 1.0, sign);
    for (int patch = 0; patch < k_sky_patches; ++patch)
      parts.push_back({mirror * line_into_patch(patch), mirror * direction_integral(sky_patch(patch))});
  }
  return parts;
}

/// Irradiance of a receiver with this normal by the part, per radiance; 0 if the part is behind it.
double weight_of(const Part& part, const glm::dvec3& normal) {
  return glm::dot(part.direction, normal) > 0.0 ? std::max(0.0, glm::dot(part.integral, normal)) : 0.0;
}

/// Factors of the weights of the upper and lower half that make their sums (1 + z) / 2 and (1 - z) / 2.
std::array<double, 2> scales_of(std::span<const Part> parts, const glm::dvec3& normal) {
  std::array<double, 2> sums{}, scales{};
  for (std::size_t k = 0; k < parts.size(); ++k) sums[k / k_sky_patches] += weight_of(parts[k], normal);
  for (std::size_t half = 0; half < 2; ++half) {
    const double exact = 0.5 * (half == 0 ? 1.0 + normal.z : 1.0 - normal.z);
    scales[half] = sums[half] > 0.0 ? exact / sums[half] : 0.0;
  }
  return scales;
}

/// A normal as numbers that are equal for its opposite and for normals that differ little.
std::array<std::int64_t, 3> kind_of(const PointSurface& surface) {
  if (!surface.exists) return {};
  const glm::dvec3 n = surface.normal;
  const double sign = n.z != 0.0 ? n.z : n.y != 0.0 ? n.y : n.x;
  constexpr double k_steps = 2.0;
  std::array<std::int64_t, 3> kind{};
  for (int axis = 0; axis < 3; ++axis)
    kind[static_cast<std::size_t>(axis)] = std::llround(std::copysign(1.0, sign) * k_steps * n[axis]);
  return kind;
}

}  // namespace

/// A side of a surface that a target sees, with its share of what the target gets.
struct BouncedLight::Met {
  std::uint32_t target, slot;
  double weight;
};

BouncedLight::BouncedLight(const Occluders& occluders, const EnergyLight& light,
                           const RadiationOptions& options, double cell)
    : occluders_(occluders),
      light_(light),
      options_(options),
      periods_(static_cast<std::size_t>(light.periods)) {
  check_that(cell >= 0.0 && std::isfinite(cell), "width of cubes out of range", "at least 0",
             fmt::format("{}", cell));
  options_.bounces = 0;
  if (cell > 0.0) group_points(cell);
  slots_.assign(2 * (cell > 0.0 ? groups_.size() : occluders.octree().size()), k_no_slot);
}

void BouncedLight::group_points(double cell) {
  const TreeView& tree = occluders_.octree().view();
  std::map<std::array<std::int64_t, 6>, std::uint32_t> known;
  group_of_.resize(tree.point_count);
  if (tree.point_count == 0) return;
  constexpr std::size_t k_points_at_once = 1 << 16;
  for (const std::vector<Leaf>& leaves : leaf_blocks(tree, k_points_at_once)) {
    for (const PlacedPoint& point : placed_points(tree, leaves)) {
      const std::array<std::int64_t, 3> kind = kind_of(occluders_.surface(point.point_id));
      const glm::dvec3 cube = glm::floor(point.position / cell);
      const auto [found, is_new] =
          known.try_emplace({static_cast<std::int64_t>(cube.x), static_cast<std::int64_t>(cube.y),
                             static_cast<std::int64_t>(cube.z), kind[0], kind[1], kind[2]},
                            static_cast<std::uint32_t>(groups_.size()));
      if (is_new) groups_.push_back({point.point_id, point.position});
      Group& group = groups_[found->second];
      if (point.point_id < group.point_id) group = {point.point_id, point.position};
      group_of_[point.point_id] = found->second;
    }
  }
}

std::uint32_t BouncedLight::new_slot() {
  const std::size_t slot = energies_.size() / periods_;
  energies_.resize(energies_.size() + periods_);
  return static_cast<std::uint32_t>(slot);
}

std::uint32_t BouncedLight::slot_of(const Blocker& blocker, const glm::dvec3& direction) {
  Group group{blocker.point_id, blocker.position};
  std::uint64_t index = blocker.point_id;
  if (!group_of_.empty()) {
    index = group_of_[blocker.point_id];
    group = groups_[index];
  }
  const PointSurface own = occluders_.surface(blocker.point_id), surface = occluders_.surface(group.point_id);
  bool is_back = surface.exists && glm::dot(own.normal, direction) > 0.0;
  if (surface.exists && glm::dot(own.normal, surface.normal) < 0.0) is_back = !is_back;
  std::uint32_t& slot = slots_[2 * index + (is_back ? 1 : 0)];
  if (slot == k_no_slot) {
    slot = new_slot();
    std::optional<glm::dvec3> side;
    if (surface.exists) side = is_back ? -surface.normal : surface.normal;
    pending_.push_back({slot, target_on_point(occluders_, group.point_id, group.position, side)});
  }
  return slot;
}

void BouncedLight::compute_pending() {
  RadiationOptions options{
      .receiver = SkyReceiver::surface, .max_distance = options_.max_distance, .albedo = 0.0};
  const auto first_sphere = std::stable_partition(
      pending_.begin(), pending_.end(), [](const PendingSide& side) { return side.target.has_surface(); });
  const auto surfaces = static_cast<std::size_t>(first_sphere - pending_.begin());
  constexpr std::size_t k_at_once = 1 << 14;
  std::vector<SkyTarget> targets;
  std::vector<Radiation> answers;
  for (std::size_t begin = 0; begin < pending_.size();) {
    options.is_sphere = begin >= surfaces;
    const std::size_t end = std::min(begin + k_at_once, options.is_sphere ? pending_.size() : surfaces);
    targets.clear();
    for (std::size_t i = begin; i < end; ++i) targets.push_back(pending_[i].target);
    answers.assign(targets.size() * periods_, {});
    radiation(occluders_, targets, light_, options, answers);
    for (std::size_t i = begin; i < end; ++i)
      std::copy_n(answers.begin() + static_cast<std::ptrdiff_t>((i - begin) * periods_), periods_,
                  energies_.begin() + static_cast<std::ptrdiff_t>(pending_[i].slot * periods_));
    begin = end;
  }
  pending_.clear();
}

void BouncedLight::add(std::span<const SkyTarget> targets, std::span<Radiation> answers) {
  assert(answers.size() == targets.size() * periods_);
  static const std::vector<Part> parts = parts_of_sphere();
  std::vector<glm::dvec3> normals(targets.size());
  std::vector<std::array<double, 2>> scales(targets.size());
  in_parallel(targets.size(), 64, [&](std::size_t i) {
    normals[i] = receiver_normal(targets[i], options_);
    scales[i] = scales_of(parts, normals[i]);
  });
  std::vector<double> ground(targets.size(), 0.0);
  std::vector<Met> met;
  std::vector<std::uint32_t> in_front;
  std::vector<SightLine> lines;
  std::vector<std::optional<Blocker>> blockers;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Part& part = parts[k];
    in_front.clear();
    for (std::uint32_t i = 0; i < targets.size(); ++i) {
      const bool is_behind = targets[i].has_surface() && !(glm::dot(part.direction, targets[i].normal) > 0.0);
      if (!is_behind && weight_of(part, normals[i]) > 0.0) in_front.push_back(i);
    }
    lines.resize(in_front.size());
    blockers.assign(in_front.size(), {});
    in_parallel(in_front.size(), 1024, [&](std::size_t i) {
      lines[i] = sight_ray(targets[in_front[i]].front, part.direction, options_.max_distance);
    });
    first_blockers(occluders_, lines, blockers);
    for (std::size_t i = 0; i < in_front.size(); ++i) {
      const std::uint32_t target = in_front[i];
      const double weight = scales[target][k / k_sky_patches] * weight_of(part, normals[target]);
      const std::optional<Blocker>& blocker = blockers[i];
      if (blocker && !blocker->is_mesh())
        met.push_back({target, slot_of(*blocker, part.direction), weight});
      else if (blocker || part.direction.z < 0.0)
        ground[target] += weight;
    }
  }
  compute_pending();
  std::vector<double> sums(answers.size(), 0.0);
  for (const Met& one : met) {
    for (std::size_t period = 0; period < periods_; ++period) {
      const Radiation& energy = energies_[one.slot * periods_ + period];
      sums[one.target * periods_ + period] +=
          one.weight * (static_cast<double>(energy.beam) + static_cast<double>(energy.diffuse));
    }
  }
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const LightSums& open = light_.open[i % periods_];
    const double all = sums[i] + ground[i / periods_] * (open.beam.z + open.diffuse.z);
    answers[i].reflected = static_cast<float>(options_.albedo * all);
  }
}

void BouncedLight::answer_points(std::span<const SkyTarget> targets, std::span<const std::uint64_t> point_ids,
                                 std::span<Radiation> answers) {
  assert(group_of_.empty() && targets.size() == point_ids.size());
  // Points without a surface are not kept: they receive as horizontal surfaces, but reflect as spheres.
  std::vector<std::uint32_t> of_target(targets.size(), k_no_slot);
  std::vector<SkyTarget> alone;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (!targets[i].has_surface()) {
      alone.push_back(targets[i]);
      continue;
    }
    const bool is_back = glm::dot(occluders_.surface(point_ids[i]).normal, targets[i].normal) < 0.0;
    std::uint32_t& slot = slots_[2 * point_ids[i] + (is_back ? 1 : 0)];
    if (slot == k_no_slot) {
      slot = new_slot();
      pending_.push_back({slot, targets[i]});
    }
    of_target[i] = slot;
  }
  compute_pending();
  std::vector<Radiation> of_alone(alone.size() * periods_);
  radiation(occluders_, alone, light_, options_, of_alone);
  auto next = of_alone.cbegin();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const bool is_kept = of_target[i] != k_no_slot;
    const auto from =
        is_kept ? energies_.cbegin() + static_cast<std::ptrdiff_t>(of_target[i] * periods_) : next;
    std::copy_n(from, periods_, answers.begin() + static_cast<std::ptrdiff_t>(i * periods_));
    if (!is_kept) next += static_cast<std::ptrdiff_t>(periods_);
  }
}

}  // namespace alidade::visibility
