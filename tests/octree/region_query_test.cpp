// SPDX-License-Identifier: MIT
#include "octree/distance.h"
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

TEST(HalfSpacesVsBruteForce, find_and_count_are_the_same_bits_on_every_family) {
  const Tally tally = expect_as_brute_force_on_every_family(100, region_cases);
  EXPECT_GT(tally.answers, 100000u);
  EXPECT_GT(tally.empty, 300u);
  EXPECT_GT(tally.cases - tally.empty, 400u);
}

TEST(BoxVsBruteForce, find_and_count_are_the_same_bits_on_every_family) {
  const Tally tally = expect_as_brute_force_on_every_family(100, box_cases);
  EXPECT_GT(tally.answers, 20000u);
  EXPECT_GT(tally.empty, 300u);
  EXPECT_GT(tally.cases - tally.empty, 300u);
}

TEST(HalfSpaces, points_on_a_plane_count) {
  const Octree octree = build(three_points());
  EXPECT_EQ(ids_of(find(octree, HalfSpaces{{make_plane({10, 0, 0}, {1, 0, 0})}})), (Ids{0, 2}));
  EXPECT_EQ(ids_of(find(octree, HalfSpaces{{make_plane({10, 0, 0}, {-1, 0, 0})}})), (Ids{0, 1}));
}

TEST(HalfSpaces, are_ordered_by_the_signed_distance_to_the_first_plane) {
  const std::vector<PointHit> hits =
      find(build(three_points()), HalfSpaces{{make_plane({30, 0, 0}, {-2, 0, 0})}});
  EXPECT_EQ(ids_of(hits), (Ids{2, 0, 1}));
  EXPECT_EQ(hits[0].distance, 10.0);
  EXPECT_EQ(ids_of(find(build(three_points()), HalfSpaces{{make_plane({30, 0, 0}, {-2, 0, 0})}}, {.k = 2})),
            (Ids{2, 0}));
}

TEST(HalfSpaces, without_planes_are_everywhere) {
  EXPECT_EQ(ids_of(find(build(three_points()), HalfSpaces{})), (Ids{0, 1, 2}));
}

TEST(HalfSpaces, a_slab_has_two_inclusive_faces) {
  const Plane plane = make_plane({5, 0, 0}, {1, 0, 0});
  EXPECT_EQ(ids_of(find(build(three_points()), make_slab(plane, 5.0))), (Ids{1, 0}));
  EXPECT_EQ(ids_of(find(build(three_points()), make_slab(plane, 4.9))), (Ids{1}));
  EXPECT_EQ(ids_of(find(build(three_points()), make_slab(plane, 0.0))), (Ids{1}));
}

TEST(HalfSpaces, planes_and_slabs_that_are_none_are_errors) {
  const double nan = std::nan(""), infinity = HUGE_VAL;
  EXPECT_THROW(make_plane({0, 0, 0}, {0, 0, -0.0}), Error);
  EXPECT_THROW(make_plane({0, nan, 0}, {0, 0, 1}), Error);
  EXPECT_THROW(make_plane({0, 0, 0}, {0, infinity, 1}), Error);
  for (const double thickness : {-1.0, nan, infinity}) EXPECT_THROW(make_slab(Plane{}, thickness), Error);
}

TEST(Box, both_faces_are_inclusive) {
  const Octree octree = build(three_points());
  EXPECT_EQ(ids_of(find(octree, Bounds{{5, 0, 0}, {10, 0.5, 0}})), (Ids{0, 1}));
  EXPECT_EQ(ids_of(find(octree, Bounds{{std::nextafter(5.0, 6.0), 0, 0}, {10, 0.5, 0}})), (Ids{0}));
}

TEST(Box, answers_stand_in_the_order_of_point_ids) {
  const std::vector<PointHit> hits = find(build(three_points()), Bounds{{0, 0, 0}, {20, 1, 0}}, {.k = 2});
  EXPECT_EQ(ids_of(hits), (Ids{0, 1}));
  EXPECT_EQ(hits[0].distance, 0.0);
}

TEST(Box, may_be_infinite) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(count(build(three_points()), Bounds{{10, -infinity, -infinity}, {infinity, infinity, infinity}}),
            2u);
}

TEST(Box, that_is_inverted_holds_nothing) {
  EXPECT_EQ(count(build(three_points()), Bounds{}), 0u);
  EXPECT_EQ(count(build(three_points()), Bounds{{0, 0, 1}, {20, 1, -1}}), 0u);
}

}  // namespace
}  // namespace alidade
