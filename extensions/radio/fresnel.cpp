// SPDX-License-Identifier: MIT
#include "extensions/radio/fresnel.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "base/error.h"
#include "base/words.h"
#include "visibility/sight_line.h"

namespace alidade::visibility {
namespace {

constexpr int k_tubes = k_most_obstructions, k_rim_tubes = 64;

/// The tubes that fill the zone, from the inside out, then those for FresnelClearance::is_clear alone.
std::vector<CurveLine> tubes_of(const LineCurve& curve) {
  std::vector<CurveLine> tubes;
  for (int i = 0; i < k_tubes; ++i)
    tubes.push_back({&curve, {std::sqrt((i + 0.5) / k_tubes), golden_turns(i)}});
  for (int i = 0; i < k_rim_tubes; ++i)
    tubes.push_back({&curve, {k_clear_share, static_cast<double>(i) / k_rim_tubes}});
  tubes.push_back({&curve});
  return tubes;
}

/// Share of an ellipsoid's volume before the cross-section at this share of its length.
double volume_before(double share) {
  return share * share * (3.0 - 2.0 * share);
}

/// The part of a tube that is cut off, metres along the chord.
struct Stretch {
  double begin, end;
};

/// The largest number of stretches that one of `width` metres meets, and where the last of them begins.
std::pair<int, double> most_at_once(const std::vector<Stretch>& stretches, double width) {
  std::vector<std::pair<double, int>> changes;
  for (const Stretch& stretch : stretches) {
    // At equal t, a stretch that begins comes before one that ends.
    changes.push_back({stretch.begin, -1});
    changes.push_back({stretch.end + width, 1});
  }
  std::ranges::sort(changes);
  int open = 0;
  std::pair<int, double> most{0, 0.0};
  for (const auto& [t, change] : changes) {
    open -= change;
    if (open > most.first) most = {open, t};
  }
  return most;
}

std::vector<Obstruction> by_share(const std::map<std::uint64_t, int>& tubes_by_point) {
  std::vector<Obstruction> obstructions;
  for (const auto& [point_id, tubes] : tubes_by_point)
    obstructions.push_back({point_id, static_cast<double>(tubes) / k_tubes});
  std::ranges::stable_sort(obstructions, std::greater(), &Obstruction::share);
  return obstructions;
}

void measure_tubes(const Occluders& occluders, const LineCurve& curve, FresnelClearance& clearance) {
  const std::vector<CurveLine> tubes = tubes_of(curve);
  const std::vector<std::optional<CurveCrossings>> answers = crossings(occluders, tubes);
  std::vector<Stretch> stretches;
  std::map<std::uint64_t, int> tubes_by_point;
  int inner = 0, inner_obstructed = 0;
  double cut_off = 0.0;
  for (std::size_t i = 0; i < tubes.size(); ++i) {
    const bool is_inner = tubes[i].tube.share <= k_clear_share;
    if (is_inner && answers[i]) clearance.is_clear = false;
    if (i >= k_tubes) continue;
    inner += is_inner ? 1 : 0;
    if (!answers[i]) continue;
    inner_obstructed += is_inner ? 1 : 0;
    const Stretch stretch{answers[i]->first.distance, answers[i]->last_t};
    stretches.push_back(stretch);
    cut_off += volume_before(stretch.end / curve.length()) - volume_before(stretch.begin / curve.length());
    ++tubes_by_point[answers[i]->first.point_id];
  }
  const auto [most, most_t] = most_at_once(stretches, 2.0 * clearance.radius);
  clearance.obstructed = static_cast<double>(stretches.size()) / k_tubes;
  clearance.worst = static_cast<double>(most) / k_tubes;
  clearance.worst_t = most_t;
  clearance.cut_off = cut_off / k_tubes;
  clearance.inner = static_cast<double>(inner_obstructed) / inner;
  clearance.obstructions = by_share(tubes_by_point);
}

void measure_points(const Occluders& occluders, const LineCurve& curve, FresnelClearance& clearance) {
  const std::vector<LinePoint> points = points_in_zone(occluders, curve);
  clearance.points = points.size();
  for (const LinePoint& point : points) {
    // The zone has no width at its ends: points there count as on its rim.
    const double radius = curve.zone_radius(point.t), share = radius > 0.0 ? point.distance / radius : 1.0;
    const bool is_nearer = !clearance.nearest || share < clearance.nearest_share ||
                           (share == clearance.nearest_share && point.point_id < clearance.nearest->point_id);
    if (!is_nearer) continue;
    clearance.nearest = point;
    clearance.nearest_share = share;
  }
  if (clearance.nearest && clearance.nearest_share <= k_clear_share) clearance.is_clear = false;
}

}  // namespace

double fresnel_radius(double wavelength, double length) {
  return 0.5 * std::sqrt(wavelength * length);
}

FresnelClearance fresnel_clearance(const Occluders& occluders, const SightEnd& from, const SightEnd& to,
                                   const LineOptions& options, double wavelength) {
  check_that(wavelength > 0.0 && std::isfinite(wavelength), "invalid wavelength", "a positive number",
             std::to_string(wavelength));
  const int transparency = occluders.options().transparency;
  check_that(transparency == 1, "--transparency does not apply to Fresnel zones", "transparency 1",
             std::to_string(transparency));
  const double radius = fresnel_radius(wavelength, sight_line(from, to).length);
  const LineCurve curve(from, to, options, radius);
  FresnelClearance clearance{.radius = radius};
  if (!(curve.begin() < curve.end())) return clearance;
  measure_tubes(occluders, curve, clearance);
  measure_points(occluders, curve, clearance);
  return clearance;
}

std::optional<double> parse_frequency(std::string_view text) {
  constexpr double k_least = 1e6, k_most = 1e12;
  const std::size_t end = text.find_last_of("0123456789.");
  if (end == std::string_view::npos) return std::nullopt;
  const std::string unit = lower_case(trim(text.substr(end + 1)));
  const double factor = unit.empty() || unit == "ghz" ? 1e9 : unit == "mhz" ? 1e6 : 0.0;
  const std::optional<double> number = parse_number(trim(text.substr(0, end + 1)));
  const double hertz = number.value_or(0.0) * factor;
  return hertz >= k_least && hertz <= k_most ? std::optional(hertz) : std::nullopt;
}

}  // namespace alidade::visibility
