// SPDX-License-Identifier: MIT
#include "visibility/raster/viewshed_file.h"

#include <gtest/gtest.h>

#include <limits>

#include "base/error.h"
#include "visibility/raster/map_targets.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace visibility;

namespace {

/// No ground, out of range, 0, 1, 7.
Viewshed viewshed() {
  Viewshed seen{Raster<float>({{0, 1}, 1.0, 5, 1}, 0.0f)};
  seen.values.values = {k_no_ground, k_out_of_range, 0.0f, 1.0f, 7.0f};
  return seen;
}

template <class Number>
std::vector<Number> numbers(const ViewshedBand& band) {
  return std::get<std::vector<Number>>(band.values);
}

TEST(ViewshedBandTest, visible_has_the_requested_values) {
  const ViewshedBand gdal = viewshed_band(viewshed(), {.mode = ViewshedMode::visible}, {}, 1, "m");
  EXPECT_EQ(numbers<std::uint8_t>(gdal), (std::vector<std::uint8_t>{254, 0, 0, 255, 255}));
  EXPECT_EQ(gdal.no_data, 254.0);
  const SeenValues own{.visible = 255, .invisible = 254, .out_of_range = 253};
  EXPECT_EQ(numbers<std::uint8_t>(viewshed_band(viewshed(), {.mode = ViewshedMode::visible}, own, 1, "m")),
            (std::vector<std::uint8_t>{252, 253, 254, 255, 255}));
  const SeenValues grass{.visible = 1, .invisible = 0, .out_of_range = {}};
  EXPECT_EQ(numbers<std::uint8_t>(viewshed_band(viewshed(), {.mode = ViewshedMode::visible}, grass, 1, "m")),
            (std::vector<std::uint8_t>{255, 255, 0, 1, 1}));
}

TEST(ViewshedBandTest, counts_are_as_wide_as_the_number_of_observers) {
  const ViewshedBand few = viewshed_band(viewshed(), {.mode = ViewshedMode::count}, {}, 65534, "m");
  EXPECT_EQ(numbers<std::uint16_t>(few), (std::vector<std::uint16_t>{65535, 65535, 0, 1, 7}));
  const ViewshedBand many = viewshed_band(viewshed(), {.mode = ViewshedMode::count}, {}, 65535, "m");
  EXPECT_EQ(numbers<std::uint32_t>(many), (std::vector<std::uint32_t>{4294967295u, 4294967295u, 0, 1, 7}));
  EXPECT_EQ(many.no_data, 4294967295.0);
}

TEST(ViewshedBandTest, heights_and_shares_are_floats_and_heights_have_a_unit) {
  const ViewshedBand height = viewshed_band(viewshed(), {.mode = ViewshedMode::height}, {}, 1, "ft");
  EXPECT_EQ(numbers<float>(height), (std::vector<float>{-9999.0f, -9999.0f, 0.0f, 1.0f, 7.0f}));
  EXPECT_EQ(height.unit, "ft");
  EXPECT_EQ(height.band().no_data, -9999.0);
  EXPECT_EQ(std::get<std::span<const float>>(height.band().values).size(), 5u);
  EXPECT_EQ(viewshed_band(viewshed(), {.mode = ViewshedMode::fraction}, {}, 1, "ft").unit, "");
}

TEST(ViewshedImageTest, every_value_has_a_colour_and_the_scale_ends_at_the_largest) {
  Observer observer;
  observer.name.assign("tower");
  const MapImage count = viewshed_image(viewshed(), {.mode = ViewshedMode::count}, {&observer, 1}, "m");
  ASSERT_TRUE(count.scale);
  EXPECT_EQ(count.scale->range, (ValueRange{1.0, 7.0}));
  EXPECT_EQ(count.marks.at(0).name, "tower");
  EXPECT_FALSE(viewshed_image(viewshed(), {}, {&observer, 1}, "m").scale);
  // A cell that is not seen up to `highest` does not extend the scale.
  const MapImage height =
      viewshed_image(viewshed(), {.mode = ViewshedMode::height, .highest = 7.0}, {&observer, 1}, "m");
  EXPECT_EQ(height.scale->range, (ValueRange{0.0, 1.0}));
  EXPECT_EQ(height.swatches.at(0).label, "visible on the ground");
}

TEST(ViewshedImageTest, heights_begin_with_that_of_the_target) {
  const ViewshedOptions options{.mode = ViewshedMode::height, .target_height = 1.0, .highest = 200.0};
  const Observer observer;
  const MapImage image = viewshed_image(viewshed(), options, {&observer, 1}, "m");
  EXPECT_EQ(image.swatches.at(0).value, 1.0f);
  EXPECT_EQ(image.swatches.at(0).label, "visible at 1 m");
  EXPECT_EQ(image.scale->range, (ValueRange{1.0, 7.0}));
}

TEST(SeenShareTest, is_of_the_cells_tested_and_of_heights_counts_the_lowest) {
  const SeenShare any = seen_share(viewshed(), {});
  EXPECT_NEAR(any.percent, 200.0 / 3.0, 1e-9);
  EXPECT_EQ(any.without, 2u);
  EXPECT_NEAR(seen_share(viewshed(), {.mode = ViewshedMode::height}).percent, 100.0 / 3.0, 1e-9);
  // 0.1 is no float: what is stored is the nearest.
  Viewshed lifted = viewshed();
  lifted.values.values = {0.1f, 0.1f, 0.2f, k_no_ground, k_out_of_range};
  EXPECT_NEAR(seen_share(lifted, {.mode = ViewshedMode::height, .target_height = 0.1}).percent, 200.0 / 3.0,
              1e-9);
}

TEST(ViewshedAreaTest, only_what_an_observer_reaches_is_in_the_map) {
  const Bounds area{{0, 0, 0}, {100, 100, 10}};
  Observer near, far;
  near.position = {10, 10, 5};
  near.max_distance = 20.0;
  far.position = {500, 500, 5};
  far.max_distance = 50.0;
  const std::vector<Observer> both{near, far};
  const Bounds reached = area_in_reach(area, both);
  EXPECT_EQ(glm::dvec2(reached.min), glm::dvec2(0, 0));
  EXPECT_EQ(glm::dvec2(reached.max), glm::dvec2(30, 30));
  EXPECT_THROW(area_in_reach(area, {&far, 1}), Error);
  far.max_distance = std::numeric_limits<double>::infinity();
  EXPECT_EQ(glm::dvec2(area_in_reach(area, {&far, 1}).max), glm::dvec2(100, 100));
}

TEST(ViewshedAreaTest, the_usual_resolution_is_round_and_gives_at_most_a_thousand_cells) {
  const auto of_length = [](double length) { return usual_resolution({{0, 0, 0}, {length, 1, 1}}); };
  EXPECT_EQ(of_length(100.0), 0.1);
  EXPECT_EQ(of_length(124.0), 0.2);
  EXPECT_EQ(of_length(300.0), 0.5);
  EXPECT_EQ(of_length(900.0), 1.0);
  EXPECT_EQ(of_length(7000.0), 10.0);
  EXPECT_EQ(of_length(0.0), 0.001);
  EXPECT_EQ(usual_resolution({{5, 5, 5}, {5, 5, 5}}), 1.0);
  EXPECT_EQ(usual_resolution({{0, 0, 0}, {100, 1, 1}}, 0.3), 0.5) << "not finer than the ground";
  EXPECT_EQ(usual_resolution({{0, 0, 0}, {100, 1, 1}}, 0.2), 0.2);
}

}  // namespace
}  // namespace alidade::test
