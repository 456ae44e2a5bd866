// SPDX-License-Identifier: MIT
#include "image/legend.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <filesystem>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "base/error.h"
#include "image/font.h"

namespace alidade {

using namespace image;

namespace {

namespace fs = std::filesystem;

std::string labels(const ValueRange& range, int most) {
  std::string text;
  for (const RoundTick& tick : round_ticks(range, most)) text += (text.empty() ? "" : " ") + tick.label;
  return text;
}

TEST(RoundTicksTest, steps_are_1_2_or_5_times_a_power_of_ten) {
  EXPECT_EQ(labels({0, 10}, 11), "0 1 2 3 4 5 6 7 8 9 10");
  EXPECT_EQ(labels({0, 10}, 10), "0 2 4 6 8 10");
  EXPECT_EQ(labels({0, 10}, 5), "0 5 10");
  EXPECT_EQ(labels({599.243, 611.352}, 8), "600 602 604 606 608 610");
  EXPECT_EQ(labels({-0.25, 0.25}, 6), "-0.2 -0.1 0.0 0.1 0.2");
  EXPECT_EQ(labels({0.1, 0.3}, 5), "0.10 0.15 0.20 0.25 0.30");
  EXPECT_EQ(labels({0, 65535}, 8), "0 10000 20000 30000 40000 50000 60000");
  EXPECT_EQ(labels({1e-9, 5e-9}, 5), "1e-09 2e-09 3e-09 4e-09 5e-09");
  EXPECT_EQ(labels({2e12, 2.00002e12}, 6), "2e+12 2.000005e+12 2.00001e+12 2.000015e+12 2.00002e+12");
}

TEST(RoundTicksTest, ticks_lie_within_the_range_and_are_no_more_than_requested) {
  for (const double low : {-1e300, -7.3e8, -12.5, -1e-7, 0.0, 3.3e-5, 690000.125, 5e9}) {
    for (const double extent : {1e-4, 0.37, 1.0, 99.99, 1e7, 1e300}) {
      for (int most = 2; most < 12; ++most) {
        const ValueRange range{low, low + extent};
        const std::vector<RoundTick> ticks = round_ticks(range, most);
        ASSERT_FALSE(ticks.empty() && most > 3);
        ASSERT_LE(ticks.size(), static_cast<std::size_t>(most));
        for (const RoundTick& tick : ticks) {
          EXPECT_GE(tick.value, range.low);
          EXPECT_LE(tick.value, range.high);
        }
      }
    }
  }
}

TEST(RoundTicksTest, one_value_has_one_tick) {
  EXPECT_EQ(labels({12.5, 12.5}, 6), "12.5");
  EXPECT_EQ(labels({0, 0}, 6), "0");
  EXPECT_EQ(round_ticks({0.0, 1e-310}, 6).size(), 2u);
}

TEST(FindFontTest, a_missing_font_is_an_error_that_names_the_package) {
  const std::vector<fs::path> files = {"/nowhere/a.ttf", "/nowhere/b.ttf"};
  try {
    find_font(files);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(
        std::string(error.what()),
        "/nowhere/a.ttf: missing font for the legend; expected DejaVu Sans (Debian: fonts-dejavu-core)");
  }
  EXPECT_THROW(find_font(std::span<const fs::path>()), Error);
}

TEST(FontTest, what_is_no_font_is_an_error) {
  EXPECT_THROW(Font("/nowhere/a.ttf"), Error);
  EXPECT_THROW(Font("/proc/self/exe"), Error);
}

constexpr Rgb8 k_white{255, 255, 255}, k_black{0, 0, 0};

Canvas written(const Font& font, const std::string& text, int size) {
  Canvas canvas(60, 60, k_white);
  font.draw(canvas, 10, 40, text, size, k_black);
  return canvas;
}

/// Whether a pixel is much darker than paper.
bool is_dark(const Rgb8& color) {
  return color[0] < 128 && color[1] < 128 && color[2] < 128;
}

int dark_pixels(const Canvas& canvas, const PixelBox& box) {
  int count = 0;
  for (int y = std::max(box.top, 0); y < std::min(box.bottom, canvas.height()); ++y) {
    for (int x = std::max(box.left, 0); x < std::min(box.right, canvas.width()); ++x)
      count += is_dark(canvas.at(x, y)) ? 1 : 0;
  }
  return count;
}

TEST(FontTest, ink_stays_within_what_is_measured) {
  const Font font(find_font());
  const Canvas canvas = written(font, "Hg", 20);
  const TextExtent extent = font.measure("Hg", 20);
  const PixelBox box{10, 40 - extent.ascent, 10 + extent.width, 40 + extent.descent};
  EXPECT_GT(dark_pixels(canvas, box), 30);
  EXPECT_EQ(dark_pixels(canvas, box), dark_pixels(canvas, {0, 0, 60, 60}));
  EXPECT_GT(extent.descent, 2);
  EXPECT_EQ(font.measure("H", 20).descent, 0);
  EXPECT_EQ(font.measure("", 20).width, 0);
  EXPECT_NEAR(font.measure("HgHg", 20).width, 2 * extent.width, 1);
  EXPECT_GT(font.measure("Hg", 40).width, 3 * extent.width / 2);
}

TEST(FontTest, characters_of_utf_8_have_their_own_shape_and_wrong_bytes_are_no_harm) {
  const Font font(find_font());
  const std::vector<std::uint8_t> unknown = written(font, "\xEF\xBF\xBD", 20).bytes();
  for (const char* const character : {"\xC3\xA9", "\xC2\xB0", "\xE2\x88\x92", "\xE2\x82\xAC"}) {
    EXPECT_NE(written(font, character, 20).bytes(), unknown) << character;
    EXPECT_GT(dark_pixels(written(font, character, 20), {0, 0, 60, 60}), 5) << character;
  }
  for (const char* const wrong : {"\xC3", "\x80", "\xFF", "\xE2\x88", "\xF8\x80\x80\x80"})
    EXPECT_GT(font.measure(wrong, 20).width, 0) << wrong;
  EXPECT_EQ(written(font, "\xFF", 20).bytes(), unknown);
}

TEST(FontTest, text_is_cut_off_at_the_edges) {
  const Font font(find_font());
  Canvas canvas(8, 8, k_white);
  font.draw(canvas, -30, 5, "WWWWWWWW", 20, k_black);
  font.draw(canvas, 0, -100, "W", 20, k_black);
  font.draw(canvas, 4, 100, "W", 80, k_black);
  EXPECT_GT(dark_pixels(canvas, {0, 0, 8, 8}), 0);
}

ColorKey height_key() {
  ColorKey key{.by = PointColor::height, .word = "height", .title = "Height", .unit = "m", .point_count = 10};
  key.scale = ColorScale{.map = ColorMap::viridis,
                         .range = {599.5, 611.5},
                         .extent = {598.0, 623.0},
                         .percentiles = ValueRange{1, 99}};
  return key;
}

ColorKey class_key() {
  ColorKey key{.by = PointColor::classification, .word = "classification", .title = "Classification"};
  key.swatches = {{Color16(0xa8a8, 0x7474, 0x4343), "2", "Ground", 246048},
                  {Color16(0xd8d8, 0x7474, 0x5a5a), "6", "Building", 159517},
                  {Color16(0x3b3b, 0x8f8f, 0xd6d6), "70",
                   "Stra\xC3\x9F"
                   "e",
                   332}};
  key.point_count = 246048 + 159517 + 332 + 4;
  key.missing_count = 4;
  return key;
}

Rgb8 rounded(const Color16& color) {
  Rgb8 result;
  for (int i = 0; i < 3; ++i)
    result[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::lround(color[i] / 257.0));
  return result;
}

const LegendText& text_of(const LegendLayout& layout, const std::string& text) {
  const auto found = std::ranges::find(layout.texts, text, &LegendText::text);
  if (found == layout.texts.end()) throw std::runtime_error("no text " + text);
  return *found;
}

class LegendTest : public ::testing::Test {
 protected:
  LegendTest()
      : folder_(std::filesystem::temp_directory_path() / ("legend_test_" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~LegendTest() override { fs::remove_all(folder_); }
  std::string content(const fs::path& file) const {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder_)) all.push_back(entry.path().filename().string());
    return all;
  }

