// SPDX-License-Identifier: MIT
#include "mesh/triangle_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "tests/support/triangle_oracle.h"

namespace alidade::test {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// Numbers from -1 to 1.
class Numbers {
 public:
  double next() { return static_cast<double>(engine_()) / 2147483648.0 - 1.0; }
  glm::dvec3 vector() { return {next(), next(), next()}; }

 private:
  std::mt19937 engine_{7};
};

/// [0, 4] x [0, 2] x [0, 3] m, moved.
TriangleMesh box_mesh(const glm::dvec3& offset = glm::dvec3(0.0)) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.vertices.push_back(offset + glm::dvec3(corner & 1 ? 4 : 0, corner & 2 ? 2 : 0, corner & 4 ? 3 : 0));
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TriangleMesh soup(int count, double size, const glm::dvec3& offset) {
  Numbers numbers;
  TriangleMesh mesh;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 middle = offset + 10.0 * numbers.vector();
    for (int corner = 0; corner < 3; ++corner) mesh.vertices.push_back(middle + size * numbers.vector());
    const auto first = static_cast<std::uint32_t>(3 * i);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

/// A level grid, in which most rays meet corners and sides.
TriangleMesh grid(std::uint32_t side) {
  TriangleMesh mesh;
  for (std::uint32_t y = 0; y <= side; ++y)
    for (std::uint32_t x = 0; x <= side; ++x) mesh.vertices.emplace_back(x, y, 0.0);
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::uint32_t a = y * (side + 1) + x, b = a + side + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
  return mesh;
}

void expect_answers_of_brute_force(const TriangleMesh& mesh, const glm::dvec3& middle, int rays) {
  const TriangleTree tree(mesh);
  Numbers numbers;
  int hits = 0;
  for (int i = 0; i < rays; ++i) {
    glm::dvec3 origin = middle + 12.0 * numbers.vector(), direction = numbers.vector();
    // Whole numbers meet corners, and level rays run along boxes.
    if (i % 3 == 1) origin = glm::round(origin), direction = glm::round(2.0 * direction);
    if (i % 3 == 2) direction[i % 2] = 0.0;
    if (direction == glm::dvec3(0.0)) direction.z = -1.0;
    Ray ray = make_ray(origin, direction);
    if (i % 4 != 0) ray.t_min = 0.0;
    if (i % 5 == 0) ray.t_max = 5.0 + 5.0 * numbers.next();
    const auto expected = closest_by_brute_force(mesh, ray);
    EXPECT_EQ(tree.closest(ray), expected) << i;
    EXPECT_EQ(tree.occluded(ray), expected.has_value()) << i;
    if (!expected) continue;
    ++hits;
    // The interval is closed, and behind it lies nothing nearer.
    ray.t_max = expected->t;
    EXPECT_EQ(tree.closest(ray), expected) << i;
    ray.t_max = std::nextafter(expected->t, -k_infinity);
    EXPECT_EQ(tree.closest(ray), closest_by_brute_force(mesh, ray)) << i;
  }
  EXPECT_GT(hits, 20);
}

TEST(TriangleTreeTest, a_box_is_met_where_it_is_on_paper) {
  for (const glm::dvec3 offset : {glm::dvec3(0.0), glm::dvec3(690000.25, 5325000.5, 512.125)}) {
    const TriangleTree tree(box_mesh(offset));
    const auto hit = [&](const glm::dvec3& from, const glm::dvec3& direction) {
      return tree.closest(make_ray(offset + from, direction, 0.0));
    };
    // From 10 m above the roof, which is at 3 m.
    const auto roof = hit({1, 1, 13}, {0, 0, -1});
    ASSERT_TRUE(roof);
    EXPECT_NEAR(roof->t, 10.0, 1e-8);
    EXPECT_EQ(roof->normal, glm::dvec3(0, 0, 1));
    EXPECT_TRUE(roof->triangle == 2 || roof->triangle == 3);
    // Down by 3 on 4 along x: from (-4, 1, 4) to the wall x = 0 at z = 1, 5 m away.
    const auto wall = hit({-4, 1, 4}, {4, 0, -3});
    ASSERT_TRUE(wall);
    EXPECT_NEAR(wall->t, 5.0, 1e-8);
    EXPECT_EQ(wall->normal, glm::dvec3(-1, 0, 0));
    // From within, the side turns towards the ray.
    const auto inner = hit({1, 1, 1}, {1, 0, 0});
    ASSERT_TRUE(inner);
    EXPECT_NEAR(inner->t, 3.0, 1e-8);
    EXPECT_EQ(inner->normal, glm::dvec3(-1, 0, 0));
    EXPECT_FALSE(hit({1, 1, 13}, {0, 0, 1}));
    EXPECT_FALSE(hit({-4, 1, 4}, {4, 0, 3}));
  }
}

TEST(TriangleTreeTest, answers_are_those_of_a_loop_over_all_triangles) {
  expect_answers_of_brute_force(box_mesh(), {2, 1, 1.5}, 3000);
  expect_answers_of_brute_force(soup(1, 9.0, glm::dvec3(0.0)), glm::dvec3(0.0), 3000);
  expect_answers_of_brute_force(soup(1003, 1.0, glm::dvec3(0.0)), glm::dvec3(0.0), 1500);
  expect_answers_of_brute_force(soup(2000, 1.0, {5e6, 5e6, 1e3}), {5e6, 5e6, 1e3}, 1000);
  expect_answers_of_brute_force(grid(20), {10, 10, 0}, 2000);
}

TEST(TriangleTreeTest, triangles_that_do_not_count_are_left_out) {
  const TriangleMesh mesh = soup(1003, 1.0, {5e5, 5e6, 1e3});
  const TriangleTree tree(mesh);
  const TriangleFilter counts = [](const TriangleHit& hit) {
    return hit.triangle % 3 == 0 && hit.normal.z > 0.2 && hit.t > -5.0;
  };
  Numbers numbers;
  int hits = 0, others = 0;
  for (int i = 0; i < 1000; ++i) {
    const Ray ray = make_ray(glm::dvec3(5e5, 5e6, 1e3) + 12.0 * numbers.vector(), numbers.vector());
    const auto expected = closest_by_brute_force(mesh, ray, counts);
    EXPECT_EQ(tree.closest(ray, counts), expected) << i;
    EXPECT_EQ(tree.occluded(ray, counts), expected.has_value()) << i;
    if (expected) EXPECT_TRUE(counts(*expected));
    hits += expected ? 1 : 0;
    others += expected != tree.closest(ray) ? 1 : 0;
  }
  EXPECT_GT(hits, 30);
  EXPECT_GT(others, 30);
}

TEST(TriangleTreeTest, progress_ends_with_all_triangles) {
  for (const int count : {1, 1000, 4101, 9000}) {
    std::uint64_t last = 0;
    const TriangleTree tree(soup(count, 1.0, glm::dvec3(0.0)), [&](std::uint64_t done, std::uint64_t total) {
      EXPECT_EQ(total, static_cast<std::uint64_t>(count));
      last = done;
      return true;
    });
    EXPECT_EQ(last, static_cast<std::uint64_t>(count));
  }
}

TEST(TriangleTreeTest, any_finds_what_a_loop_over_all_triangles_finds_and_opens_few_boxes) {
  const glm::dvec3 offset(5e5, 5e6, 1e3);
  const TriangleMesh mesh = soup(1003, 0.5, offset);
  const TriangleTree tree(mesh);
  Numbers numbers;
  int found = 0, opened = 0;
  for (int i = 0; i < 500; ++i) {
    // Triangles that lie within a ball.
    const glm::dvec3 middle = offset + 11.0 * numbers.vector();
    const auto in_ball = [&](const std::array<glm::dvec3, 3>& corners) {
      return std::ranges::all_of(
          corners, [&](const glm::dvec3& corner) { return glm::distance(corner, middle) < 1.0; });
    };
    const bool expected = std::ranges::any_of(mesh.triangles, [&](const TriangleMesh::Triangle& triangle) {
      return in_ball({mesh.vertices[triangle[0]], mesh.vertices[triangle[1]], mesh.vertices[triangle[2]]});
    });
    const Bounds ball{middle - 1.0, middle + 1.0};
    EXPECT_EQ(tree.any(
                  [&](const Bounds& box) {
                    ++opened;
                    return meet(box, ball);
                  },
                  in_ball),
              expected)
        << i;
    found += expected ? 1 : 0;
  }
  EXPECT_GT(found, 50);
  EXPECT_LT(found, 450);
  EXPECT_LT(opened, 500 * 100);
}

TEST(TriangleTreeTest, of_triangles_at_the_same_place_the_first_one_is_met) {
  TriangleMesh mesh = soup(1, 9.0, glm::dvec3(0.0));
  mesh.triangles.resize(1000, mesh.triangles[0]);
  const glm::dvec3 middle = (mesh.vertices[0] + mesh.vertices[1] + mesh.vertices[2]) / 3.0;
  const TriangleTree tree(mesh);
  const auto hit = tree.closest(make_ray(middle + glm::dvec3(0.0, 0.0, 20.0), {0, 0, -1}));
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->triangle, 0u);
}

TEST(TriangleTreeTest, rays_do_not_slip_between_triangles) {
  const TriangleTree ground(grid(50));
  Numbers numbers;
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 target(std::round(25.0 + 23.0 * numbers.next()), 25.0 + 24.0 * numbers.next(), 0.0);
    const glm::dvec3 origin = target + glm::dvec3(30.0 * numbers.next(), 30.0 * numbers.next(), 7.0);
    EXPECT_TRUE(ground.occluded(make_ray(origin, target - origin, 0.0))) << i;
  }
  // Nor out of a box, through its sides and corners.
  const TriangleTree box(box_mesh({5e6, 5e6, 0}));
  const glm::dvec3 eye(5e6 + 1.3, 5e6 + 0.7, 1.1);
  for (int i = 0; i < 20000; ++i) {
    glm::dvec3 corner(5e6 + (i & 1 ? 4 : 0), 5e6 + (i & 2 ? 2 : 0), i & 4 ? 3 : 0);
    if (i & 8) corner.z = 1.5 + 1.5 * numbers.next();
    EXPECT_TRUE(box.occluded(make_ray(eye, corner - eye, 0.0))) << i;
  }
}

