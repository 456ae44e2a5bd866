// SPDX-License-Identifier: MIT
#include "cloud/input_view.h"

#include <algorithm>
#include <bitset>
#include <memory>
#include <string>
#include <vector>

#include "cloud/read_in_pieces.h"
#include "cloud/rows.h"
#include "cloud/select_points.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::error_of;
using test::LasFile;
using test::sample_las;
using test::warns;
using Bytes = std::vector<std::byte>;

Bytes text(const std::string& content) {
  const auto bytes = std::as_bytes(std::span(content));
  return {bytes.begin(), bytes.end()};
}

/// Clouds of several formats in memory; they must outlive what is returned.
CloudInputs inputs_of(const std::vector<Bytes>& files, std::shared_ptr<const InputView> view = {}) {
  CloudInputs inputs;
  for (std::size_t i = 0; i < files.size(); ++i) {
    inputs.inputs.push_back(cloud_in_memory(files[i], "tile_" + std::to_string(i)));
    inputs.inputs.back().view = view;
  }
  return inputs;
}

std::vector<Bytes> las_tiles() {
  std::vector<Bytes> tiles;
  for (const int format : {7, 3, 7}) tiles.push_back(build_las(sample_las(4, format, 500, tiles.size())));
  return tiles;
}

/// Rows whose intensity is odd.
void keep_odd_intensities(const PointCloud& rows, std::span<std::uint8_t> marks) {
  for (std::size_t row = 0; row < rows.size(); ++row) marks[row] = rows.intensities[row] % 2;
}

void expect_same_points(const PointCloud& found, const PointCloud& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t row = 0; row < found.size(); ++row)
    ASSERT_EQ(found.world(row), expected.world(row)) << row;
  for_each_column(found, expected, [](Attribute, const auto& column, const auto& other) {
    EXPECT_TRUE(test::same_bits(column, other));
  });
  ASSERT_EQ(found.extra_dimensions.size(), expected.extra_dimensions.size());
  for (std::size_t i = 0; i < found.extra_dimensions.size(); ++i)
    EXPECT_EQ(found.extra_dimensions[i].values, expected.extra_dimensions[i].values);
}

TEST(InputViewTest, everything_that_is_given_must_hold) {
  const std::vector<Bytes> tiles = las_tiles();
  PointCloud expected = read_cloud(inputs_of(tiles));
  const Bounds all = expected.bounds();
  const auto view = std::make_shared<InputView>();
  view->selection.box = Bounds{all.min, all.center()};
  view->selection.classes = std::bitset<256>(0b10'1011'0110);
  view->selection.condition = keep_odd_intensities;
  view->selection.polygons = [&](const Crs&) {
    return std::vector<PlanePolygon>{
        {{{glm::dvec2(all.min), {all.max.x, all.min.y}, {all.min.x, all.max.y}}}}};
  };
  const PointCloud found = read_cloud(inputs_of(tiles, view));

  crop(expected, *view->selection.box);
  crop(expected, view->selection.polygons({}));
  std::vector<std::uint8_t> marks(expected.size());
  keep_odd_intensities(expected, marks);
  for (std::size_t row = 0; row < marks.size(); ++row)
    marks[row] &= view->selection.classes->test(expected.classifications[row]) ? 1 : 0;
  keep_rows(expected, marks);
  EXPECT_GT(found.size(), 5u);
  expect_same_points(found, expected);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    EXPECT_EQ(found.files[i].point_count, expected.files[i].point_count);
    EXPECT_EQ(found.files[i].left_out_count, 500 - expected.files[i].point_count);
  }
}

