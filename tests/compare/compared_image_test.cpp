// SPDX-License-Identifier: MIT
#include "compare/read_compared_image.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <filesystem>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace alidade::test {

using namespace compare;

namespace {

class ComparedImageTest : public ::testing::Test {
 protected:
  ComparedImageTest()
      : folder_(std::filesystem::temp_directory_path() / ("compared_image_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~ComparedImageTest() override { std::filesystem::remove_all(folder_); }

  /// Writes `values` of the type of `spec` and returns the file's path.
  template <typename Value>
  std::filesystem::path written(const std::string& name, const OIIO::ImageSpec& spec,
                                const std::vector<Value>& values) const {
    const std::filesystem::path file = folder_ / name;
    const auto output = OIIO::ImageOutput::create(file.string());
    EXPECT_TRUE(output && output->open(file.string(), spec)) << OIIO::geterror();
    EXPECT_TRUE(output->write_image(OIIO::BaseTypeFromC<Value>::value, values.data())) << output->geterror();
    output->close();
    return file;
  }

  static std::string error_of(const std::filesystem::path& file) {
    try {
      read_compared_image(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

std::vector<std::uint8_t> counting(std::size_t count) {
  std::vector<std::uint8_t> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<std::uint8_t>(7 * i + 3);
  return values;
}

TEST_F(ComparedImageTest, eight_bit_files_hold_display_codes_and_alpha_is_not_multiplied_in) {
  const std::vector<std::uint8_t> values = counting(5 * 3 * 4);
  OIIO::ImageSpec spec(5, 3, 4, OIIO::TypeUInt8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  const ComparedImage image = read_compared_image(written("a.png", spec, values));
  EXPECT_EQ(image.width, 5);
  EXPECT_EQ(image.height, 3);
  EXPECT_EQ(image.encoding, ColorEncoding::display);
  EXPECT_EQ(image.color_channels, 3);
  EXPECT_EQ(image.largest_code, 255);
  ASSERT_EQ(image.color.size(), 45u);
  ASSERT_EQ(image.alpha.size(), 15u);
  for (std::size_t pixel = 0; pixel < 15; ++pixel) {
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(std::lround(image.color[3 * pixel + i] * 255.0f), values[4 * pixel + i]) << pixel;
    EXPECT_EQ(std::lround(image.alpha[pixel] * 255.0f), values[4 * pixel + 3]) << pixel;
  }
}

TEST_F(ComparedImageTest, one_channel_is_grey_copied_to_three) {
  const ComparedImage image = read_compared_image(
      written("grey.png", OIIO::ImageSpec(2, 1, 1, OIIO::TypeUInt8), std::vector<std::uint8_t>{10, 200}));
  EXPECT_EQ(image.color_channels, 1);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(std::lround(image.color[i] * 255.0f), i < 3 ? 10 : 200);
}

TEST_F(ComparedImageTest, sixteen_bit_codes_are_kept) {
  const ComparedImage image = read_compared_image(written("a.tif", OIIO::ImageSpec(1, 1, 3, OIIO::TypeUInt16),
                                                          std::vector<std::uint16_t>{1, 257, 65534}));
  EXPECT_EQ(image.encoding, ColorEncoding::display);
  EXPECT_EQ(image.largest_code, 65535);
  EXPECT_EQ(std::lround(image.color[0] * 65535.0f), 1);
  EXPECT_EQ(std::lround(image.color[1] * 65535.0f), 257);
  EXPECT_EQ(std::lround(image.color[2] * 65535.0f), 65534);
}

TEST_F(ComparedImageTest, float_files_hold_linear_light_and_layers_with_whole_ids) {
  constexpr float k_infinity = std::numeric_limits<float>::infinity();
  OIIO::ImageSpec spec(2, 1, 9, OIIO::TypeFloat);
  spec.channelnames = {"R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z", "id"};
  spec.channelformats.assign(9, OIIO::TypeFloat);
  spec.channelformats[8] = OIIO::TypeUInt;
  spec.attribute("alidade:seed", "7");
  const auto bits = [](float value) {
    std::uint32_t result;
    std::memcpy(&result, &value, 4);
    return result;
  };
  std::vector<std::uint32_t> values;
  for (const float value : {9.0f, -1.0f, 0.5f, 1.0f, 12.5f, 0.0f, 0.6f, 0.8f}) values.push_back(bits(value));
  values.push_back(4294967295u);
  for (const float value : {0.0f, 0.0f, 0.0f, 0.0f, k_infinity, 0.0f, 0.0f, 0.0f})
    values.push_back(bits(value));
  values.push_back(16777217u);
  const std::filesystem::path file = folder_ / "layers.exr";
  const auto output = OIIO::ImageOutput::create(file.string());
  ASSERT_TRUE(output->open(file.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeUnknown, values.data()));
  output->close();

  const ComparedImage image = read_compared_image(file);
  EXPECT_EQ(image.encoding, ColorEncoding::linear);
  EXPECT_EQ(image.largest_code, 0);
  EXPECT_EQ(image.color, (std::vector<float>{9.0f, -1.0f, 0.5f, 0.0f, 0.0f, 0.0f}));
  EXPECT_EQ(image.alpha, (std::vector<float>{1.0f, 0.0f}));
  EXPECT_EQ(image.depth, (std::vector<float>{12.5f, k_infinity}));
  EXPECT_EQ(image.normals, (std::vector<float>{0.0f, 0.6f, 0.8f, 0.0f, 0.0f, 0.0f}));
  EXPECT_EQ(image.ids, (std::vector<std::uint32_t>{4294967295u, 16777217u}));
  const auto seed =
      std::ranges::find(image.metadata, "alidade:seed", [](const auto& pair) { return pair.first; });
  ASSERT_NE(seed, image.metadata.end());
  EXPECT_EQ(seed->second, "7");
}

TEST_F(ComparedImageTest, ids_of_floating_point_are_taken_if_they_are_exact_whole_numbers) {
  OIIO::ImageSpec spec(3, 1, 1, OIIO::TypeFloat);
  spec.channelnames = {"id"};
  const auto floats = [&](float last) { return written("ids.exr", spec, std::vector<float>{0, 7, last}); };
  EXPECT_EQ(read_compared_image(floats(16777215.0f)).ids, (std::vector<std::uint32_t>{0, 7, 16777215}));
  const float not_a_number = std::numeric_limits<float>::quiet_NaN();
  for (const float wrong : {16777216.0f, 1.5f, -1.0f, not_a_number})
    EXPECT_NE(error_of(floats(wrong)).find("ids.exr: the id layer contains a value that is not an integer"),
              std::string::npos)
        << wrong;
  // Half of them: 2049 is stored as 2048.
  spec.set_format(OIIO::TypeHalf);
  EXPECT_EQ(read_compared_image(floats(2047.0f)).ids, (std::vector<std::uint32_t>{0, 7, 2047}));
  EXPECT_NE(error_of(floats(2049.0f)).find("the id layer contains a value that is not an integer"),
            std::string::npos);
}

TEST_F(ComparedImageTest, blank_images_that_compress_well_are_images) {
  // A page of paper: a million white pixels in some hundred bytes.
  OIIO::ImageSpec spec(1200, 900, 1, OIIO::TypeUInt8);
  spec.attribute("oiio:BitsPerSample", 1);
  spec.attribute("compression", "ccittfax4");
  const auto file = written("blank.tif", spec, std::vector<std::uint8_t>(1200 * 900, 255));
  EXPECT_LT(std::filesystem::file_size(file), 2000u);
  const ComparedImage image = read_compared_image(file);
  ASSERT_EQ(image.color.size(), 3u * 1200 * 900);
  EXPECT_EQ(image.color.back(), 1.0f);
}

TEST_F(ComparedImageTest, layers_are_found_among_hundreds_of_other_channels) {
  constexpr int k_channels = 300;
  OIIO::ImageSpec spec(5, 70, k_channels, OIIO::TypeFloat);
  for (int i = 0; i < k_channels; ++i)
    spec.channelnames[static_cast<std::size_t>(i)] = "extra" + std::to_string(i);
  const std::vector<std::pair<int, const char*>> named{
      {3, "Z"}, {7, "R"}, {150, "G"}, {151, "B"}, {299, "A"}};
  for (const auto& [channel, name] : named) spec.channelnames[static_cast<std::size_t>(channel)] = name;
  std::vector<float> values(5 * 70 * k_channels);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
  const ComparedImage image = read_compared_image(written("many.exr", spec, values));
  ASSERT_EQ(image.pixels(), 350u);
  for (std::size_t pixel = 0; pixel < 350; ++pixel) {
    const float* const all = &values[pixel * k_channels];
    EXPECT_EQ(image.depth[pixel], all[3]);
    EXPECT_EQ(image.alpha[pixel], all[299]);
    EXPECT_EQ(image.color[3 * pixel], all[7]);
    EXPECT_EQ(image.color[3 * pixel + 1], all[150]);
    EXPECT_EQ(image.color[3 * pixel + 2], all[151]);
  }
}

TEST_F(ComparedImageTest, a_file_with_layers_only_has_no_colour) {
  OIIO::ImageSpec spec(2, 2, 1, OIIO::TypeFloat);
  spec.channelnames = {"Z"};
  const ComparedImage image = read_compared_image(written("depth.exr", spec, std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(image.color_channels, 0);
  EXPECT_TRUE(image.color.empty());
  EXPECT_EQ(image.depth, (std::vector<float>{1, 2, 3, 4}));
}

// An image of 3 x 2 pixels seen upright is
//   a b c
//   d e f
// Stored with orientation N its row 0 and column 0 are the sides that the Exif table (tag 274) names.
TEST_F(ComparedImageTest, every_exif_orientation_gives_the_upright_image) {
  struct Stored {
    int orientation, width;
    const char* pixels;
  };
  for (const Stored& stored :
       {Stored{1, 3, "abcdef"}, Stored{2, 3, "cbafed"}, Stored{3, 3, "fedcba"}, Stored{4, 3, "defabc"},
        Stored{5, 2, "adbecf"}, Stored{6, 2, "cfbead"}, Stored{7, 2, "fcebda"}, Stored{8, 2, "daebfc"}}) {
    OIIO::ImageSpec spec(stored.width, 6 / stored.width, 1, OIIO::TypeUInt8);
    spec.attribute("Orientation", stored.orientation);
    const std::string pixels = stored.pixels;
    const ComparedImage image = read_compared_image(
        written("turned.tif", spec, std::vector<std::uint8_t>(pixels.begin(), pixels.end())));
    std::string upright;
    for (std::size_t i = 0; i < image.pixels(); ++i)
      upright += static_cast<char>(std::lround(image.color[3 * i] * 255.0f));
    EXPECT_EQ(image.width, 3) << stored.orientation;
    EXPECT_EQ(upright, "abcdef") << stored.orientation;
  }
}

TEST_F(ComparedImageTest, sigma_is_read_and_turned_with_its_depth) {
  OIIO::ImageSpec spec(2, 1, 2, OIIO::TypeFloat);
  spec.channelnames = {"Z", "depth.sigma"};
  spec.attribute("Orientation", 3);
  const ComparedImage image =
      read_compared_image(written("turned.exr", spec, std::vector<float>{4.0f, 0.5f, 8.0f, 0.25f}));
  EXPECT_EQ(image.depth, (std::vector<float>{8.0f, 4.0f}));
  EXPECT_EQ(image.depth_sigma, (std::vector<float>{0.25f, 0.5f}));
  spec.channelnames = {"depth.sigma", "other"};
  EXPECT_NE(error_of(written("sigma.exr", spec, std::vector<float>(4))).find("nothing to compare"),
            std::string::npos);
}

// 8 x 8 pixels of cyan 55, magenta 155, yellow 255 and black 205 of 255, which Adobe's files count from full
// ink to none: each ink lets through its value, black 205 / 255 of that: 44.2, 124.6 and 205. Quantised by
// the compression.
TEST_F(ComparedImageTest, cmyk_becomes_rgb) {
  const std::string digits =
      "ffd8ffee000e41646f626500640000000000ffdb004300100b0c0e0c0a100e0d0e1211101318281a"
      "181616183123251d283a333d3c3933383740485c4e404457453738506d51575f626768673e4d7179"
      "7064785c656763ffc000140800080008044311004d11005911004b1100ffc4001600010101000000"
      "00000000000000000000060407ffc40014100100000000000000000000000000000000ffda000e04"
      "43004d0059004b00003f0034b9a013bfffd9";
  const std::filesystem::path file = folder_ / "inks.jpg";
  std::ofstream stream(file, std::ios::binary);
  for (std::size_t i = 0; i < digits.size(); i += 2)
    stream.put(static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  stream.close();
  const ComparedImage image = read_compared_image(file);
  EXPECT_EQ(image.color_channels, 3);
  EXPECT_EQ(image.pixels(), 64u);
  constexpr double k_expected[] = {44.2, 124.6, 205.0};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(image.color[3 * 27 + i] * 255.0, k_expected[i], 2.0);
}

TEST_F(ComparedImageTest, what_is_no_image_is_an_error_that_names_the_file) {
  const std::filesystem::path text = folder_ / "text.png";
  std::ofstream(text) << "cannot read the image";
  const std::filesystem::path empty = folder_ / "empty.exr";
  std::ofstream{empty};
  EXPECT_NE(error_of(text).find("text.png: cannot read the image"), std::string::npos) << error_of(text);
  EXPECT_NE(error_of(empty).find("empty.exr: "), std::string::npos) << error_of(empty);
  EXPECT_NE(error_of(folder_ / "none.png").find("none.png: no such file"), std::string::npos);
  EXPECT_NE(error_of(folder_).find("not a regular file"), std::string::npos);
}

TEST_F(ComparedImageTest, an_image_of_no_pixels_is_an_error_that_names_the_file) {
  for (const char* const size : {"0 0", "0 4", "4 0"}) {
    const std::filesystem::path file = folder_ / "none.ppm";
    std::ofstream(file, std::ios::binary) << "P6\n" << size << "\n255\n";
    EXPECT_NE(error_of(file).find("none.ppm: "), std::string::npos) << size << ": " << error_of(file);
  }
}

TEST_F(ComparedImageTest, an_image_cut_short_is_an_error_in_every_format) {
  std::vector<std::uint8_t> values(128 * 96 * 3);
  std::uint32_t state = 1;
  for (std::uint8_t& value : values)
    value = static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
  for (const char* const name : {"a.png", "a.jpg", "a.tif"}) {
    const auto file = written(name, OIIO::ImageSpec(128, 96, 3, OIIO::TypeUInt8), values);
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    EXPECT_NE(error_of(file).find(name), std::string::npos) << name << ": " << error_of(file);
  }
  const auto file =
      written("a.exr", OIIO::ImageSpec(128, 96, 3, OIIO::TypeFloat), std::vector<float>(128 * 96 * 3, 0.3f));
  std::filesystem::resize_file(file, std::filesystem::file_size(file) * 9 / 10);
  EXPECT_NE(error_of(file).find("a.exr"), std::string::npos) << error_of(file);
}

TEST_F(ComparedImageTest, the_srgb_curve_is_undone_for_display_codes_only) {
  ComparedImage image;
  image.width = 1;
  image.height = 1;
  image.color_channels = 3;
  // IEC 61966-2-1: code 188 of 255 is 0.50289 of linear light; 10 is on the straight part, 10 / 255 / 12.92.
  image.color = {188.0f / 255.0f, 10.0f / 255.0f, 1.0f};
  const std::vector<float> linear = linear_color(image);
  EXPECT_NEAR(linear[0], 0.5028865, 2e-7);
  EXPECT_NEAR(linear[1], 0.0030352698, 1e-9);
  EXPECT_EQ(linear[2], 1.0f);
  EXPECT_EQ(display_color(image), image.color);
  image.encoding = ColorEncoding::linear;
  image.color = {0.5028865f, -3.0f, 7.0f};
  EXPECT_EQ(linear_color(image), image.color);
  const std::vector<float> display = display_color(image);
  EXPECT_NEAR(display[0], 188.0 / 255.0, 2e-7);
  EXPECT_EQ(display[1], 0.0f);
  EXPECT_EQ(display[2], 1.0f);
}

TEST_F(ComparedImageTest, another_size_or_position_is_an_error_of_its_own) {
  ComparedImage reference, test;
  reference.width = test.width = 4;
  reference.height = test.height = 3;
  EXPECT_NO_THROW(require_same_size(reference, test));
  test.origin_x = 1;
  EXPECT_THROW(require_same_size(reference, test), SizeMismatch);
  test.origin_x = 0;
  test.height = 4;
  EXPECT_THROW(require_same_size(reference, test), SizeMismatch);
}

TEST_F(ComparedImageTest, a_crop_holds_the_pixels_inside_and_nothing_beyond_is_given) {
  ComparedImage image;
  image.width = 3;
  image.height = 2;
  image.color_channels = 3;
  for (int i = 0; i < 18; ++i) image.color.push_back(static_cast<float>(i));
  image.ids = {1, 2, 3, 4, 5, 6};
  image.depth_sigma = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};
  const ComparedImage part = cropped(image, {1, 1, 3, 2});
  EXPECT_EQ(part.width, 2);
  EXPECT_EQ(part.height, 1);
  EXPECT_EQ(part.color, (std::vector<float>{12, 13, 14, 15, 16, 17}));
  EXPECT_EQ(part.ids, (std::vector<std::uint32_t>{5, 6}));
  EXPECT_EQ(part.depth_sigma, (std::vector<float>{0.5f, 0.6f}));
  EXPECT_TRUE(part.depth.empty());
  EXPECT_THROW(cropped(image, {1, 1, 4, 2}), Error);
  EXPECT_THROW(cropped(image, {-1, 0, 2, 2}), Error);
  EXPECT_THROW(cropped(image, {2, 0, 2, 2}), Error);
}

// The filter alone would leave -4.7 beside a light of 50 on black.
TEST_F(ComparedImageTest, resizing_linear_light_makes_nothing_darker_than_black_or_the_darkest_pixel) {
  ComparedImage image;
  image.width = image.height = 16;
  image.encoding = ColorEncoding::linear;
  image.color_channels = 3;
  image.color.assign(16 * 16 * 3, 0.0f);
  for (std::size_t i = 0; i < 3; ++i) image.color[3 * (8 * 16 + 8) + i] = 50.0f;
  const auto least = [](const ComparedImage& resized_image) {
    return *std::min_element(resized_image.color.begin(), resized_image.color.end());
  };
  EXPECT_EQ(least(resized(image, 8, 8)), 0.0f);
  EXPECT_GT(resized(image, 8, 8).color[3 * (4 * 8 + 4)], 5.0f);
  image.color[0] = -0.25f;
  EXPECT_EQ(least(resized(image, 8, 8)), -0.25f);
}

TEST_F(ComparedImageTest, resizing_filters_colours_and_picks_the_nearest_depth_and_id) {
  ComparedImage image;
  image.width = 8;
  image.height = 8;
  image.color_channels = 3;
  image.color.assign(8 * 8 * 3, 0.25f);
  for (std::uint32_t i = 0; i < 64; ++i) {
    image.ids.push_back(i);
    image.depth.push_back(static_cast<float>(i));
    image.depth_sigma.push_back(0.5f * static_cast<float>(i));
  }
  const ComparedImage small = resized(image, 4, 2);
  EXPECT_EQ(small.width, 4);
  EXPECT_EQ(small.height, 2);
  ASSERT_EQ(small.color.size(), 24u);
  for (const float value : small.color) EXPECT_NEAR(value, 0.25f, 1e-6f);
  EXPECT_EQ(small.ids, (std::vector<std::uint32_t>{17, 19, 21, 23, 49, 51, 53, 55}));
  EXPECT_EQ(small.depth[5], 51.0f);
  EXPECT_EQ(small.depth_sigma[5], 25.5f);
  EXPECT_THROW(resized(image, 0, 4), Error);
  EXPECT_THROW(resized(image, 1 << 20, 1 << 20), Error);
}

}  // namespace
}  // namespace alidade::test
