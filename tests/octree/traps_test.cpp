// SPDX-License-Identifier: MIT
// Errors that other programs for rays and points have shipped, as their issue threads report them.
#include <sys/mman.h>

#include "octree/distance.h"
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

const Lattice k_millimetre{glm::dvec3(0.001), glm::dvec3(0)};

class Trap : public ::testing::TestWithParam<InstructionSet> {
 protected:
  static Octree build_here(const PointCloud& cloud) {
    BuildOptions options;
    options.instruction_set = GetParam();
    return build(cloud, options);
  }
};

INSTANTIATE_TEST_SUITE_P(, Trap, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

// embree 230, 320
TEST_P(Trap, a_hit_is_not_missed_when_the_origin_is_closer_than_radius_and_direction_length) {
  const PointCloud cloud = make_cloud({{0, 0, 0}}, k_millimetre);
  const Octree octree = build_here(cloud);
  const double radius = 1.0;
  for (const double back : {0.0, 1e-9, 0.5, 0.999, 1.0, 1.001, 1.5, 1.999, 2.0, 2.001}) {
    for (const double length : {1e-6, 1.0, 2.5, 1e6}) {
      const Ray ray = make_ray({-back, 0.25, 0}, glm::dvec3(length, 0, 0), 0.0);
      const std::optional<Hit> hit = closest(octree, ray, {.radius = radius});
      ASSERT_TRUE(hit) << back << " " << length;
      EXPECT_EQ(hit->t, back);
      EXPECT_EQ(hit->entry, back - std::sqrt(1.0 - 0.0625));
      EXPECT_TRUE(occluded(octree, ray, {.radius = radius}));
    }
  }
}

// embree 381
TEST_P(Trap, the_back_of_a_sphere_is_not_hit) {
  const Octree octree = build_here(make_cloud({{0, 0, 0}}, k_millimetre));
  // From inside, before and behind the centre: there is no second hit at the exit.
  const RayQuery entered{.radius = 1.0, .entry_min = 0.0};
  EXPECT_FALSE(closest(octree, make_ray({-0.5, 0, 0}, {1, 0, 0}, 0.0), entered));
  EXPECT_FALSE(closest(octree, make_ray({0.5, 0, 0}, {1, 0, 0}, 0.0), entered));
  EXPECT_FALSE(occluded(octree, make_ray({0.5, 0, 0}, {1, 0, 0}, 0.0), {.radius = 1.0}));
  // From outside it is the front.
  EXPECT_EQ(closest(octree, make_ray({-3, 0, 0}, {1, 0, 0}, 0.0), entered)->entry, 2.0);
}

// kaolin 490, caramel 10
TEST_P(Trap, a_ray_that_starts_inside_the_root_or_inside_a_node_finds_what_is_ahead) {
  Random random("inside");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 5000; ++i) positions.push_back(10.0 * random.in_cube());
  const PointCloud cloud = make_cloud(positions, k_millimetre);
  const Octree octree = build_here(cloud);
  for (int i = 0; i < 500; ++i) {
    const Ray ray = make_ray(i % 2 ? cloud.world(random.below(cloud.size())) : 9.0 * random.in_cube(),
                             random.direction(), 0.0);
    for (const double radius : {0.0, 0.1, 1.0}) {
      const RayQuery query{.radius = radius, .measure = Measure::t};
      ASSERT_TRUE(same_hits(closest(octree, ray, query), brute_force::closest(cloud, ray, query)));
      ASSERT_TRUE(same_hits(find(octree, ray, query), brute_force::find(cloud, ray, query)));
    }
  }
}

// fvdb-core 72, pyoctree 43
TEST_P(Trap, vertical_and_axis_parallel_rays_lose_nothing) {
  std::vector<glm::dvec3> positions;
  for (int x = 0; x < 12; ++x)
    for (int y = 0; y < 12; ++y)
      for (int z = 0; z < 12; ++z) positions.push_back({x, y, z});
  const PointCloud cloud = make_cloud(positions, k_millimetre);
  const Octree octree = build_here(cloud);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      for (const double zero : {0.0, -0.0}) {
        for (int i = 0; i < 144; ++i) {
          glm::dvec3 direction(zero), origin(i % 12);
          direction[axis] = sign;
          origin[(axis + 1) % 3] = i / 12;
          origin[axis] = sign < 0 ? 100.0 : -100.0;
          const Ray ray = make_ray(origin, direction, 0.0);
          ASSERT_EQ(count(octree, ray, {.radius = 0.0}), 12u);
          ASSERT_TRUE(same_hits(closest(octree, ray, {.radius = 0.0}),
                                brute_force::closest(cloud, ray, {.radius = 0.0})));
          ASSERT_TRUE(occluded(octree, ray, {.radius = 0.0}));
        }
      }
    }
  }
}

