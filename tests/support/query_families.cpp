// SPDX-License-Identifier: MIT
#include "tests/support/query_families.h"

#include <fmt/format.h>

#include <cmath>

#include "octree/distance.h"
#include "tests/support/positions.h"
#include "tests/support/ray_families.h"

namespace alidade::test {
namespace {

std::size_t some_k(Random& random) {
  const std::size_t choices[] = {1, 2, 8, 50, k_all, k_all};
  return choices[random.below(std::size(choices))];
}

Measure some_measure(Random& random, bool with_entry) {
  const Measure choices[] = {Measure::distance, Measure::t, Measure::entry};
  return choices[random.below(with_entry ? 3 : 2)];
}

/// Half of the cases have none.
template <class Target, class Query>
void add_filter(QueryCase<Target, Query>& c, const Positions& positions, Random& random) {
  const double middle = positions.bounds().center().x, near = positions.spacing();
  CandidateFilter& filter = c.query.filter;
  switch (random.below(10)) {
    case 0:
      c.filter = "every third id";
      filter.of_point = [](const Candidate& point) { return point.point_id % 3 == 0; };
      break;
    case 1:
      c.filter = "no point";
      filter.of_point = [](const Candidate&) { return false; };
      break;
    case 2:
      c.filter = "the lower half in x";
      filter.of_position = [middle](const Candidate& point) { return point.position.x < middle; };
      break;
    case 3:
      c.filter = "distances above half a spacing";
      filter.of_point = [near](const Candidate& point) { return point.distance > 0.5 * near; };
      break;
    case 4:
      c.filter = "t above a spacing, not every third id";
      filter.of_point = [](const Candidate& point) { return point.point_id % 3 != 0; };
      filter.of_position = [near](const Candidate& point) { return point.t > near; };
      break;
    default:
      break;
  }
}

template <class Target, class Query, class MakeTarget>
std::vector<QueryCase<Target, Query>> cases_of(const PointCloud& cloud, std::size_t count, Random& random,
                                               const MakeTarget& make) {
  const Positions positions(cloud, random);
  std::vector<QueryCase<Target, Query>> cases;
  while (cases.size() < count) {
    QueryCase<Target, Query> next;
    next.query.k = some_k(random);
    make(positions, next);
    add_filter(next, positions, random);
    cases.push_back(std::move(next));
  }
  return cases;
}

std::string text(const glm::dvec3& v) {
  return fmt::format("({:a} {:a} {:a})", v.x, v.y, v.z);
}

const char* name_of(Measure measure) {
  return measure == Measure::t ? "t" : measure == Measure::entry ? "entry" : "distance";
}

std::string text_of_k(std::size_t k) {
  return k == k_all ? "all" : fmt::format("k {}", k);
}

}  // namespace

std::vector<FindRayCase> find_ray_cases(const PointCloud& cloud, std::size_t count, Random& random) {
  const std::vector<RayCase> rays = ray_cases(cloud, count, random);
  std::size_t next_ray = 0;
  return cases_of<Ray, RayQuery>(cloud, count, random, [&](const Positions&, FindRayCase& c) {
    const std::size_t k = c.query.k;
    c.target = rays[next_ray].ray;
    c.query = rays[next_ray++].query;
    c.query.k = k;
    if (random.below(3) == 0) c.query.measure = Measure::distance;
    if (c.query.measure != Measure::entry && random.below(3) == 0) {
      c.query.radius = k_unlimited_radius;
      c.query.entry_min = -std::numeric_limits<double>::infinity();
    }
  });
}

std::vector<ConeCase> cone_cases(const PointCloud& cloud, std::size_t count, Random& random) {
  const std::vector<RayCase> rays = ray_cases(cloud, count, random);
  std::size_t next_ray = 0;
  return cases_of<Cone, ConeQuery>(cloud, count, random, [&](const Positions&, ConeCase& c) {
    c.target.axis = rays[next_ray].ray;
    c.target.radius = random.below(2) ? 0.0 : rays[next_ray].query.radius;
    const double slopes[] = {0.0, 1e-9, 0.001, 0.1, 1.0, 1e3, 1e12};
    c.target.slope = slopes[random.below(std::size(slopes))];
    c.query.measure = some_measure(random, true);
    ++next_ray;
  });
}

std::vector<PathCase> path_cases(const PointCloud& cloud, std::size_t count, Random& random) {
  return cases_of<Path, PathQuery>(cloud, count, random, [&](const Positions& positions, PathCase& c) {
    std::vector<glm::dvec3> vertices{positions.anywhere(), positions.anywhere() + glm::dvec3(0, 0, 1e-3)};
    const std::size_t more = random.below(4) ? random.below(6) : random.below(80);
    const bool jagged = random.below(2) == 0;
    for (std::size_t i = 0; i < more; ++i) {
      vertices.push_back(jagged ? positions.anywhere()
                                : vertices.back() + positions.spacing() * random.in_cube());
      // There and back again, and the same vertex once more: ties between segments.
      if (random.below(4) == 0) vertices.push_back(vertices[vertices.size() - 2]);
      if (random.below(8) == 0) vertices.push_back(vertices.front() + glm::dvec3(0.0, 1e-3, 0.0));
    }
    c.target = make_path(vertices);
    const double length = c.target.vertex_t.back();
    if (random.below(3) == 0) c.target.t_min = random.between(-0.1, 1.0) * length;
    if (random.below(3) == 0) c.target.t_max = random.between(-0.1, 1.1) * length;
    if (random.below(3)) c.query.radius = positions.length();
    c.query.measure = some_measure(random, false);
  });
}

std::vector<RegionCase> region_cases(const PointCloud& cloud, std::size_t count, Random& random) {
  return cases_of<HalfSpaces, PointQuery>(
      cloud, count, random, [&](const Positions& positions, RegionCase& c) {
        const std::size_t planes = random.below(7);
        for (std::size_t i = 0; i < planes; ++i) {
          glm::dvec3 normal = random.direction();
          if (random.below(3) == 0) {
            normal = glm::dvec3(random.below(2) ? 0.0 : -0.0);
            normal[static_cast<int>(random.below(3))] = random.below(2) ? 1.0 : -1.0;
          }
          const glm::dvec3 on_plane = random.below(2) ? positions.point() : positions.anywhere();
          if (random.below(3) == 0) {
            for (const Plane& plane : make_slab(make_plane(on_plane, normal), positions.length()).planes)
              c.target.planes.push_back(plane);
          } else {
            c.target.planes.push_back(make_plane(on_plane, normal));
          }
        }
      });
}

std::vector<BoxCase> box_cases(const PointCloud& cloud, std::size_t count, Random& random) {
  const double infinity = std::numeric_limits<double>::infinity();
  return cases_of<Bounds, PointQuery>(cloud, count, random, [&](const Positions& positions, BoxCase& c) {
    c.target.grow(random.below(2) ? positions.point() : positions.anywhere());
    switch (random.below(5)) {
      case 0:  // flat, down to a single position
        break;
      case 1:
        c.target.grow(c.target.min + positions.length() * random.in_cube());
        break;
      case 2:
        c.target.max[static_cast<int>(random.below(3))] = infinity;
        c.target.min[static_cast<int>(random.below(3))] = -infinity;
        break;
      case 3:
        c.target = random.below(2) ? Bounds{} : Bounds{c.target.min, c.target.min - 1.0};
        break;
      default:
        c.target.grow(random.below(2) ? positions.point() : positions.anywhere());
    }
  });
}

std::vector<PointCase> point_cases(const PointCloud& cloud, std::size_t count, Random& random) {
  return cases_of<glm::dvec3, PointQuery>(cloud, count, random,
                                          [&](const Positions& positions, PointCase& c) {
                                            c.target = positions.anywhere();
                                            if (random.below(2)) c.query.radius = positions.length();
                                            // Exactly as far as a point.
                                            if (random.below(4) == 0)
                                              c.query.radius = distance(c.target, positions.point());
                                          });
}

std::string describe(const Ray& ray) {
  return fmt::format("ray from {} along {} t {:a} to {:a}", text(ray.origin), text(ray.direction), ray.t_min,
                     ray.t_max);
}

std::string describe(const Cone& cone) {
  return fmt::format("cone about {} radius {:a} slope {:a}", describe(cone.axis), cone.radius, cone.slope);
}

std::string describe(const Path& path) {
  std::string result = fmt::format("path t {:a} to {:a}", path.t_min, path.t_max);
  for (const glm::dvec3& vertex : path.vertices) result += text(vertex);
  return result;
}

std::string describe(const HalfSpaces& region) {
  std::string result = "region";
  for (const Plane& plane : region.planes) result += text(plane.point) + text(plane.normal);
  return result;
}

std::string describe(const Bounds& box) {
  return fmt::format("box {} to {}", text(box.min), text(box.max));
}

std::string describe(const glm::dvec3& point) {
  return fmt::format("point {}", text(point));
}

std::string describe(const RayQuery& query) {
  return fmt::format("radius {:a} by {} {} entry_min {:a}", query.radius, name_of(query.measure),
                     text_of_k(query.k), query.entry_min);
}

std::string describe(const ConeQuery& query) {
  return fmt::format("by {} {}", name_of(query.measure), text_of_k(query.k));
}

std::string describe(const PathQuery& query) {
  return fmt::format("radius {:a} by {} {}", query.radius, name_of(query.measure), text_of_k(query.k));
}

std::string describe(const PointQuery& query) {
  return fmt::format("radius {:a} {}", query.radius, text_of_k(query.k));
}

}  // namespace alidade::test