  const Font font_{find_font()};
  fs::path folder_;
};

TEST_F(LegendTest, rows_of_the_bar_have_the_colours_of_their_values) {
  const ColorKey key = height_key();
  const LegendLayout layout = lay_out_legend(key, font_);
  const Canvas canvas = draw_legend(key, layout, font_);
  ASSERT_GT(layout.bar.height(), 200);
  for (int y = layout.bar.top; y < layout.bar.bottom; ++y) {
    const double share = (layout.bar.bottom - 1.0 - y) / (layout.bar.height() - 1.0);
    const Rgb8 expected = rounded(to_color16(map_color(ColorMap::viridis, share)));
    EXPECT_EQ(canvas.at(layout.bar.left, y), expected);
    EXPECT_EQ(canvas.at(layout.bar.right - 1, y), expected);
  }
  EXPECT_EQ(canvas.at(layout.bar.left, layout.bar.top),
            rounded(to_color16(map_color(ColorMap::viridis, 1.0))));
  EXPECT_TRUE(is_dark(canvas.at(layout.bar.left - 1, layout.bar.top)));
  EXPECT_TRUE(is_dark(canvas.at(layout.bar.left, layout.bar.bottom)));
  EXPECT_EQ(canvas.at(0, 0), k_white);
  EXPECT_EQ(canvas.at(layout.width - 1, layout.height - 1), k_white);
}

TEST_F(LegendTest, ticks_are_at_their_values_with_their_labels_beside_them) {
  const ColorKey key = height_key();
  const LegendLayout layout = lay_out_legend(key, font_);
  const Canvas canvas = draw_legend(key, layout, font_);
  ASSERT_EQ(layout.ticks.size(), 6u);
  for (std::size_t i = 0; i < layout.ticks.size(); ++i) {
    const LegendTick& tick = layout.ticks[i];
    EXPECT_EQ(tick.value, 600.0 + 2.0 * static_cast<double>(i));
    const double share = (611.5 - tick.value) / 12.0;
    EXPECT_EQ(tick.y, layout.bar.top + std::lround(share * (layout.bar.height() - 1)));
    EXPECT_TRUE(is_dark(canvas.at(layout.bar.right + 2, tick.y)));
    EXPECT_EQ(canvas.at(layout.bar.right + 2, tick.y - 2), k_white);
    const LegendText& label = text_of(layout, std::to_string(600 + 2 * i));
    const TextExtent extent = font_.measure(label.text, label.size);
    EXPECT_NEAR(label.baseline - 0.5 * extent.ascent, tick.y, 1.5);
    EXPECT_GT(label.x, layout.bar.right + 3);
  }
}

TEST_F(LegendTest, one_value_has_its_colour_and_its_tick_in_the_middle) {
  ColorKey key = height_key();
  key.scale->range = key.scale->extent = {7.0, 7.0};
  const LegendLayout layout = lay_out_legend(key, font_);
  ASSERT_EQ(layout.ticks.size(), 1u);
  EXPECT_NEAR(layout.ticks[0].y, 0.5 * (layout.bar.top + layout.bar.bottom), 1.0);
  const Canvas canvas = draw_legend(key, layout, font_);
  EXPECT_EQ(canvas.at(layout.bar.left, layout.bar.top), canvas.at(layout.bar.left, layout.bar.bottom - 1));
  EXPECT_EQ(canvas.at(layout.bar.left, layout.bar.top),
            rounded(to_color16(map_color(ColorMap::viridis, 0.5))));
}

TEST_F(LegendTest, swatches_are_one_below_the_other_with_names_counts_and_shares) {
  const ColorKey key = class_key();
  const LegendLayout layout = lay_out_legend(key, font_);
  const Canvas canvas = draw_legend(key, layout, font_);
  ASSERT_EQ(layout.swatches.size(), 4u);
  for (std::size_t i = 0; i < layout.swatches.size(); ++i) {
    const LegendSwatch& swatch = layout.swatches[i];
    EXPECT_EQ(swatch.color, i < 3 ? key.swatches[i].color : k_no_value_color);
    for (const glm::ivec2 pixel : {glm::ivec2(swatch.box.left, swatch.box.top),
                                   glm::ivec2(swatch.box.right - 1, swatch.box.bottom - 1)})
      EXPECT_EQ(canvas.at(pixel.x, pixel.y), rounded(swatch.color));
    EXPECT_TRUE(is_dark(canvas.at(swatch.box.left - 1, swatch.box.top)));
    const int end_above = i > 0 ? layout.swatches[i - 1].box.bottom : 0;
    EXPECT_GT(swatch.box.top, end_above + 1);
  }
  const auto expect_row = [&](const std::string& text, std::size_t row) {
    const LegendText& placed = text_of(layout, text);
    EXPECT_GT(placed.baseline, layout.swatches[row].box.top) << text;
    EXPECT_LT(placed.baseline, layout.swatches[row].box.bottom) << text;
    EXPECT_GT(placed.x, layout.swatches[row].box.right) << text;
  };
  expect_row("Ground", 0);
  expect_row("246 048", 0);
  expect_row("60.6 %", 0);
  expect_row("Building", 1);
  expect_row(
      "Stra\xC3\x9F"
      "e",
      2);
  expect_row("70", 2);
  expect_row("< 0.1 %", 2);
  expect_row("no value", 3);
}

TEST_F(LegendTest, every_text_is_there_and_inside) {
  for (const ColorKey& key : {height_key(), class_key()}) {
    const LegendLayout layout = lay_out_legend(key, font_);
    const Canvas canvas = draw_legend(key, layout, font_);
    for (const LegendText& text : layout.texts) {
      const TextExtent extent = font_.measure(text.text, text.size);
      const PixelBox box{text.x, text.baseline - extent.ascent, text.x + extent.width,
                         text.baseline + extent.descent};
      EXPECT_GT(dark_pixels(canvas, box), static_cast<int>(text.text.size())) << text.text;
      EXPECT_TRUE(box.left > 0 && box.top > 0 && box.right < layout.width && box.bottom < layout.height)
          << text.text;
    }
    // Nothing dark in the margin.
    EXPECT_EQ(dark_pixels(canvas, {0, 0, layout.width, 8}), 0);
    EXPECT_EQ(dark_pixels(canvas, {layout.width - 8, 0, layout.width, layout.height}), 0);
  }
  const LegendLayout layout = lay_out_legend(height_key(), font_);
  EXPECT_EQ(layout.texts.front().text, "Height (m)");
  EXPECT_TRUE(text_of(layout, "percentiles 1 to 99").is_note);
  EXPECT_TRUE(text_of(layout, "all: 598 to 623").is_note);
}

TEST_F(LegendTest, ticks_of_times_count_from_their_origin) {
  ColorKey key = height_key();
  key.by = PointColor::gps_time;
  key.scale->range = key.scale->extent = {402000025.5, 402002625.5};
  key.scale->origin = 402000025.0;
  key.scale->origin_text = "0 s = 2024-06-09 20:27:05 GPS time";
  const LegendLayout layout = lay_out_legend(key, font_);
  EXPECT_EQ(text_of(layout, "500").size, k_legend_font_size);
  EXPECT_TRUE(text_of(layout, key.scale->origin_text).is_note);
  EXPECT_EQ(layout.ticks[0].value, 402000525.0);
}

TEST_F(LegendTest, a_given_size_is_kept_and_filled) {
  for (const ColorKey& key : {height_key(), class_key()}) {
    for (const glm::ivec2 size : {glm::ivec2(300, 400), {900, 700}, {500, 1200}, {1500, 500}}) {
      const LegendLayout layout = lay_out_legend(key, font_, size);
      const Canvas canvas = draw_legend(key, layout, font_);
      EXPECT_EQ(canvas.width(), size.x);
      EXPECT_EQ(canvas.height(), size.y);
      for (const LegendText& text : layout.texts) {
        const TextExtent extent = font_.measure(text.text, text.size);
        EXPECT_LT(text.x + extent.width, size.x) << text.text;
        EXPECT_LT(text.baseline + extent.descent, size.y) << text.text;
      }
      EXPECT_GE(layout.bar.height(), key.scale ? size.y / 2 : 0);
    }
  }
  EXPECT_GT(lay_out_legend(class_key(), font_, glm::ivec2(2000, 2000)).font_size, 60);
}

TEST_F(LegendTest, a_size_that_is_too_small_is_an_error_with_the_least) {
  try {
    lay_out_legend(class_key(), font_, glm::ivec2(100, 100));
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.parts().problem, "the legend does not fit the given size");
    EXPECT_EQ(error.parts().found, "100x100");
    int width = 0, height = 0;
    ASSERT_EQ(std::sscanf(error.parts().expected.c_str(), "at least %dx%d pixels", &width, &height), 2);
    EXPECT_NO_THROW(lay_out_legend(class_key(), font_, glm::ivec2(width, height)));
    EXPECT_THROW(lay_out_legend(class_key(), font_, glm::ivec2(width - 1, height)), Error);
    EXPECT_THROW(lay_out_legend(class_key(), font_, glm::ivec2(width, height - 1)), Error);
  }
}

TEST_F(LegendTest, colours_that_mean_nothing_have_no_legend) {
  EXPECT_THROW(lay_out_legend(ColorKey(), font_), Error);
  ColorKey nothing = height_key();
  nothing.missing_count = nothing.point_count;
  EXPECT_THROW(lay_out_legend(nothing, font_), Error);
  nothing.point_count = nothing.missing_count = 0;
  EXPECT_THROW(lay_out_legend(nothing, font_), Error);
}

TEST_F(LegendTest, the_file_is_the_drawn_image_and_the_same_bytes_every_time) {
  const ColorKey key = class_key();
  write_legend(key, folder_ / "a.png", {}, false);
  write_legend(key, folder_ / "b.png", {}, false);
  EXPECT_EQ(content(folder_ / "a.png"), content(folder_ / "b.png"));
  const Canvas canvas = draw_legend(key, lay_out_legend(key, font_), font_);
  const auto image = OIIO::ImageInput::open((folder_ / "a.png").string());
  ASSERT_TRUE(image);
  EXPECT_EQ(image->spec().width, canvas.width());
  EXPECT_EQ(image->spec().height, canvas.height());
  ASSERT_EQ(image->spec().nchannels, 3);
  std::vector<std::uint8_t> bytes(canvas.bytes().size());
  ASSERT_TRUE(image->read_image(0, 0, 0, 3, OIIO::TypeUInt8, bytes.data()));
  EXPECT_EQ(bytes, canvas.bytes());
}

TEST_F(LegendTest, the_file_appears_completely_or_not_at_all) {
  const ColorKey key = height_key();
  EXPECT_THROW(write_legend(key, folder_ / "none" / "a.png", {}, false), Error);
  EXPECT_THROW(write_legend(key, folder_ / "a.jpg", {}, false), Error);
  EXPECT_THROW(write_legend(key, folder_ / "a.png", glm::ivec2(10, 10), false), Error);
  EXPECT_THROW(write_legend(ColorKey(), folder_ / "a.png", {}, false), Error);
  EXPECT_TRUE(names().empty());
  std::ofstream(folder_ / "a.png") << "old";
  EXPECT_THROW(write_legend(key, folder_ / "a.png", {}, false), Error);
  EXPECT_EQ(content(folder_ / "a.png"), "old");
  write_legend(key, folder_ / "a.png", {}, true);
  EXPECT_EQ(content(folder_ / "a.png").substr(1, 3), "PNG");
  EXPECT_EQ(names().size(), 1u);
}

}  // namespace
}  // namespace alidade