TEST(TriangleTreeTest, rays_along_an_axis_meet_what_is_in_their_way_and_nothing_beside) {
  // Squares in the planes x = 0, y = 0, z = 0, whose ends are known: a ray along an axis crosses one of them.
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    TriangleMesh mesh;
    for (int corner = 0; corner < 4; ++corner) {
      glm::dvec3 vertex(0.0);
      vertex[u] = corner & 1 ? 4.0 : -4.0;
      vertex[v] = corner & 2 ? 4.0 : -4.0;
      mesh.vertices.push_back(vertex);
    }
    mesh.triangles = {{0, 1, 3}, {0, 3, 2}};
    const TriangleTree tree(mesh);
    for (int i = -5; i <= 5; ++i) {
      for (int j = -5; j <= 5; ++j) {
        for (const double sign : {1.0, -1.0}) {
          glm::dvec3 origin(0.0), direction(0.0);
          origin[u] = i, origin[v] = j, origin[axis] = -3.0 * sign;
          direction[axis] = sign;
          const auto hit = tree.closest(make_ray(origin, direction, 0.0));
          ASSERT_EQ(hit.has_value(), std::abs(i) <= 4 && std::abs(j) <= 4) << axis << " " << i << " " << j;
          if (hit) EXPECT_EQ(hit->t, 3.0) << axis << " " << i << " " << j;
        }
      }
    }
  }
}

