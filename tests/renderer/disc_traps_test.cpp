// SPDX-License-Identifier: MIT
// Clouds without surfaces, and cameras and radii that do not fit the cloud: images have finite colours, and
// layers have the values that image/film.h states.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>

#include "mesh/triangle_tree.h"
#include "tests/renderer/mixed_scene.h"

namespace alidade {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

using test::mixed_cloud;
using test::mixed_scene;
using test::Random;

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr int k_width = 24, k_height = 16;

struct Trap {
  std::string name;
  PointCloud cloud;
  std::vector<Camera> cameras;
};

Camera view(const glm::dvec3& eye, const glm::dvec3& target) {
  return pinhole_from_fov(k_width, k_height, 60.0, look_at(eye, target));
}

/// From above and along each axis, from outside and from the middle.
std::vector<Camera> views_of(const PointCloud& cloud) {
  Bounds bounds;
  for (std::size_t id = 0; id < cloud.size(); ++id) bounds.grow(cloud.world(id));
  if (bounds.empty()) return {view({0, -3, 1}, {0, 0, 0})};
  const glm::dvec3 middle = 0.5 * (bounds.min + bounds.max);
  const double size = std::fmax(glm::length(bounds.size()), 1.0);
  return {view(middle + size * glm::dvec3(-0.7, -0.8, 0.6), middle),
          view(middle - glm::dvec3(size, 0, 0), middle), view(middle, middle + glm::dvec3(0, size, 0)),
          panorama_camera(cloud.world(cloud.size() / 2), k_width, k_height)};
}

Trap trap(const std::string& name, const std::vector<glm::dvec3>& points,
          const Lattice& lattice = test::k_millimetres) {
  Trap result{name, test::make_cloud(points, lattice), {}};
  result.cameras = views_of(result.cloud);
  return result;
}

std::vector<glm::dvec3> points(int count, const std::function<glm::dvec3(int)>& position) {
  std::vector<glm::dvec3> result;
  for (int i = 0; i < count; ++i) result.push_back(position(i));
  return result;
}

std::vector<Trap> traps() {
  Random random("disc traps");
  std::vector<Trap> all;
  all.push_back(trap("one point", {{0, 0, 0}}));
  all.push_back(trap("three points", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  all.push_back(trap("nine points of a plane", points(9, [](int i) { return glm::dvec3(i % 3, i / 3, 0); })));
  all.push_back(trap("collinear points", points(200, [](int i) { return glm::dvec3(0.01 * i, 0, 0); })));
  all.push_back(trap("collinear points far apart",
                     points(12, [](int i) { return glm::dvec3(0, 0, std::pow(3.0, i)); })));
  all.push_back(trap("coincident points", points(5000, [](int) { return glm::dvec3(1, 2, 3); })));
  all.push_back(
      trap("two heaps of coincident points", points(5000, [](int i) { return glm::dvec3(i % 2, 2, 3); })));
  all.push_back(trap("coincident points on a plane",
                     points(5000, [](int i) { return glm::dvec3(i % 10, i / 10 % 10, 0); })));
  all.push_back(trap("a point per kilometre",
                     points(100, [](int i) { return 1000.0 * glm::dvec3(i % 10, i / 10, 0); })));
  // One square metre has a thousand times the points of those around.
  all.push_back(trap("densities of 1 to 1000", points(4400, [&](int i) {
                       const double side = i < 400 ? 10.0 : 0.5;
                       return glm::dvec3(side * random.in_cube().x, side * random.in_cube().y,
                                         1e-3 * random.in_cube().z);
                     })));
  all.push_back(trap("a wall around the camera",
                     points(4000, [&](int) { return glm::dvec3(4, 1, 4) * random.in_cube(); })));
  Trap sheet = trap("a camera on the sheet", points(4000, [&](int) {
                      return glm::dvec3(4.0 * random.in_cube().x, 4.0 * random.in_cube().y, 0.0);
                    }));
  sheet.cameras.push_back(view({0, 0, 0}, {1, 0, 0}));
  sheet.cameras.push_back(view(sheet.cloud.world(7), {0, 0, -1}));
  sheet.cameras.push_back(view({-100, 0, 0}, {0, 0, 0}));
  all.push_back(sheet);
  for (const test::PointFamily& family : test::point_families())
    all.push_back({family.name, family.cloud, views_of(family.cloud)});
  return all;
}

bool is_finite(const Rgb& color) {
  return std::isfinite(color.r) && std::isfinite(color.g) && std::isfinite(color.b);
}

/// Whether the layers hold what image/film.h states.
void expect_sane(const Film& film) {
  for (std::size_t pixel = 0; pixel < film.count(); ++pixel) {
    const bool sees = film.id[pixel] != 0;
    ASSERT_TRUE(is_finite(film.color[pixel]) && is_finite(film.variance[pixel]));
    ASSERT_TRUE(is_finite(film.albedo[pixel]));
    ASSERT_GE(std::min({film.color[pixel].r, film.color[pixel].g, film.color[pixel].b}), 0.0f);
    ASSERT_TRUE(film.alpha[pixel] >= 0.0f && film.alpha[pixel] <= 1.0f);
    ASSERT_TRUE(film.coverage[pixel] >= 0.0f && film.coverage[pixel] <= 1.0f);
    ASSERT_EQ(std::isfinite(film.depth[pixel]), sees);
    ASSERT_TRUE(sees ? film.distance[pixel] >= 0.0f : film.distance[pixel] == k_infinity)
        << film.distance[pixel];
    const bool is_object = film.id[pixel] > 0xffff0000u;
    ASSERT_EQ(film.support[pixel] > 0, sees && !is_object);
    ASSERT_GE(film.depth_sigma[pixel], 0.0f);  // or infinite
    ASSERT_NEAR(glm::length(film.normal[pixel]), sees ? 1.0 : 0.0, 1e-5);
    ASSERT_TRUE(std::isfinite(glm::dot(film.position[pixel], film.position[pixel])));
  }
}

class DiscTraps : public ::testing::TestWithParam<PointShape> {};

TEST_P(DiscTraps, images_of_hostile_clouds_are_finite) {
  for (const Trap& trap : traps()) {
    SCOPED_TRACE(trap.name);
    LoadedCloud cloud;
    cloud.octree = build(trap.cloud);
    cloud.colors.assign(trap.cloud.size(), Color16(40000));
    Scene scene = test::dark_scene({}, 2, 4);
    scene.sky = ConstantSky{.radiance = Rgb(1.0f)};
    scene.sun.emplace();
    scene.cloud.emplace().shape = GetParam();
    choose_radius(*scene.cloud, cloud);
    EXPECT_TRUE(std::isfinite(cloud.radius) && std::isfinite(cloud.lone_radius));
    for (const Camera& camera : trap.cameras) {
      scene.camera = camera;
      expect_sane(render(scene, &cloud));
    }
  }
}

struct MeshTrap {
  std::string name, text;
  std::string problem{};  ///< empty: it gives an image
};

const MeshTrap k_mesh_traps[] = {
    {"nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "line 2: vertex 2 is not finite"},
    {"infinite.obj", "v 0 0 0\nv 1 inf 0\nv 0 1 0\nf 1 2 3\n", "line 2: vertex 2 is not finite"},
    {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
     "line 4: a face names a vertex that does not exist"},
    {"lines.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 1\n",
     "no triangles; expected faces with an area"},
    {"nan.ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
     "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
     "vertex 1 is not finite"},
    {"index.ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
     "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n",
     "a face names a vertex that does not exist"},
    {"a_line_beside_a_triangle.obj", "v -2 0 -2\nv 2 0 -2\nv 0 0 2\nv 4 0 -2\nf 1 2 4\nf 1 2 3\n"},
    // Squares of their sides leave the range of doubles, and their corners coincide in the coordinates of a
    // larger mesh.
    {"needles.obj", "v -2 0 -2\nv 2 0 -2\nv 0 1e-200 -2\nv 0 0 2\nf 1 2 3\nf 3 2 4\nf 1 3 4\n"},
    {"a_speck_far_away.obj",
     "v 1e11 0 0\nv 1e11 1e-9 0\nv 1e11 0 1e-9\nv -2 0 -2\nv 2 0 -2\nv 0 0 2\nf 1 2 3\nf 4 5 6\n"},
};

TEST_P(DiscTraps, hostile_meshes_among_discs_are_errors_or_give_a_finite_image) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("alidade_traps_" + test::shape_name(GetParam()));
  std::filesystem::create_directories(folder);
  const LoadedCloud cloud = mixed_cloud(GetParam());
  for (const MeshTrap& trap : k_mesh_traps) {
    SCOPED_TRACE(trap.name);
    std::ofstream(folder / trap.name) << trap.text;
    Model model;
    std::string problem;
    try {
      model.surfaces = std::make_shared<TriangleTree>(read_mesh(folder / trap.name, {}));
    } catch (const Error& error) {
      problem = error.what();
    }
    EXPECT_EQ(problem.empty(), trap.problem.empty()) << problem;
    EXPECT_NE(problem.find(trap.problem), std::string::npos) << problem;
    if (!problem.empty()) continue;
    Scene scene = mixed_scene(GetParam());
    scene.camera = view({0.0, -4.0, 0.5}, {0.0, 0.0, 0.5});
    scene.objects = {model};
    const Film film = render(scene, &cloud);
    expect_sane(film);
    EXPECT_GT(std::ranges::count(film.id, 0xffffffffu), 5) << "the mesh is seen";
  }
  std::filesystem::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(, DiscTraps, ::testing::Values(PointShape::disc, PointShape::blend),
                         [](const auto& shape) { return test::shape_name(shape.param); });

}  // namespace
}  // namespace alidade