// ospray 207
TEST_P(Trap, coordinates_beyond_32_bit_byte_offsets_are_read_where_they_are) {
  // A small octree whose only leaf begins at storage index 1.5 billion, 9 GB into its coordinates. Only the
  // leaf's own page is ever touched.
  const PointCloud cloud = three_points();
  const Octree small = build_here(cloud);
  ASSERT_EQ(small.view().node_count, 1u);
  const std::uint32_t first = 1500000000u;
  const std::size_t bytes =
      (std::size_t{3} * (first + small.size()) + k_coordinate_padding) * sizeof(std::uint16_t);
  void* const memory =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) GTEST_SKIP() << "no address space for " << bytes << " bytes here";
  auto* const coordinates = static_cast<std::uint16_t*>(memory);
  std::copy_n(small.view().coordinates, 3 * small.size(), coordinates + std::size_t{3} * first);
  Node node = small.view().nodes[0];
  node.first_point += first;
  TreeView view = small.view();
  view.nodes = &node;
  view.coordinates = coordinates;
  view.ids = nullptr;
  view.point_count = first + 3;
  const Octree octree(view, nullptr, GetParam());
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  std::vector<Hit> expected = find(small, ray, {.radius = 1.0});
  const std::vector<Hit> hits = find(octree, ray, {.radius = 1.0});
  ASSERT_EQ(hits.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GE(hits[i].point_id, first);
    EXPECT_EQ(hits[i].position, expected[i].position);
  }
  EXPECT_EQ(closest(octree, ray, {.radius = 1.0})->position, expected[0].position);
  EXPECT_EQ(find(octree, glm::dvec3(19, 0, 0), {.k = 1})[0].position, glm::dvec3(20, 0, 0));
  munmap(memory, bytes);
}

// lidar_slam_ros2 346: bins that hide neighbours
TEST_P(Trap, a_point_is_found_beside_a_nearer_one_at_almost_the_same_position_in_view) {
  const PointCloud cloud = make_cloud({{10, 0, 0}, {10.001, 0.001, 0}, {10.002, 0, 0}}, k_millimetre);
  const Octree octree = build_here(cloud);
  EXPECT_EQ(ids_of(find(octree, make_ray({0, 0, 0}, {1, 0, 0}, 0.0), {.radius = 0.01})), (Ids{0, 1, 2}));
  for (std::size_t id = 0; id < 3; ++id) {
    const Ray ray = make_ray({0, 0, 0}, cloud.world(id), 0.0);
    EXPECT_EQ(count(octree, ray, {.radius = 1e-9}), id == 1 ? 1u : 2u) << id;
  }
}

// pylidar-tls-canopy 8: occlusion counted in a voxel's own voxel
TEST_P(Trap, a_point_does_not_hide_itself) {
  const PointCloud cloud = make_cloud({{10, 0, 0}, {10.03, 0, 0}, {30, 5, 0}}, k_millimetre);
  const Octree octree = build_here(cloud);
  const glm::dvec3 eye(0, 0, 0);
  const auto is_seen = [&](std::uint64_t id) {
    const double way = distance(eye, cloud.world(id));
    RayQuery query{.radius = 0.05, .measure = Measure::t};
    query.filter = [id](const Candidate& point) { return point.point_id != id; };
    return !occluded(octree, make_ray(eye, cloud.world(id), 0.0, way), query);
  };
  EXPECT_TRUE(is_seen(0));
  EXPECT_FALSE(is_seen(1));
  EXPECT_TRUE(is_seen(2));
}

// Coordinates as maps have them, embree 45: float32 resolves half metres there.
TEST_P(Trap, millimetres_count_at_utm_coordinates) {
  const glm::dvec3 utm(690000.0, 5325000.0, 600.0);
  const PointCloud cloud = make_cloud({utm, utm + glm::dvec3(0, 0.002, 0)}, {glm::dvec3(0.001), utm});
  const Octree octree = build_here(cloud);
  const Ray ray = make_ray(utm + glm::dvec3(-1000.0, 0.0005, 0), {1, 0, 0}, 0.0);
  EXPECT_EQ(ids_of(find(octree, ray, {.radius = 0.001})), (Ids{0}));
  EXPECT_EQ(closest(octree, ray, {.radius = 0.001})->point_id, 0u);
  EXPECT_EQ(ids_of(find(octree, ray, {.radius = 0.002})), (Ids{0, 1}));
}

}  // namespace
}  // namespace alidade
