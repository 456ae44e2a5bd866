// SPDX-License-Identifier: MIT
// From where objects are visible, and how much of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "tests/visibility/viewshed_place.h"
#include "visibility/raster/viewshed_file.h"

namespace alidade::test {
namespace {

constexpr double k_eye = 1.5;

/// An object on level ground.
GivenObserver mast(double x, double y, double height) {
  GivenObserver given{.source = "test", .position = {x, y}};
  given.z = 0.0;
  given.height = height;
  return given;
}

SampledObjects sampled(const std::vector<GivenObserver>& masts, double spacing, double width = 0.0) {
  GivenObjects given;
  for (const GivenObserver& one : masts) given.add_segment(one);
  return sample_objects(given, {.spacing = spacing, .width = width}, {});
}

/// A house of this half width around a position.
SampledObjects house(double x, double half, double height) {
  GivenObjects given;
  for (const auto& [dx, dy] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
    given.corners.push_back(mast(x + half * dx, half * dy, height));
  given.parts.push_back({0, ObjectShape::outline, 0, 4});
  return sample_objects(given, {}, {});
}

Viewshed seen(Field& field, const SampledObjects& objects, ViewshedMode mode) {
  return field.seen(objects.samples,
                    {.mode = mode, .target_height = k_eye, .pieces = objects.pieces, .positions_across = 1});
}

TEST(ViewshedObjects, on_level_ground_all_of_a_mast_is_seen) {
  Field field;
  const SampledObjects objects = sampled({mast(3, 2, 12)}, 0.5);
  for_cells(seen(field, objects, ViewshedMode::fraction),
            [](float value, const glm::dvec2& cell) { EXPECT_EQ(value, 1.0f) << cell.x << " " << cell.y; });
  for_cells(seen(field, objects, ViewshedMode::size),
            [](float value, const glm::dvec2&) { EXPECT_EQ(value, 12.0f); });
}

TEST(ViewshedObjects, a_wall_hides_the_lower_part_of_a_mast) {
  constexpr double k_wall = 3.0, k_height = 20.0, k_behind = 10.0;
  Field field;
  field.wall(0, -30, 30, 0, k_wall);
  const SampledObjects objects = sampled({mast(k_behind, 0, k_height)}, 0.25);
  const Viewshed lengths = seen(field, objects, ViewshedMode::size),
                 shares = seen(field, objects, ViewshedMode::fraction),
                 any = seen(field, objects, ViewshedMode::visible);
  int checked = 0;
  for_cells(lengths, [&](float value, const glm::dvec2& cell) {
    if (std::fabs(cell.y) > 14) return;
    if (cell.x > 1) {
      EXPECT_EQ(value, k_height) << cell.x << " " << cell.y;
    }
    if (cell.x > -3) return;
    ++checked;
    // The line over the wall's upper edge, which is some centimetres to half a metre above the last points.
    const auto visible = [&](double wall) {
      return std::max(0.0, k_height - (k_eye + (wall - k_eye) * (k_behind - cell.x) / -cell.x));
    };
    EXPECT_LE(value, visible(k_wall - k_before_edge) + 0.25) << cell.x << " " << cell.y;
    EXPECT_GE(value, visible(k_wall + k_edge) - 0.25) << cell.x << " " << cell.y;
  });
  EXPECT_GT(checked, 100);
  for (std::size_t i = 0; i < lengths.values.values.size(); ++i) {
    EXPECT_FLOAT_EQ(shares.values.values[i], lengths.values.values[i] / 20.0f);
    EXPECT_EQ(any.values.values[i], lengths.values.values[i] > 0.0f ? 1.0f : 0.0f);
  }
}

TEST(ViewshedObjects, objects_are_counted_once_each) {
  Field field;
  field.wall(0, -30, 30, 0, 8);
  // Two are behind the wall, and one of these is higher.
  const SampledObjects objects =
      sampled({mast(-20, 0, 4), mast(-20, 5, 4), mast(10, 0, 4), mast(10, 5, 60)}, 1.0);
  const Viewshed counts = seen(field, objects, ViewshedMode::count);
  for_cells(counts, [](float value, const glm::dvec2& cell) {
    if (cell.x < -3) {
      EXPECT_EQ(value, 3.0f) << cell.x << " " << cell.y;
    }
    if (cell.x > 3) {
      EXPECT_EQ(value, 2.0f) << cell.x << " " << cell.y;
    }
  });
}

TEST(ViewshedObjects, of_a_house_the_walls_count_that_face_the_cell) {
  Field field;
  const SampledObjects objects = house(0, 4, 6);
  const Viewshed areas = seen(field, objects, ViewshedMode::size),
                 shares = seen(field, objects, ViewshedMode::fraction);
  for_cells(areas, [](float value, const glm::dvec2& cell) {
    const bool beside_x = std::fabs(cell.x) > 4, beside_y = std::fabs(cell.y) > 4;
    const float walls = beside_x && beside_y ? 2.0f : 1.0f;
    EXPECT_NEAR(value, beside_x || beside_y ? walls * 48.0f : k_out_of_range, 1e-4)
        << cell.x << " " << cell.y;
  });
  for_cells(shares, [](float value, const glm::dvec2& cell) {
    const bool is_outside = std::fabs(cell.x) > 4 || std::fabs(cell.y) > 4;
    EXPECT_EQ(value, is_outside ? 1.0f : k_out_of_range) << cell.x << " " << cell.y;
  });
}

TEST(ViewshedObjects, the_solid_angle_of_a_free_strip_is_that_of_its_rectangle) {
  Field field;
  const SampledObjects objects = sampled({mast(0.3, 0, 9)}, 0.5, 2.0);
  for_cells(seen(field, objects, ViewshedMode::angle), [](float value, const glm::dvec2& cell) {
    const double d = std::hypot(cell.x - 0.3, cell.y);
    // Parts below and above the eye, each a quarter of a rectangle twice as high; a lift puts the eye above
    // the noise of the ground.
    const auto part = [d](double height) {
      return 2.0 * std::atan(height / (d * std::sqrt(1.0 + height * height + d * d)));
    };
    EXPECT_NEAR(value, part(k_eye) + part(9.0 - k_eye), 1e-3) << cell.x << " " << cell.y;
  });
}

TEST(ViewshedObjects, out_of_reach_is_out_of_range) {
  Field field;
  GivenObjects given;
  given.add_segment(mast(0, 0, 4));
  const SampledObjects objects = sample_objects(given, {.max_distance = 10.0}, {});
  for_cells(seen(field, objects, ViewshedMode::fraction), [](float value, const glm::dvec2& cell) {
    const double d = std::hypot(cell.x, cell.y);
    if (d < 9.5) {
      EXPECT_EQ(value, 1.0f);
    }
    if (d > 10.0) {
      EXPECT_EQ(value, k_out_of_range);
    }
  });
}

TEST(ViewshedObjects, maps_that_do_not_fit_are_errors) {
  Field field;
  const SampledObjects objects = sampled({mast(0, 0, 4)}, 1.0);
  EXPECT_THROW(seen(field, objects, ViewshedMode::height), Error);
  EXPECT_THROW(seen(field, objects, ViewshedMode::angle), Error) << "no width";
  EXPECT_THROW(field.seen(objects.samples, {.mode = ViewshedMode::size}), Error) << "no objects";
  const std::span<const ObjectPiece> few(objects.pieces.data(), 1);
  EXPECT_THROW(field.seen(objects.samples, {.mode = ViewshedMode::size, .pieces = few}), Error);
}

TEST(ViewshedObjects, bands_have_the_unit_of_their_values) {
  Field field;
  const SampledObjects line = sampled({mast(0, 0, 4)}, 1.0), strip = sampled({mast(0, 0, 4)}, 1.0, 2.0);
  const auto unit = [&](const SampledObjects& objects, ViewshedMode mode) {
    return viewshed_band(seen(field, objects, mode), {.mode = mode, .pieces = objects.pieces}, {}, 1, "m")
        .unit;
  };
  EXPECT_EQ(unit(line, ViewshedMode::size), "m");
  EXPECT_EQ(unit(strip, ViewshedMode::size), "m2");
  EXPECT_EQ(unit(strip, ViewshedMode::angle), "sr");
  EXPECT_EQ(unit(line, ViewshedMode::fraction), "");
  const Observer marked = at(0, 0, 4);
  const ViewshedOptions options{.mode = ViewshedMode::angle, .pieces = strip.pieces};
  const MapImage image = viewshed_image(seen(field, strip, options.mode), options, {&marked, 1}, "m");
  EXPECT_EQ(image.title, "Solid angle of one object");
  ASSERT_TRUE(image.scale);
}

}  // namespace
}  // namespace alidade::test
