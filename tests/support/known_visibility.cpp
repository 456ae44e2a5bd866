// SPDX-License-Identifier: MIT
#include "tests/support/known_visibility.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

#include "octree/query.h"
#include "octree/tree_walk.h"
#include "simulation/courtyard.h"
#include "surface/surface_cloud.h"
#include "tests/support/random.h"
#include "tests/support/spacings.h"

namespace alidade::test {

using namespace simulation;

namespace {

const glm::dvec3 k_origin(690000.0, 5325000.0, 600.0);

/// Near enough to a normal distribution: the sum of twelve even ones.
double bell(Random& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += random.unit();
  return sum;
}

KnownScene scene_of(const std::string& name, Site site) {
  KnownScene scene{name, std::move(site), {}, {}, {}, {}};
  scene.cloud.lattice = {.scale = glm::dvec3(1e-4), .offset = scene.site.origin()};
  return scene;
}

KnownScene scene_of(const std::string& name, const std::vector<shapes::Shape>& all) {
  std::vector<SiteObject> objects;
  for (const shapes::Shape& shape : all) objects.push_back({shape, {}});
  return scene_of(name, Site(std::move(objects), k_origin));
}

void add(KnownScene& scene, const SiteHit& hit, double noise, Random& random) {
  scene.exact.push_back(hit.position);
  scene.normals.push_back(hit.normal);
  const glm::dvec3 position = hit.position + noise * bell(random) * hit.normal;
  scene.cloud.positions.emplace_back(
      glm::round((position - scene.cloud.lattice.offset) / scene.cloud.lattice.scale));
}

/// Whether a point at a position of the site's frame is taken.
using Keep = std::function<bool(const glm::dvec3& position, Random& random)>;

/// Points where random lines through the bounds meet the site: by Crofton's formula they lie evenly on all
/// its surfaces, `density` per square metre.
void sample_evenly(KnownScene& scene, double density, double noise, Random& random, const Keep& keep = {}) {
  const Bounds& bounds = scene.site.bounds();
  const double radius = 0.5 * glm::length(bounds.size());
  const auto lines = static_cast<std::size_t>(2.0 * std::numbers::pi * radius * radius * density);
  for (std::size_t i = 0; i < lines; ++i) {
    const glm::dvec3 direction = glm::normalize(random.direction());
    const glm::dvec3 side = glm::normalize(
        glm::cross(direction, std::fabs(direction.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const double angle = random.between(0.0, 2.0 * std::numbers::pi), far = radius * std::sqrt(random.unit());
    const glm::dvec3 start = bounds.center() +
                             far * (std::cos(angle) * side + std::sin(angle) * glm::cross(direction, side)) -
                             radius * direction;
    double t = 0.0;
    while (const std::optional<SiteHit> hit = scene.site.closest(make_ray(start, direction, t))) {
      if (!keep || keep(hit->position - scene.site.origin(), random)) add(scene, *hit, noise, random);
      t = hit->t + 1e-6;
    }
  }
}

shapes::Box box(const glm::dvec3& low, const glm::dvec3& high) {
  return {.center = 0.5 * (low + high), .half_size = 0.5 * (high - low)};
}

/// From an observer to a tenth of a millimetre above a point's exact position.
Ray exact_line(const KnownScene& scene, std::size_t id, const glm::dvec3& observer) {
  constexpr double k_above = 1e-4;
  const glm::dvec3& position = scene.exact[id];
  const double side = glm::dot(observer - position, scene.normals[id]) < 0.0 ? -1.0 : 1.0;
  const glm::dvec3 way = position + side * k_above * scene.normals[id] - observer;
  return make_ray(observer, way, 0.0, glm::length(way));
}

/// Whether a line passes an edge of a point's surface, other than the line's target.
bool passes_edge(const KnownScene& scene, const Ray& line, const Candidate& candidate) {
  const glm::dvec3& middle = scene.exact[candidate.point_id];
  const glm::dvec3& normal = scene.normals[candidate.point_id];
  const double t = glm::dot(middle - line.origin, normal) / glm::dot(line.direction, normal);
  if (!(t > 0.0 && line.t_max - t > candidate.radius)) return false;
  return glm::length(line.position(t) - middle) <= candidate.radius;
}

}  // namespace

KnownScene known_courtyard(std::size_t points) {
  KnownScene scene = scene_of("courtyard, " + std::to_string(points) + " points", courtyard());
  Random random("known_courtyard");
  const std::vector<glm::dvec3> stations = {{-12, -8, 1.7}, {12, -8, 1.7}, {0, 9, 1.7},     {-18, 10, 1.7},
                                            {18, 12, 1.7},  {0, -31, 1.7}, {-30, -33, 1.7}, {28, -33, 1.7}};
  for (std::size_t i = 0; scene.cloud.size() < points; ++i) {
    std::optional<SiteHit> hit;
    if (i % 2 == 0) {
      hit = scene.site.closest(make_ray(scene.site.origin() + stations[(i / 2) % stations.size()],
                                        random.direction(), 0.5, 120.0));
    } else {
      const glm::dvec3 above(random.between(-60, 60), random.between(-52, 52), 60.0);
      hit = scene.site.closest(make_ray(scene.site.origin() + above,
                                        {random.between(-0.4, 0.4), random.between(-0.4, 0.4), -1.0}, 0.0));
    }
    if (hit) add(scene, *hit, 0.003, random);
  }
  for (const glm::dvec3& observer :
       {glm::dvec3(3, -12, 1.7), glm::dvec3(-20, 2, 1.7), glm::dvec3(5, -30, 1.7)})
    scene.observers.push_back(scene.site.origin() + observer);
  return scene;
}

KnownScene thin_plate() {
  Random random("thin_plate");
  KnownScene scene = scene_of("thin plate, 1 mm", {box({-1, -0.0005, 0}, {1, 0.0005, 1.5})});
  sample_evenly(scene, 1e4, 0.0001, random);
  scene.observers = {k_origin + glm::dvec3(0.3, -3.0, 1.0), k_origin + glm::dvec3(-1.5, 2.0, 0.5)};
  return scene;
}

KnownScene fence() {
  Random random("fence");
  std::vector<shapes::Shape> all{box({-3, 3, 0}, {3, 3.2, 2.5})};
  for (int slat = -25; slat < 25; ++slat)
    all.emplace_back(box({0.08 * slat, 0, 0}, {0.08 * slat + 0.04, 0.02, 1.5}));
  KnownScene scene = scene_of("fence before a wall", all);
  sample_evenly(scene, 4e3, 0.001, random);
  scene.observers = {k_origin + glm::dvec3(0.1, -2.5, 1.2), k_origin + glm::dvec3(-1.2, -4.0, 0.8)};
  return scene;
}

KnownScene canopy() {
  Random random("canopy");
  std::vector<shapes::Shape> all{box({-6, -6, -0.5}, {6, 6, 0})};
  for (const glm::dvec3& tree : {glm::dvec3(-2, 0, 3), glm::dvec3(2.5, 1.5, 3.5)}) {
    all.emplace_back(shapes::Frustum{
        .base = {tree.x, tree.y, 0}, .length = tree.z, .base_radius = 0.15, .top_radius = 0.08});
    for (int leaf = 0; leaf < 1200; ++leaf) {
      const glm::dvec3 center = tree + 1.6 * std::cbrt(random.unit()) * glm::normalize(random.direction());
      all.emplace_back(
          shapes::Disc{.center = center, .normal = glm::normalize(random.direction()), .radius = 0.06});
    }
  }
  KnownScene scene = scene_of("trees above ground", all);
  sample_evenly(scene, 800.0, 0.002, random);
  scene.observers = {k_origin + glm::dvec3(-5, -5, 1.7), k_origin + glm::dvec3(0, 0, 8)};
  return scene;
}

KnownScene mixed_density() {
  Random random("mixed_density");
  std::vector<shapes::Shape> all{box({-3, 0, 0}, {3, 0.3, 2.5}), box({-6, -4, -0.3}, {6, 6, 0})};
  for (const double x : {-4.0, -1.5, 1.5, 3.5}) all.emplace_back(box({x - 0.4, 2.0, 0}, {x + 0.4, 2.8, 1.0}));
  KnownScene scene = scene_of("wall of two densities", all);
  // 5,000 points per square metre on one half of the wall, 50 on its other half, 1,500 on the boxes, 100 on
  // the ground.
  sample_evenly(scene, 5000.0, 0.003, random, [](const glm::dvec3& position, Random& chance) {
    if (position.z <= 0.0) return chance.unit() < 0.02;
    if (position.y < 1.0 && position.x > 0.0) return chance.unit() < 0.01;
    return position.y < 1.0 || chance.unit() < 0.3;
  });
  scene.observers = {k_origin + glm::dvec3(1.0, -3.0, 1.7), k_origin + glm::dvec3(-1.0, -3.5, 1.2),
                     k_origin + glm::dvec3(0.5, 4.5, 1.6)};
  return scene;
}

KnownScene grazing_slope() {
  Random random("grazing_slope");
  const double angle = 1.0 * std::numbers::pi / 180.0;
  const glm::dmat3 axes({std::cos(angle), 0, std::sin(angle)}, {0, 1, 0},
                        {-std::sin(angle), 0, std::cos(angle)});
  shapes::Box ground{.axes = axes, .half_size = {100, 15, 2.0}};
  // Its upper side goes through the frame's zero at the lower end.
  ground.center = axes * glm::dvec3(100, 0, -2.0);
  const glm::dvec3 foot = axes * glm::dvec3(60, 0, 0);
  KnownScene scene = scene_of("rising ground, grazing",
                              {ground, box(foot + glm::dvec3(-1, -2, -1), foot + glm::dvec3(1, 2, 1))});
  sample_evenly(scene, 8.0, 0.02, random);
  scene.observers = {k_origin + glm::dvec3(0.5, 0.0, 1.7), k_origin + glm::dvec3(0.5, -5.0, 2.5)};
  return scene;
}

std::vector<std::uint8_t> truth(const KnownScene& scene, const glm::dvec3& observer) {
  std::vector<std::uint8_t> seen(scene.cloud.size());
  tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t id) {
    seen[id] = scene.site.occluded(exact_line(scene, id, observer)) ? 0 : 1;
  });
  return seen;
}

std::vector<std::uint8_t> near_boundary(const KnownScene& scene, const Octree& octree,
                                        const std::vector<std::uint8_t>& truth) {
  std::vector<std::uint8_t> near(scene.cloud.size());
  const std::vector<double> spacings = spacings_by_id(octree);
  tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t id) {
    PointQuery query{.radius = 2.0 * spacings[id], .k = 1};
    query.filter = [&](const Candidate& other) { return truth[other.point_id] != truth[id]; };
    near[id] = find(octree, scene.cloud.world(id), query).empty() ? 0 : 1;
  });
  return near;
}

