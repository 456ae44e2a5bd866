// SPDX-License-Identifier: MIT
#include "tests/support/point_families.h"

#include <cmath>

namespace alidade::test {
namespace {

const glm::dvec3 k_utm{690000.0, 5325000.0, 600.0};
constexpr double k_pi = 3.14159265358979323846;

template <class Draw>
PointFamily family(const std::string& name, std::size_t count, const Lattice& lattice, const Draw& draw) {
  Random random(name);
  std::vector<glm::dvec3> positions;
  for (std::size_t i = 0; i < count; ++i) positions.push_back(draw(random, i));
  return {name, make_cloud(positions, lattice)};
}

glm::dvec3 on_sphere(Random& random) {
  const glm::dvec3 v = random.direction();
  return v / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

/// A scanned street in small: ground, a wall, a few poles, density falling from a scanner.
glm::dvec3 street(Random& random, std::size_t i) {
  const double range = 2.0 * std::pow(20.0, random.unit()), angle = random.between(0, 2 * k_pi);
  const glm::dvec3 ground{range * std::cos(angle), range * std::sin(angle), 0.05 * random.unit()};
  if (i % 3 == 0) return k_utm + glm::dvec3(ground.x, 15.0 + 0.01 * random.unit(), random.between(0, 8));
  if (i % 7 == 0)
    return k_utm + glm::dvec3(5.0 + 0.1 * std::cos(angle), 0.1 * std::sin(angle), random.between(0, 5));
  return k_utm + ground;
}

}  // namespace

PointCloud make_cloud(const std::vector<glm::dvec3>& positions, const Lattice& lattice) {
  PointCloud cloud;
  cloud.lattice = lattice;
  for (const glm::dvec3& position : positions)
    cloud.positions.push_back(to_lattice(lattice, position).value());
  return cloud;
}

std::vector<PointFamily> point_families() {
  const Lattice millimetre{glm::dvec3(0.001), glm::dvec3(0.0)};
  const Lattice utm{glm::dvec3(0.001), k_utm};
  const Lattice utm_zero{glm::dvec3(0.01), glm::dvec3(0.0)};
  std::vector<PointFamily> families;
  families.push_back(family("no_point", 0, millimetre, [](Random&, std::size_t) { return glm::dvec3(0); }));
  families.push_back(family("one_point", 1, utm, [](Random&, std::size_t) { return k_utm + 1.0; }));
  families.push_back(
      family("two_points", 2, millimetre, [](Random&, std::size_t i) { return glm::dvec3(2.0 * i); }));
  families.push_back(
      family("uniform", 3000, millimetre, [](Random& r, std::size_t) { return 10.0 * r.in_cube(); }));
  families.push_back(
      family("uniform_utm", 3000, utm, [](Random& r, std::size_t) { return k_utm + 10.0 * r.in_cube(); }));
  families.push_back(family("utm_without_offset", 2000, utm_zero,
                            [](Random& r, std::size_t) { return k_utm + 50.0 * r.in_cube(); }));
  families.push_back(family("grid", 4096, utm, [](Random&, std::size_t i) {
    return k_utm + 0.25 * glm::dvec3(i % 16, i / 16 % 16, i / 256);
  }));
  families.push_back(
      family("sphere_shell", 3000, utm, [](Random& r, std::size_t) { return k_utm + 5.0 * on_sphere(r); }));
  families.push_back(
      family("line", 2000, utm, [](Random& r, std::size_t) { return k_utm + 20.0 * r.unit(); }));
  families.push_back(family("axis_line", 2000, utm, [](Random& r, std::size_t) {
    return k_utm + glm::dvec3(20.0 * r.unit(), 0, 0);
  }));
  families.push_back(family("flat", 3000, utm, [](Random& r, std::size_t) {
    return k_utm + glm::dvec3(20.0 * r.unit(), 20.0 * r.unit(), 0);
  }));
  families.push_back(family("all_equal", 1500, utm, [](Random&, std::size_t) { return k_utm + 0.125; }));
  families.push_back(family("seven_places", 2000, utm, [](Random& r, std::size_t) {
    return k_utm + 0.5 * static_cast<double>(r.below(7));
  }));
  families.push_back(family("two_far_clusters", 2000, millimetre, [](Random& r, std::size_t i) {
    return glm::dvec3(i % 2 ? 0.0 : 2000.0) + r.in_cube();
  }));
  families.push_back(family("outlier", 1500, millimetre, [](Random& r, std::size_t i) {
    return i == 700 ? glm::dvec3(2e6, -2e6, 1e5) : r.in_cube();
  }));
  families.push_back(
      family("huge_offset_small_spread", 2000, {glm::dvec3(1e-4), glm::dvec3(1e7, -2e7, 3e6)},
             [](Random& r, std::size_t) { return glm::dvec3(1e7, -2e7, 3e6) + 0.2 * r.in_cube(); }));
  families.push_back(family("anisotropic", 2000, {{0.01, 0.001, 0.1}, k_utm}, [](Random& r, std::size_t) {
    return k_utm + glm::dvec3(100.0, 10.0, 500.0) * r.in_cube();
  }));
  families.push_back(
      family("degrees", 2000, {{1e-7, 1e-7, 0.01}, {11.5, 48.1, 500.0}}, [](Random& r, std::size_t) {
        return glm::dvec3(11.5, 48.1, 500.0) + glm::dvec3(1e-3, 1e-3, 20.0) * r.in_cube();
      }));
  families.push_back(family("fine_lattice", 2000, {glm::dvec3(1e-8), k_utm},
                            [](Random& r, std::size_t) { return k_utm + 10.0 * r.in_cube(); }));
  families.push_back(family("whole_lattice", 2000, {glm::dvec3(0.001), glm::dvec3(0)},
                            [](Random& r, std::size_t) { return 2147483.0 * r.in_cube(); }));
  families.push_back(family("coarse_lattice", 2000, {glm::dvec3(1.0), glm::dvec3(0)},
                            [](Random& r, std::size_t) { return 20.0 * r.in_cube(); }));
  families.push_back(family("far_zeros", 6000, utm_zero, [](Random& r, std::size_t i) {
    return i % 2 ? glm::dvec3(0.0) : street(r, i / 2);
  }));
  families.push_back(family("street", 6000, utm, street));
  return families;
}

}  // namespace alidade::test
