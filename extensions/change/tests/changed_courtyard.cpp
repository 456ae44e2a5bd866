// SPDX-License-Identifier: MIT
#include "extensions/change/tests/changed_courtyard.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <stdexcept>

#include "base/parallel.h"
#include "simulation/courtyard.h"
#include "simulation/scan.h"

namespace alidade::test {

using simulation::Site;
using simulation::SiteHit;
using simulation::SiteObject;
using visibility::ChangeClass;
namespace shapes = simulation::shapes;

namespace {

using Objects = std::vector<SiteObject>;

/// Takes out the objects whose middles are within a horizontal distance of a position and less than 2 m high.
Objects take(Objects& objects, const glm::dvec2& position, double radius) {
  Objects taken;
  std::erase_if(objects, [&](const SiteObject& object) {
    const glm::dvec3 middle = shapes::bounds_of(object.shape).center();
    const bool is_there = glm::length(glm::dvec2(middle) - position) < radius && middle.z < 2.0;
    if (is_there) taken.push_back(object);
    return is_there;
  });
  return taken;
}

struct Translate {
  glm::dvec3 shift;

  void operator()(shapes::Sphere& sphere) const { sphere.center += shift; }
  void operator()(shapes::Disc& disc) const { disc.center += shift; }
  void operator()(shapes::Box& box) const { box.center += shift; }
  void operator()(shapes::Frustum& frustum) const { frustum.base += shift; }
  void operator()(shapes::ConvexSolid& solid) const {
    for (shapes::HalfSpace& side : solid.sides) side.offset += glm::dot(side.normal, shift);
    solid.bounds = {solid.bounds.min + shift, solid.bounds.max + shift};
  }
  template <class Other>
  void operator()(Other&) const {
    throw std::logic_error("no furniture has this shape");
  }
};

void put(Objects& objects, Objects things, const glm::dvec3& shift) {
  for (SiteObject& thing : things) {
    std::visit(Translate{shift}, thing.shape);
    objects.push_back(std::move(thing));
  }
}

SiteObject box(const glm::dvec3& low, const glm::dvec3& high) {
  return {shapes::Box{.center = 0.5 * (low + high), .half_size = 0.5 * (high - low)}, {}};
}

/// The exact point of a scan: where its beam meets the site. Empty for a few that rounding to the lattice has
/// moved past an edge.
std::optional<SiteHit> exact_point(const SiteState& own, const glm::dvec3& point, std::uint16_t station) {
  constexpr double k_noise = 0.02;  // metres along the beam
  const glm::dvec3& eye = own.stations.at(station - 1u);
  const auto hit = own.site.closest(make_ray(eye, point - eye, 0.3));
  return hit && glm::length(hit->position - point) < k_noise ? hit : std::nullopt;
}

constexpr double k_same = 0.001;  // metres across a surface

/// The beam of a station through a position; empty below its reach.
std::optional<Ray> beam(const glm::dvec3& station, const glm::dvec3& position, double length) {
  const double lowest = -std::sqrt(0.75);  // sine of 60 degrees
  const glm::dvec3 way = position - station;
  if (way.z < lowest * glm::length(way)) return std::nullopt;
  return make_ray(station, way, 0.3, length);
}

/// Smallest angle under which a station sees a position, divided by the distance: radians of a beam's step
/// become metres on the surface if divided by it. 0 if no station sees it.
double seen_density(const SiteState& state, const glm::dvec3& position, const glm::dvec3& normal) {
  double most = 0.0;
  for (const glm::dvec3& station : state.stations) {
    const double distance = glm::length(position - station);
    const auto line = beam(station, position, distance);
    if (!line) continue;
    const auto hit = state.site.closest(*line);
    if (!hit || std::fabs(glm::dot(position - hit->position, hit->normal)) < k_same)
      most = std::max(most, std::fabs(glm::dot(line->direction, normal)) / distance);
  }
  return most;
}

bool is_passed(const SiteState& state, const glm::dvec3& position) {
  constexpr double k_range = 120.0;
  return std::ranges::any_of(state.stations, [&](const glm::dvec3& station) {
    const auto line = beam(station, position, k_range);
    const auto hit = line ? state.site.closest(*line) : std::nullopt;
    return hit && hit->t > glm::length(position - station) &&
           std::fabs(glm::dot(position - hit->position, hit->normal)) > k_same;
  });
}

/// The parallel surface that a station sees nearest to an exact point on its normal, within reach.
std::optional<SiteHit> counterpart(const SiteState& state, const SiteHit& point, double reach) {
  Ray line = make_ray(point.position - reach * point.normal, point.normal, 0.0, 2.0 * reach);
  std::optional<SiteHit> nearest;
  while (const std::optional<SiteHit> hit = state.site.closest(line)) {
    const bool is_nearer = !nearest || std::fabs(hit->t - reach) < std::fabs(nearest->t - reach);
    const bool is_parallel = std::fabs(glm::dot(hit->normal, point.normal)) >= std::sqrt(0.5);
    if (is_nearer && is_parallel && seen_density(state, hit->position, hit->normal) > 0.0) nearest = hit;
    line.t_min = hit->t + 1e-6;
  }
  return nearest;
}

}  // namespace

ChangedCourtyard changed_courtyard() {
  const Site courtyard = simulation::courtyard();
  Objects before = courtyard.objects();
  const SiteObject stone = box({-20.0, -4.0, -0.1}, {-18.0, -3.0, 1.5});
  Objects after = before;
  before.push_back(stone);
  put(after, {stone}, {0.02, 0.04, -0.01});
  take(after, {11.6, -9.0}, 2.7);                                  // the red car
  put(after, take(after, {14.8, -3.4}, 2.7), {2.4, 2.0, 0.0});     // the blue one
  take(after, {4.24, 3.74}, 1.2);                                  // a bench
  put(after, take(after, {-4.24, -4.74}, 1.2), {-1.5, 0.3, 0.0});  // another
  after.push_back(box({-10.4, -2.5, 0.0}, {-9.4, -1.7, 0.9}));     // crates
  after.push_back(box({-10.2, -2.4, 0.9}, {-9.5, -1.9, 1.5}));
  after.push_back(box({20.0, 14.0, 0.0}, {21.2, 14.8, 1.1}));
  after.push_back({shapes::Frustum{{12.0, 0.5, 0.0}, {0, 0, 1}, 0.9, 0.29, 0.29}, {}});  // a drum
  after.push_back({shapes::Disc{{12.0, 0.5, 0.9}, {0, 0, 1}, 0.29, 0.0}, {}});
  after.push_back(box({8.0, -15.5, -0.1}, {11.0, -13.0, 0.05}));  // soil
  before.push_back(box({-4.0, 5.0, -0.1}, {-1.5, 7.5, 0.03}));    // a slab

  ChangedCourtyard changed{{Site(std::move(before), courtyard.origin()), {}},
                           {Site(std::move(after), courtyard.origin()), {}}};
  for (const simulation::Station& station : simulation::courtyard_scan(1000, 1).stations)
    changed.before.stations.push_back(station.position);
  for (std::size_t i = 0; i < changed.before.stations.size(); ++i)
    if (i != 2 && i != 5)
      changed.after.stations.push_back(changed.before.stations[i] + glm::dvec3(0.9, -0.7, 0.0));
  return changed;
}

PointCloud scan_of(const SiteState& state, std::uint64_t points, std::uint64_t seed) {
  simulation::ScanOptions options = simulation::courtyard_scan(points, seed);
  options.terrestrial_share = 1.0;
  options.stations.clear();
  for (const glm::dvec3& position : state.stations) options.stations.push_back({position});
  PointCloud cloud = simulation::scan_header(state.site);
  simulation::scan(state.site, options, [&](const PointCloud& batch) {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (batch.point_source_ids[i] > state.stations.size()) continue;  // of a flight line
      cloud.positions.push_back(batch.positions[i]);
      cloud.classifications.push_back(batch.classifications[i]);
      cloud.point_source_ids.push_back(batch.point_source_ids[i]);
    }
  });
  return cloud;
}

TrueChanges true_changes(const SiteState& own, const PointCloud& cloud, const SiteState& other,
                         double max_distance, ChangeClass lost) {
  TrueChanges changes{std::vector<ChangeClass>(cloud.size()),
                      std::vector<double>(cloud.size(), std::numeric_limits<double>::quiet_NaN()),
                      std::vector<double>(cloud.size())};
  in_parallel(cloud.size(), 256, [&](std::size_t id) {
    const auto point = exact_point(own, cloud.world(id), cloud.point_source_ids[id]);
    if (!point) {
      changes.classes[id] = ChangeClass::ignored;
      return;
    }
    if (const auto found = counterpart(other, *point, max_distance)) {
      changes.distances[id] = found->t - max_distance;
      changes.densities[id] = seen_density(other, found->position, found->normal);
      changes.classes[id] =
          std::fabs(changes.distances[id]) < k_same ? ChangeClass::same : ChangeClass::moved;
    } else {
      changes.classes[id] = is_passed(other, point->position) ? lost : ChangeClass::never_seen;
    }
  });
  return changes;
}

}  // namespace alidade::test
