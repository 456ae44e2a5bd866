// SPDX-License-Identifier: MIT
#include "visibility/objects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/error.h"

namespace alidade::test {

using namespace visibility;

namespace {

const GroundHeight k_no_ground = [](const glm::dvec2&) { return std::optional<double>(); };
const GroundHeight k_slope = [](const glm::dvec2& at) { return std::optional<double>(at.x); };

GivenObserver corner(double x, double y, double height, std::optional<double> z = 0.0) {
  GivenObserver given{.source = "test", .position = {x, y}};
  given.z = z;
  given.height = height;
  return given;
}

/// One object of one part.
GivenObjects object(ObjectShape shape, std::vector<GivenObserver> corners) {
  const std::size_t count = corners.size();
  return {std::move(corners), {{0, shape, 0, count}}};
}

std::vector<GivenObserver> square(bool turns_left) {
  std::vector<GivenObserver> corners{corner(-2, -2, 3), corner(2, -2, 3), corner(2, 2, 3), corner(-2, 2, 3)};
  if (!turns_left) std::ranges::reverse(corners);
  return corners;
}

double total_size(const SampledObjects& objects) {
  double sum = 0.0;
  for (const ObjectPiece& piece : objects.pieces) sum += piece.size();
  return sum;
}

std::string problem_of(const GivenObjects& given, const SampleOptions& options = {},
                       const GroundHeight& ground = k_no_ground) {
  try {
    sample_objects(given, options, ground);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Objects, a_text_is_position_foot_and_top) {
  const GivenObserver mast = parse_object("690000,5325000.5,600,690.25");
  EXPECT_EQ(mast.position, glm::dvec2(690000, 5325000.5));
  EXPECT_EQ(mast.z, 600.0);
  EXPECT_EQ(mast.height, 90.25);
  for (const char* const text :
       {"", "1,2,3", "1,2,3,4,5", "1,2,3,x", "1,2,nan,4", "1,2,3,inf", "1,2,3,3", "1,2,4,3"})
    EXPECT_THROW(parse_object(text), Error) << text;
}

TEST(Objects, a_segment_has_equal_pieces_of_at_most_the_spacing) {
  const SampledObjects mast =
      sample_objects(object(ObjectShape::segment, {corner(5, 6, 10, 100.0)}), {.spacing = 3.0}, k_no_ground);
  ASSERT_EQ(mast.samples.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(mast.samples[i].position, glm::dvec3(5, 6, 101.25 + 2.5 * static_cast<double>(i)));
    EXPECT_EQ(mast.pieces[i].height, 2.5);
    EXPECT_EQ(mast.pieces[i].size(), 2.5) << "a length";
  }
  ASSERT_EQ(mast.objects.size(), 1u);
  EXPECT_EQ(mast.objects[0].position, glm::dvec3(5, 6, 110));
  EXPECT_EQ(mast.objects[0].name, "object 1");
  const SampledObjects tower = sample_objects(object(ObjectShape::segment, {corner(5, 6, 10, 100.0)}),
                                              {.spacing = 3.0, .width = 4.0}, k_no_ground);
  EXPECT_EQ(total_size(tower), 40.0) << "an area";
}

TEST(Objects, walls_follow_their_vertices_or_the_ground) {
  const SampledObjects rising =
      sample_objects(object(ObjectShape::wall, {corner(0, 0, 2, 10.0), corner(4, 0, 2, 14.0)}),
                     {.spacing = 2.0}, k_no_ground);
  ASSERT_EQ(rising.samples.size(), 2u);
  EXPECT_EQ(rising.samples[0].position, glm::dvec3(1, 0, 12));
  EXPECT_EQ(rising.samples[1].position, glm::dvec3(3, 0, 14));
  EXPECT_FALSE(rising.pieces[0].is_one_sided);
  EXPECT_EQ(total_size(rising), 8.0);
  const SampledObjects on_slope = sample_objects(
      object(ObjectShape::wall, {corner(0, 0, 2, {}), corner(4, 0, 2, {})}), {.spacing = 2.0}, k_slope);
  EXPECT_EQ(on_slope.samples[1].position, glm::dvec3(3, 0, 4));
}

TEST(Objects, outlines_face_outwards_whichever_way_they_turn) {
  for (const bool turns_left : {true, false}) {
    const SampledObjects house =
        sample_objects(object(ObjectShape::outline, square(turns_left)), {}, k_no_ground);
    ASSERT_EQ(house.samples.size(), 4u * 4u * 3u);
    EXPECT_NEAR(total_size(house), 48.0, 1e-12);
    int facing = 0;
    for (std::size_t i = 0; i < house.samples.size(); ++i) {
      const glm::dvec3 middle = house.samples[i].position;
      EXPECT_GT(glm::dot(house.pieces[i].normal, glm::dvec2(middle)), 0.0);
      facing += faces(house.pieces[i], middle, {100, 0, 0}) ? 1 : 0;
      EXPECT_FALSE(faces(house.pieces[i], middle, {0, 0, 1})) << "from inside";
    }
    EXPECT_EQ(facing, 12) << "one wall";
  }
}

TEST(Objects, solid_angles_are_those_of_rectangles) {
  // Half sides a and b at the distance d: 4 atan(a b / (d sqrt(a^2 + b^2 + d^2))).
  const auto of_rectangle = [](double a, double b, double d) {
    return 4.0 * std::atan(a * b / (d * std::sqrt(a * a + b * b + d * d)));
  };
  const ObjectPiece strip{.width = 2.0, .height = 6.0};
  EXPECT_NEAR(solid_angle(strip, {0, 0, 50}, {0, -10, 50}), of_rectangle(1, 3, 10), 1e-14);
  EXPECT_NEAR(solid_angle(strip, {0, 0, 50}, {6, 8, 50}), of_rectangle(1, 3, 10), 1e-14) << "it turns";
  EXPECT_NEAR(solid_angle(strip, {0, 0, 50}, {0, -1e-3, 50}), 2.0 * std::numbers::pi, 1e-2) << "close by";
  const ObjectPiece wall{.width = 2.0, .height = 6.0, .normal = {0, 1}};
  EXPECT_NEAR(solid_angle(wall, {0, 0, 50}, {0, 10, 50}), of_rectangle(1, 3, 10), 1e-14);
  EXPECT_NEAR(solid_angle(wall, {0, 0, 50}, {10, 0, 50}), 0.0, 1e-14) << "edge on";
  EXPECT_EQ(solid_angle({.width = 0.0, .height = 6.0}, {0, 0, 0}, {1, 0, 0}), 0.0);
  EXPECT_EQ(solid_angle(strip, {0, 0, 50}, {0, 0, 40}), 0.0) << "from straight below";
  // The four walls around the middle of a cube are 4 of 6 equal parts of all directions.
  std::vector<GivenObserver> corners = square(true);
  for (GivenObserver& one : corners) one.height = 4.0;
  corners.push_back(corners.front());
  const SampledObjects cube = sample_objects(object(ObjectShape::wall, corners), {}, k_no_ground);
  double sum = 0.0;
  for (std::size_t i = 0; i < cube.pieces.size(); ++i)
    sum += solid_angle(cube.pieces[i], cube.samples[i].position, {0, 0, 2});
  EXPECT_NEAR(sum, 4.0 * std::numbers::pi * 4.0 / 6.0, 1e-12);
}

TEST(Objects, errors_name_the_source) {
  const auto segment = [](const GivenObserver& one) { return object(ObjectShape::segment, {one}); };
  GivenObserver bare = corner(1, 2, 3);
  bare.height.reset();
  EXPECT_TRUE(contains(problem_of(segment(bare)), "test: object without a height"));
  EXPECT_TRUE(contains(problem_of(segment(corner(1, 2, 0))), "invalid height of an object"));
  EXPECT_TRUE(contains(problem_of(segment(corner(1, 2, -3))), "invalid height of an object"));
  EXPECT_TRUE(contains(problem_of(segment(corner(1, 2, 3, {}))), "test: no ground below the object"));
  EXPECT_TRUE(contains(problem_of(segment(corner(1e13, 2, 3))), "test: position out of range"));
  EXPECT_TRUE(contains(problem_of(object(ObjectShape::wall, {corner(1, 1, 2), corner(1, 1, 2)})),
                       "test: line without length"));
  EXPECT_TRUE(
      contains(problem_of(segment(corner(1, 2, 3)), {.spacing = 1e-6}), "too many samples of objects"));
  EXPECT_TRUE(contains(problem_of(segment(corner(1, 2, 3)), {.spacing = 0.0}), "invalid spacing"));
  EXPECT_TRUE(contains(problem_of(segment(corner(1, 2, 3)), {.width = -1.0}), "invalid width"));
  GivenObjects both = object(ObjectShape::outline, square(true));
  both.add_segment(corner(9, 9, 4));
  EXPECT_EQ(both.count(), 2u);
  EXPECT_TRUE(contains(problem_of(both), "vertical objects without a width beside walls"));
  EXPECT_EQ(problem_of(both, {.width = 0.5}), "");
}

}  // namespace
}  // namespace alidade::test