TEST(InputViewTest, pieces_hold_the_same_points_as_the_whole) {
  const std::vector<Bytes> tiles = las_tiles();
  const auto view = std::make_shared<InputView>();
  view->selection.condition = keep_odd_intensities;
  const CloudInputs inputs = inputs_of(tiles, view);
  const PointCloud expected = read_cloud(inputs, {.color_depth = ColorDepth::bits_16});
  for (const std::uint64_t bytes : {200, 5000, 20'000}) {
    PointCloud joined;
    joined.lattice = expected.lattice;
    const CloudPieces pieces{.most_bytes = bytes, .bytes_beside = 8, .take = [&](PointCloud& piece) {
                               PointCloud part = piece;
                               part.records.clear();
                               append_cloud(joined, std::move(part));
                               piece.resize(0);
                             }};
    PiecewiseCloud whole = read_in_pieces(inputs, {.color_depth = ColorDepth::bits_16}, pieces);
    EXPECT_EQ(whole.point_count, expected.size());
    whole.rest.records.clear();
    append_cloud(joined, std::move(whole.rest));
    expect_same_points(joined, expected);
  }
}

TEST(InputViewTest, what_a_condition_reads_is_not_kept_unless_it_is_wanted) {
  const std::vector<Bytes> tiles = las_tiles();
  const auto view = std::make_shared<InputView>();
  view->selection.condition = keep_odd_intensities;
  view->selection.classes = std::bitset<256>().set();
  const PointCloud cloud = read_cloud(inputs_of(tiles, view), {.attributes = Attribute::returns});
  EXPECT_GT(cloud.size(), 0u);
  EXPECT_EQ(cloud.attributes(), AttributeSet(Attribute::returns));
}

TEST(InputViewTest, depth_of_colours_is_that_of_all_points) {
  LasFile las = sample_las(4, 7, 2);
  const Bytes file = build_las(las);
  PointCloud all = read_cloud(inputs_of({file}), {.color_depth = ColorDepth::bits_16});
  // One point is dark, the other is not.
  ASSERT_EQ(all.size(), 2u);
  const auto brightness = [](const Color16& color) { return std::max({color.x, color.y, color.z}); };
  const std::uint16_t brighter = std::max(brightness(all.colors[0]), brightness(all.colors[1]));
  ASSERT_GT(brighter, 255);
  const auto view = std::make_shared<InputView>();
  view->selection.condition = [&](const PointCloud& rows, std::span<std::uint8_t> marks) {
    for (std::size_t row = 0; row < rows.size(); ++row) marks[row] = brightness(rows.colors[row]) < brighter;
  };
  const std::vector<Bytes> files = {file};
  const PointCloud cloud = read_cloud(inputs_of(files, view));
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_FALSE(warns(cloud, "assuming 8-bit"));
}

TEST(InputViewTest, a_file_outside_the_box_is_not_read) {
  LasFile broken = sample_las(4, 7, 100);
  const std::vector<Bytes> tiles = {build_las(sample_las(4, 7, 100)), build_las(broken)};
  const PointCloud all = read_cloud(inputs_of(tiles));
  const auto view = std::make_shared<InputView>();
  view->selection.box = Bounds{all.bounds().max + 1e6, all.bounds().max + 2e6};
  const std::string error = error_of([&] { read_cloud(inputs_of(tiles, view)); });
  EXPECT_NE(error.find("no points are selected"), std::string::npos) << error;
  EXPECT_NE(error.find("none of 200 points"), std::string::npos) << error;
}

TEST(InputViewTest, classes_of_a_file_without_them_are_an_error_that_names_it) {
  const std::vector<Bytes> files = {text("x,y,z\n1,2,3\n")};
  const auto view = std::make_shared<InputView>();
  view->selection.classes = std::bitset<256>(4);
  EXPECT_EQ(error_of([&] { read_cloud(inputs_of(files, view)); }),
            "tile_0: cannot select by class: the file has no classification; expected a classified cloud");
}

TEST(InputViewTest, errors_of_a_condition_name_the_file) {
  const std::vector<Bytes> files = {text("x,y,z\n1,2,3\n")};
  const auto view = std::make_shared<InputView>();
  view->selection.condition = [](const PointCloud&, std::span<std::uint8_t>) {
    throw Error({.problem = "no such column"});
  };
  EXPECT_EQ(error_of([&] { read_cloud(inputs_of(files, view)); }), "tile_0: no such column");
}

/// Moves positions of any file by a million and doubles heights; what lies above 500.02 has no image.
std::shared_ptr<InputView> moving_view() {
  const auto view = std::make_shared<InputView>();
  view->change_reference = [](const std::filesystem::path&, const FileFacts&) {
    ReferenceChange change;
    change.crs.wkt = "LOCAL_CS[\"elsewhere\"]";
    change.warnings = {"moved"};
    change.move = [](std::span<glm::dvec3> positions) {
      for (glm::dvec3& position : positions) {
        const bool has_image = position.z <= 500.02;
        position =
            has_image ? glm::dvec3(position.x + 1e6, position.y, 2.0 * position.z) : glm::dvec3(INFINITY);
      }
    };
    return change;
  };
  return view;
}

TEST(InputViewTest, positions_move_to_a_lattice_as_fine_as_their_steps_and_keep_their_attributes) {
  const std::vector<Bytes> files = {
      build_las(sample_las(4, 7, 300)),
      text("x,y,z,intensity\n690000.25,5325000.5,500.01,3\n690001.25,5325000.5,500.03,5\n")};
  PointCloud plain = read_cloud(inputs_of(files));
  const PointCloud moved = read_cloud(inputs_of(files, moving_view()));
  std::vector<std::uint8_t> marks(plain.size());
  for (std::size_t row = 0; row < plain.size(); ++row) marks[row] = plain.world(row).z <= 500.02;
  const std::size_t all = plain.size();
  keep_rows(plain, marks);
  ASSERT_GT(moved.size(), 0u);
  ASSERT_LT(moved.size(), all);
  ASSERT_EQ(moved.size(), plain.size());
  for (std::size_t row = 0; row < moved.size(); ++row) {
    const glm::dvec3 expected = plain.world(row) * glm::dvec3(1, 1, 2) + glm::dvec3(1e6, 0, 0);
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_NEAR(moved.world(row)[axis], expected[axis], 0.51 * moved.lattice.scale[axis]) << row;
  }
  EXPECT_TRUE(test::same_bits(moved.intensities, plain.intensities));
  EXPECT_TRUE(test::same_bits(moved.colors, plain.colors));
  EXPECT_EQ(moved.crs.wkt, "LOCAL_CS[\"elsewhere\"]");
  EXPECT_LE(moved.lattice.scale.z, 2.0 * plain.lattice.scale.z);
  EXPECT_GE(moved.lattice.scale.x, 0.1 * plain.lattice.scale.x);
  EXPECT_EQ(moved.files[0].dropped_count + moved.files[1].dropped_count, all - moved.size());
  EXPECT_TRUE(warns(moved, "moved"));
}

TEST(InputViewTest, a_selection_is_of_the_moved_positions) {
  const std::vector<Bytes> files = {text("x,y,z\n0,0,1\n1,0,2\n2,0,3\n")};
  const auto view = moving_view();
  view->selection.box = Bounds{{1e6 + 0.5, -1, -1e9}, {1e6 + 1.5, 1, 1e9}};
  const PointCloud cloud = read_cloud(inputs_of(files, view));
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.world(0), glm::dvec3(1e6 + 1, 0, 4));
}

TEST(InputViewTest, an_empty_view_changes_nothing) {
  const std::vector<Bytes> tiles = las_tiles();
  const CloudInputs inputs = inputs_of(tiles, std::make_shared<InputView>());
  EXPECT_FALSE(inputs.inputs[0].is_changed());
  expect_same_points(read_cloud(inputs), read_cloud(inputs_of(tiles)));
}

}  // namespace
}  // namespace alidade