TEST(TriangleTreeTest, a_ray_in_the_plane_of_a_gable_passes_by_beside_it) {
  // Seen along the ray the gable is a line that leads to it: rounding decides on which side of its edges the
  // ray passes.
  Numbers numbers;
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 along = glm::normalize(glm::dvec3(numbers.next(), numbers.next(), 0.0));
    const double begin = 1.5 + numbers.next(), middle = begin + 1.5 + numbers.next();
    TriangleMesh mesh;
    mesh.vertices = {begin * along, (middle + 1.0) * along, middle * along + glm::dvec3(0, 0, 3)};
    mesh.triangles = {{0, 1, 2}};
    const TriangleTree tree(mesh);
    EXPECT_FALSE(tree.occluded(make_ray({0, 0, 10}, {0, 0, -1}))) << i;
    EXPECT_FALSE(closest_by_brute_force(mesh, make_ray({0, 0, -10}, {0, 0, 1}))) << i;
  }
}

TEST(TriangleMeshTest, other_corners_triangles_or_colours_have_another_checksum) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 3}, {4, 0, 3}, {4, 4, 3}, {0, 4, 3}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_colors = {Rgb(0.5f, 0.25f, 0.0f), Rgb(0.5f, 0.25f, 0.0f)};
  EXPECT_EQ(checksum(mesh), checksum(TriangleMesh(mesh)));
  TriangleMesh moved = mesh, turned = mesh, painted = mesh;
  moved.vertices[3].x = 1.0;
  turned.triangles[1] = {2, 3, 0};
  painted.triangle_colors[1].b = 0.5f;
  for (const TriangleMesh& other : {moved, turned, painted}) EXPECT_NE(checksum(mesh), checksum(other));
}

TEST(TriangleTreeTest, colours_of_vertices_are_blended_and_those_of_triangles_go_first) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  mesh.triangles = {{0, 1, 2}};
  const Ray ray = make_ray({1, 2, 9}, {0, 0, -1});
  const TriangleTree plain(mesh);
  EXPECT_FALSE(plain.color(*plain.closest(ray)));
  mesh.vertex_colors = {Rgb(1, 0, 0), Rgb(0, 1, 0), Rgb(0, 0, 1)};
  const TriangleTree blended(mesh);
  EXPECT_EQ(blended.color(*blended.closest(ray)), Rgb(0.25f, 0.25f, 0.5f));
  mesh.triangle_colors = {Rgb(0.5f)};
  const TriangleTree even(mesh);
  EXPECT_EQ(even.color(*even.closest(ray)), Rgb(0.5f));
}

}  // namespace
}  // namespace alidade::test
