// SPDX-License-Identifier: MIT
#include "compare/photographs/alignment.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "tests/compare/drawn_images.h"

namespace alidade::test {

using namespace compare;

namespace {

/// Blots as seen by a camera that is off, with other colours: what `reference` shows, `shift_x` pixels
/// farther right and `shift_y` pixels farther down.
ComparedImage shifted_blots(double shift_x, double shift_y, double contrast = 1.0, double base = 0.0) {
  return draw_image(360, 240, ColorEncoding::display, [&](int x, int y) {
    const double value = base + contrast * blots(x - shift_x, y - shift_y);
    return std::array<double, 3>{value, value, value};
  });
}

void expect_shift(const Alignment& alignment, double x, double y, double tolerance) {
  EXPECT_NEAR(alignment.shift_x, x, tolerance);
  EXPECT_NEAR(alignment.shift_y, y, tolerance);
  EXPECT_TRUE(alignment.is_certain);
}

TEST(Alignment, equal_images_are_aligned_with_a_score_of_1) {
  const ComparedImage image = shifted_blots(0.0, 0.0);
  const Alignment alignment = align(image, image, {});
  expect_shift(alignment, 0.0, 0.0, 1e-9);
  EXPECT_NEAR(alignment.score, 1.0, 1e-9);
  EXPECT_NEAR(alignment.score_unshifted, 1.0, 1e-9);
}

TEST(Alignment, shifts_are_found_to_a_tenth_of_a_pixel) {
  const ComparedImage reference = shifted_blots(0.0, 0.0);
  const std::array<std::array<double, 2>, 7> shifts = {
      {{5, 0}, {0, -5}, {-17, 23}, {0.5, -0.25}, {3.3, 1.7}, {-40.5, -31.25}, {62, -62}}};
  for (const auto& [x, y] : shifts) {
    SCOPED_TRACE(testing::Message() << x << " " << y);
    const Alignment alignment = align(reference, shifted_blots(x, y), {});
    expect_shift(alignment, x, y, 0.1);
    EXPECT_GT(alignment.score, 0.95);
    EXPECT_LT(alignment.score_unshifted, alignment.score);
  }
}

/// Blots that are four times as long as wide, along a diagonal: the slopes of their peak run across both
/// axes.
ComparedImage slanted_blots(double shift_x, double shift_y) {
  return draw_image(360, 240, ColorEncoding::display, [&](int x, int y) {
    const double along = (x - shift_x) + (y - shift_y), across = (x - shift_x) - (y - shift_y);
    const double value = blots(0.35 * along, 1.4 * across);
    return std::array<double, 3>{value, value, value};
  });
}

TEST(Alignment, a_slanted_peak_is_found_to_a_tenth_of_a_pixel) {
  const ComparedImage reference = slanted_blots(0.0, 0.0);
  const std::array<std::array<double, 2>, 2> shifts = {{{0.4, 0.0}, {0.0, -0.4}}};
  for (const auto& [x, y] : shifts) {
    SCOPED_TRACE(testing::Message() << x << " " << y);
    // Certain or not: it is flat along the blots.
    const Alignment alignment = align(reference, slanted_blots(x, y), {});
    EXPECT_NEAR(alignment.shift_x, x, 0.1);
    EXPECT_NEAR(alignment.shift_y, y, 0.1);
  }
}

TEST(Alignment, a_shift_counts_that_leaves_a_quarter_of_the_images_on_each_other) {
  const auto small = [](double shift) {
    return draw_image(160, 90, ColorEncoding::display, [&](int x, int y) {
      const double value = blots(x - shift, y);
      return std::array<double, 3>{value, value, value};
    });
  };
  const ComparedImage reference = small(0.0);
  // 44 % and 31 % of the pixels lie on each other, and 19 %.
  expect_shift(align(reference, small(90.0), {}, {.largest_shift = 150}), 90.0, 0.0, 0.1);
  expect_shift(align(reference, small(110.0), {}, {.largest_shift = 150}), 110.0, 0.0, 0.1);
  const Alignment less = align(reference, small(130.0), {}, {.largest_shift = 150});
  EXPECT_GT(std::abs(less.shift_x - 130.0), 5.0);
  EXPECT_FALSE(less.is_certain);
}

TEST(Alignment, swapped_images_have_the_opposite_shift) {
  const ComparedImage one = shifted_blots(0.0, 0.0), other = shifted_blots(7.25, -3.5);
  const Alignment there = align(one, other, {}), back = align(other, one, {});
  EXPECT_NEAR(there.shift_x, -back.shift_x, 0.02);
  EXPECT_NEAR(there.shift_y, -back.shift_y, 0.02);
}

TEST(Alignment, exposure_and_contrast_play_no_role) {
  const Alignment alignment = align(shifted_blots(0.0, 0.0), shifted_blots(5.0, 2.0, 0.2, 0.7), {});
  expect_shift(alignment, 5.0, 2.0, 0.1);
  EXPECT_GT(alignment.score, 0.95);
}

TEST(Alignment, a_part_that_shows_something_else_does_not_move_the_shift) {
  ComparedImage test = shifted_blots(5.0, 0.0);
  for (int y = 0; y < test.height; ++y) {
    for (int x = 0; x < test.width * 2 / 5; ++x) {
      for (int channel = 0; channel < 3; ++channel) {
        test.color[3 * (static_cast<std::size_t>(y) * test.width + static_cast<std::size_t>(x)) +
                   static_cast<std::size_t>(channel)] = static_cast<float>(blots(x + 4000.0, y, 77));
      }
    }
  }
  // By chance, what is different is a little alike somewhere.
  expect_shift(align(shifted_blots(0.0, 0.0), test, {}), 5.0, 0.0, 0.3);
}

/// Every third pixel of the test is a hole of value 0, and a block of it was never scanned.
ComparedImage with_holes(ComparedImage test) {
  test.depth.assign(test.pixels(), 10.0f);
  for (int y = 0; y < test.height; ++y) {
    for (int x = 0; x < test.width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * test.width + static_cast<std::size_t>(x);
      if (hashed(pixel) >= 0.3 && !(x > 200 && y < 80)) continue;
      test.depth[pixel] = std::numeric_limits<float>::infinity();
      for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) test.color[i] = 0.0f;
    }
  }
  return test;
}

TEST(Alignment, holes_between_points_are_no_edges) {
  const ComparedImage reference = shifted_blots(0.0, 0.0), whole = shifted_blots(4.5, -2.0);
  const Alignment alignment = align(reference, with_holes(whole), {});
  expect_shift(alignment, 4.5, -2.0, 0.2);
  EXPECT_GT(alignment.score, 0.5);
  ComparedImage without_depth = with_holes(whole);
  without_depth.depth.clear();
  EXPECT_LT(align(reference, without_depth, {}).score, 0.5);
}

TEST(Alignment, alpha_mask_and_nan_take_pixels_out) {
  const ComparedImage reference = shifted_blots(0.0, 0.0);
  ComparedImage test = shifted_blots(5.0, 0.0);
  // A frame, like those of screenshots, that stays where it is.
  ImageMask mask;
  mask.counts.assign(test.pixels(), 1);
  ComparedImage framed = reference;
  framed.alpha.assign(test.pixels(), 1.0f);
  for (std::size_t pixel = 0; pixel < test.pixels(); ++pixel) {
    const std::size_t x = pixel % 360, y = pixel / 360;
    if (x >= 60 && x < 300 && y >= 40 && y < 200) continue;
    const bool is_checked = (x / 2 + y / 2) % 2 == 0;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      test.color[i] = framed.color[i] = is_checked ? 1.0f : 0.0f;
      if (y >= 220) test.color[i] = std::numeric_limits<float>::quiet_NaN();
    }
    if (x < 60) framed.alpha[pixel] = 0.25f;
    if (x >= 60 && y < 220) mask.counts[pixel] = 0;
  }
  expect_shift(align(framed, test, mask), 5.0, 0.0, 0.1);
  framed.alpha.clear();
  EXPECT_GT(std::abs(align(framed, test, {}).shift_x - 5.0), 0.5);
}

