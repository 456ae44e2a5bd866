// SPDX-License-Identifier: MIT
#include "visibility/horizon/near_lines.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "base/parallel.h"
#include "octree/spacing.h"
#include "visibility/crossing.h"
#include "visibility/point_blocks.h"

namespace alidade::visibility {
namespace {

constexpr double k_degrees = 180.0 / std::numbers::pi;

int entries(const ElevationSteps& elevations, int steps_per_entry) {
  return (elevations.high - elevations.low) / steps_per_entry + 1;
}

}  // namespace

/// The reaches of the points that can block lines from an eye.
class NearLines::Reaches {
 public:
  Reaches(const Occluders& occluders, const SightEnd& eye) : occluders_(occluders), eye_(eye) {}

  /// A little more than the radius of the point's disc or sphere; empty if it blocks no line.
  std::optional<double> of(const PlacedPoint& point) const {
    constexpr double k_more = 1.0 + 1e-6, k_less = 1.0 - 1e-6;
    const OccluderOptions& options = occluders_.options();
    if (options.counts && !options.counts(point.point_id)) return {};
    const PointLayers& layers = occluders_.octree().layers();
    const double radius =
        candidate_radius(occluders_, options.radius ? 0.0 : spacing_at(layers, point.index));
    const PointSurface surface = occluders_.surface(point.point_id);
    if (!surface.exists) {
      const double sphere = sphere_of(occluders_, radius);
      if (options.shape == OccluderShape::disc || is_within(eye_, point.position, k_less * sphere)) return {};
      return k_more * sphere;
    }
    if (is_own(eye_, point_disc(point.position, surface, radius), surface)) return {};
    return k_more * radius;
  }

 private:
  const Occluders& occluders_;
  const SightEnd& eye_;
};

NearLines::NearLines(const Occluders& occluders, const SightEnd& eye, const AzimuthSteps& azimuths,
                     const ElevationSteps& elevations, int steps_together)
    : azimuths_(azimuths), elevations_(elevations), steps_per_entry_(steps_together) {
  constexpr std::uint64_t k_most_entries = std::uint64_t{1} << 29;
  const auto columns = static_cast<std::uint64_t>(azimuths.count);
  while (columns * static_cast<std::uint64_t>(entries(elevations, steps_per_entry_)) > k_most_entries)
    steps_per_entry_ *= 2;
  words_per_azimuth_ = static_cast<std::size_t>(entries(elevations, steps_per_entry_) + 63) / 64;
  words_ = std::vector<std::atomic<std::uint64_t>>(columns * words_per_azimuth_);
  const Reaches reaches(occluders, eye);
  const TreeView& tree = occluders.octree().view();
  constexpr std::size_t k_points_at_once = 1 << 20, k_grain = 1024;
  for (const std::vector<Leaf>& leaves : leaf_blocks(tree, k_points_at_once)) {
    occluders.check_given_up();
    const std::vector<PlacedPoint> points = placed_points(tree, leaves);
    in_parallel(points.size(), k_grain, [&](std::size_t i) {
      const std::optional<double> reach = reaches.of(points[i]);
      // Points of one position mostly follow each other, and mark the same lines.
      const bool is_marked =
          i > 0 && points[i - 1].position == points[i].position && reaches.of(points[i - 1]).has_value();
      if (reach && !is_marked) mark_around(points[i].position - eye.position, *reach);
    });
  }
}

/// Marks all lines that come within reach of a point: a disc or sphere blocks only
/// lines that pass through it.
void NearLines::mark_around(const glm::dvec3& offset, double reach) {
  constexpr double k_slack = 1e-5;  // degrees, far more than the errors of directions
  const double distance = glm::length(offset), run = std::hypot(offset.x, offset.y);
  const double elevation = k_degrees * std::atan2(offset.z, run);
  const double half_width = distance > reach ? k_degrees * std::asin(reach / distance) + k_slack : 180.0;
  const auto step_at = [&](double degrees) { return degrees / 90.0 * elevations_.per_quarter; };
  const double low = std::max(std::ceil(step_at(elevation - half_width)), double(elevations_.low)),
               high = std::min(std::floor(step_at(elevation + half_width)), double(elevations_.high));
  if (low > high) return;
  int first = 0, last = azimuths_.per_turn - 1;
  if (std::fabs(elevation) + half_width < 90.0) {
    // The widest azimuth of a circle on the sphere.
    const double aside =
        k_degrees *
            std::asin(std::min(1.0, std::sin(half_width / k_degrees) / std::cos(elevation / k_degrees))) +
        k_slack;
    const double azimuth = k_degrees * std::atan2(offset.x, offset.y);
    first = static_cast<int>(std::ceil((azimuth - aside) / 360.0 * azimuths_.per_turn));
    last = static_cast<int>(std::floor((azimuth + aside) / 360.0 * azimuths_.per_turn));
  }
  mark(first, std::min(last, first + azimuths_.per_turn - 1), static_cast<int>(low), static_cast<int>(high));
}

/// first_azimuth, last_azimuth: numbers, of any turn.
void NearLines::mark(int first_azimuth, int last_azimuth, int low, int high) {
  const int first_entry = entry_of(low), last_entry = entry_of(high);
  for (int number = first_azimuth; number <= last_azimuth; ++number) {
    const int turn = azimuths_.per_turn, column = ((number - azimuths_.first) % turn + turn) % turn;
    if (column >= azimuths_.count) continue;
    const std::size_t first_word = static_cast<std::size_t>(column) * words_per_azimuth_;
    for (int entry = first_entry; entry <= last_entry; ++entry) {
      std::atomic<std::uint64_t>& word = words_[first_word + static_cast<std::size_t>(entry / 64)];
      const std::uint64_t bit = std::uint64_t{1} << (entry % 64);
      if ((word.load(std::memory_order_relaxed) & bit) == 0) word.fetch_or(bit, std::memory_order_relaxed);
    }
  }
}

bool NearLines::are_free(int azimuth, int low, int high) const {
  const std::size_t first_word = static_cast<std::size_t>(azimuth) * words_per_azimuth_;
  for (int entry = entry_of(low); entry <= entry_of(high); ++entry) {
    const std::uint64_t word =
        words_[first_word + static_cast<std::size_t>(entry / 64)].load(std::memory_order_relaxed);
    if ((word >> (entry % 64) & 1) != 0) return false;
  }
  return true;
}

}  // namespace alidade::visibility