std::vector<std::uint8_t> near_boundary_or_edge(const KnownScene& scene, const Octree& octree,
                                                const std::vector<std::uint8_t>& truth,
                                                const glm::dvec3& observer, std::size_t step) {
  std::vector<std::uint8_t> near = near_boundary(scene, octree, truth);
  const SurfaceCloud spheres = SurfaceCloud::of_spheres(octree);
  constexpr double k_two_radii = 2.0 * 0.92;
  tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t id) {
    if (id % step != 0) near[id] = 1;
    if (near[id] || !truth[id]) return;
    const Ray line = exact_line(scene, id, observer);
    SurfaceQuery query{.spacing_factor = k_two_radii, .measure = Measure::t};
    query.filter = [&](const Candidate& candidate) { return passes_edge(scene, line, candidate); };
    near[id] = occluded(spheres, line, query) ? 1 : 0;
  });
  return near;
}

Agreement agreement(const std::vector<std::uint8_t>& seen, const std::vector<std::uint8_t>& truth,
                    const std::vector<std::uint8_t>& near_boundary) {
  double right = 0, clear = 0, clear_right = 0, said = 0, is = 0, both = 0;
  for (std::size_t id = 0; id < seen.size(); ++id) {
    const bool same = seen[id] == truth[id];
    right += same;
    if (near_boundary[id]) continue;
    clear += 1;
    clear_right += same;
    said += seen[id];
    is += truth[id];
    both += seen[id] && truth[id];
  }
  const auto share = [](double part, double whole) { return whole > 0.0 ? part / whole : 1.0; };
  return {share(right, static_cast<double>(seen.size())), share(clear_right, clear), share(both, said),
          share(both, is)};
}

}  // namespace alidade::test