TEST(Alignment, images_of_different_things_are_not_certain) {
  const ComparedImage reference = shifted_blots(0.0, 0.0);
  const ComparedImage other = draw_image(360, 240, ColorEncoding::display, [](int x, int y) {
    const double value = blots(x, y, 4321);
    return std::array<double, 3>{value, value, value};
  });
  EXPECT_FALSE(align(reference, other, {}).is_certain);
  const ComparedImage noise = draw_image(360, 240, ColorEncoding::display, [](int x, int y) {
    const double value = hashed(static_cast<std::uint64_t>(1000 * y + x));
    return std::array<double, 3>{value, value, value};
  });
  EXPECT_FALSE(align(reference, noise, {}).is_certain);
}

TEST(Alignment, images_without_edges_are_not_certain_and_have_no_shift) {
  const ComparedImage even = draw_image(100, 80, ColorEncoding::display, [](int, int) {
    return std::array<double, 3>{0.5, 0.5, 0.5};
  });
  for (const ComparedImage& other : {even, draw_image(100, 80, ColorEncoding::display, [](int x, int y) {
                                       return std::array<double, 3>{blots(x, y), 0.0, 0.0};
                                     })}) {
    const Alignment alignment = align(even, other, {});
    EXPECT_FALSE(alignment.is_certain);
    EXPECT_EQ(alignment.shift_x, 0.0);
    EXPECT_EQ(alignment.shift_y, 0.0);
    EXPECT_EQ(alignment.score, 0.0);
  }
  const ComparedImage dot = draw_image(1, 1, ColorEncoding::display, [](int, int) {
    return std::array<double, 3>{0.5, 0.5, 0.5};
  });
  EXPECT_FALSE(align(dot, dot, {}).is_certain);
}

TEST(Alignment, edges_of_one_direction_are_not_certain) {
  const auto stripes = [](double shift) {
    return draw_image(360, 240, ColorEncoding::display, [&](int x, int) {
      const double value = blots(x - shift, 0.0);
      return std::array<double, 3>{value, value, value};
    });
  };
  EXPECT_FALSE(align(stripes(0.0), stripes(6.0), {}).is_certain);
}

TEST(Alignment, a_pattern_that_repeats_within_reach_is_not_certain) {
  const auto dots = [](double shift) {
    return draw_image(360, 240, ColorEncoding::display, [&](int x, int y) {
      const double value = 0.5 + 0.25 * std::sin((x - shift) * 0.3) + 0.25 * std::sin(y * 0.3);
      return std::array<double, 3>{value, value, value};
    });
  };
  EXPECT_FALSE(align(dots(0.0), dots(4.0), {}).is_certain);
}

TEST(Alignment, a_shift_beyond_reach_is_not_certain) {
  const ComparedImage reference = shifted_blots(0.0, 0.0), test = shifted_blots(40.0, 0.0);
  EXPECT_FALSE(align(reference, test, {}, {.largest_shift = 20}).is_certain);
  expect_shift(align(reference, test, {}, {.largest_shift = 48}), 40.0, 0.0, 0.1);
}

TEST(Alignment, linear_and_display_encoded_images_are_aligned_with_each_other) {
  const ComparedImage display = shifted_blots(0.0, 0.0);
  ComparedImage linear = shifted_blots(5.0, 1.0);
  linear.color = linear_color(linear);
  linear.encoding = ColorEncoding::linear;
  expect_shift(align(display, linear, {}), 5.0, 1.0, 0.1);
}

TEST(Alignment, is_the_same_on_any_number_of_threads) {
  const ComparedImage reference = shifted_blots(0.0, 0.0), test = with_holes(shifted_blots(3.3, -8.1));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Alignment alone = align(reference, test, {});
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  const Alignment together = align(reference, test, {});
  EXPECT_EQ(alone.shift_x, together.shift_x);
  EXPECT_EQ(alone.shift_y, together.shift_y);
  EXPECT_EQ(alone.score, together.score);
}

TEST(Alignment, in_narrow_images_only_shifts_that_leave_something_are_tried) {
  const auto strip = [](double shift) {
    return draw_image(400, 20, ColorEncoding::display, [&](int x, int y) {
      const double value = blots(x - shift, y);
      return std::array<double, 3>{value, value, value};
    });
  };
  // In y there are 39 shifts, not 8193.
  expect_shift(align(strip(0.0), strip(9.0), {}, {.largest_shift = 4096}), 9.0, 0.0, 0.2);
  const ComparedImage ribbon = draw_image(60000, 40, ColorEncoding::display, [](int, int) {
    return std::array<double, 3>{0.5, 0.5, 0.5};
  });
  EXPECT_THROW(align(ribbon, ribbon, {}, {.largest_shift = 4096}), Error) << "it would take an hour";
}

TEST(Alignment, sizes_and_reach_are_checked) {
  const ComparedImage image = shifted_blots(0.0, 0.0);
  const ComparedImage small = draw_image(20, 20, ColorEncoding::display, [](int, int) {
    return std::array<double, 3>{0.5, 0.5, 0.5};
  });
  EXPECT_THROW(align(image, small, {}), SizeMismatch);
  EXPECT_THROW(align(image, image, {}, {.largest_shift = 0}), Error);
  EXPECT_THROW(align(image, image, {}, {.largest_shift = 4097}), Error);
}

}  // namespace
}  // namespace alidade::test
