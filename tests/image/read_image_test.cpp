// SPDX-License-Identifier: MIT
#include "image/read_image.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/color.h"
#include "base/error.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace image;

namespace {

class ReadSkyImageTest : public ::testing::Test {
 protected:
  ReadSkyImageTest()
      : folder_(std::filesystem::temp_directory_path() / ("alidade_sky_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~ReadSkyImageTest() override { std::filesystem::remove_all(folder_); }

  /// Writes float values, so many channels for each pixel.
  std::filesystem::path write(const std::string& name, OIIO::ImageSpec spec,
                              const std::vector<float>& values) const {
    const std::filesystem::path file = folder_ / name;
    const auto output = OIIO::ImageOutput::create(file.string());
    EXPECT_TRUE(output && output->open(file.string(), spec)) << name;
    EXPECT_TRUE(output->write_image(OIIO::TypeFloat, values.data())) << output->geterror();
    EXPECT_TRUE(output->close());
    return file;
  }

  static std::string message(const std::filesystem::path& file) {
    try {
      read_sky_image(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

std::vector<float> noise(std::size_t count, double largest) {
  Random random;
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(largest * random.unit());
  return values;
}

TEST_F(ReadSkyImageTest, float_images_are_linear) {
  const std::vector<float> values = noise(20 * 10 * 3, 50.0);
  for (const char* const name : {"a.exr", "a.hdr", "a.tif"}) {
    const SkyPixels pixels = read_sky_image(write(name, OIIO::ImageSpec(20, 10, 3, OIIO::TypeFloat), values));
    ASSERT_EQ(pixels.width, 20);
    ASSERT_EQ(pixels.height, 10);
    ASSERT_EQ(pixels.values.size(), 200u);
    EXPECT_EQ(pixels.warning, "");
    for (std::size_t i = 0; i < values.size(); ++i) {
      // HDR shares one exponent among three values.
      const double error = std::string(name) == "a.hdr" ? 0.5 : 0.0;
      ASSERT_NEAR(pixels.values[i / 3][static_cast<int>(i % 3)], values[i], error) << name;
    }
  }
}

TEST_F(ReadSkyImageTest, whole_number_images_are_srgb) {
  std::vector<float> values(256 * 3);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i / 3) / 255.0f;
  for (const auto& type : {OIIO::TypeUInt8, OIIO::TypeUInt16}) {
    for (const char* const name : {"a.png", "a.tif"}) {
      const SkyPixels pixels = read_sky_image(write(name, OIIO::ImageSpec(16, 16, 3, type), values));
      for (std::size_t code = 0; code < 256; ++code)
        ASSERT_NEAR(pixels.values[code].g, linear_from_srgb(static_cast<double>(code) / 255.0), 1e-6) << name;
    }
  }
}

TEST_F(ReadSkyImageTest, alpha_and_further_channels_are_not_looked_at) {
  std::vector<float> values(8 * 4 * 4);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 4 == 3 ? 0.5f : 0.2f;
  for (const char* const name : {"a.exr", "a.png"}) {
    const SkyPixels pixels = read_sky_image(write(name, OIIO::ImageSpec(8, 4, 4, OIIO::TypeHalf), values));
    // PNG holds colours that are not multiplied with alpha.
    const double expected = std::string(name) == "a.exr" ? 0.2 : linear_from_srgb(0.4);
    for (const Rgb& value : pixels.values) ASSERT_NEAR(value.b, expected, 0.005) << name;
  }
}

TEST_F(ReadSkyImageTest, one_channel_is_grey) {
  const std::vector<float> values = noise(8 * 4, 2.0);
  const SkyPixels pixels = read_sky_image(write("a.exr", OIIO::ImageSpec(8, 4, 1, OIIO::TypeFloat), values));
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(pixels.values[i], Rgb(values[i]));
}

TEST_F(ReadSkyImageTest, values_that_are_no_light_are_put_right_and_told) {
  std::vector<float> values(8 * 4 * 3, 1.0f);
  values[0] = NAN;
  values[4] = -0.5f;
  values[8] = INFINITY;
  values[9] = 1e20f;
  values[10] = -INFINITY;
  const SkyPixels pixels = read_sky_image(write("a.exr", OIIO::ImageSpec(8, 4, 3, OIIO::TypeFloat), values));
  EXPECT_EQ(pixels.values[0], Rgb(0.0f, 1.0f, 1.0f));
  EXPECT_EQ(pixels.values[1], Rgb(1.0f, 0.0f, 1.0f));
  EXPECT_EQ(pixels.values[2], Rgb(1.0f, 1.0f, 65504.0f));
  EXPECT_EQ(pixels.values[3], Rgb(1e9f, 0.0f, 1.0f));
  EXPECT_NE(pixels.warning.find("a.exr: 5 invalid radiances"), std::string::npos) << pixels.warning;
}

TEST_F(ReadSkyImageTest, a_file_that_ends_early_is_an_error) {
#ifdef __SANITIZE_ADDRESS__
  // libpng leaves OpenImageIO by a long jump, over the end of a string, which is then not freed.
  const __lsan::ScopedDisabler leaks_of_libpng;
#endif
  const std::vector<float> values = noise(64 * 32 * 3, 1.0);
  for (const char* const name : {"a.exr", "a.hdr", "a.png", "a.tif"}) {
    const auto type = std::string(name) == "a.png" ? OIIO::TypeUInt8 : OIIO::TypeFloat;
    const std::filesystem::path file = write(name, OIIO::ImageSpec(64, 32, 3, type), values);
    const auto size = std::filesystem::file_size(file);
    for (const double share : {0.9, 0.5, 0.1, 0.0}) {
      std::filesystem::resize_file(file, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
      EXPECT_NE(message(file), "no error") << name << " " << share;
      EXPECT_TRUE(message(file).starts_with(file.string() + ": ")) << message(file);
      // Both PNG libraries report it; one message contains the other.
      const std::string said = message(file), part = "hit end of file";
      EXPECT_EQ(said.find(part), said.rfind(part)) << said;
    }
  }
}

TEST_F(ReadSkyImageTest, what_is_no_image_is_an_error) {
  EXPECT_TRUE(message(folder_ / "none.exr").ends_with("none.exr: no such file"));
  EXPECT_TRUE(message(folder_).ends_with(": not a regular file"));
  std::ofstream(folder_ / "text.exr") << "no picture at all";
  EXPECT_NE(message(folder_ / "text.exr").find("cannot read the image"), std::string::npos);
  std::ofstream(folder_ / "text.xyz") << "1 2 3\n";
  EXPECT_NE(message(folder_ / "text.xyz").find("cannot read the image"), std::string::npos);
}

TEST_F(ReadSkyImageTest, a_cut_out_is_an_error) {
  OIIO::ImageSpec spec(8, 4, 3, OIIO::TypeFloat);
  spec.full_width = 16;
  spec.full_height = 8;
  const std::string said = message(write("a.exr", spec, noise(8 * 4 * 3, 1.0)));
  EXPECT_NE(said.find("the image is a crop; expected all 16 x 8 pixels, found 8 x 4"), std::string::npos)
      << said;
}

/// The start of a PNG file that claims this size.
std::string png_of_size(std::uint32_t width, std::uint32_t height) {
  const auto big_endian = [](std::uint32_t value) {
    return std::string{static_cast<char>(value >> 24), static_cast<char>(value >> 16),
                       static_cast<char>(value >> 8), static_cast<char>(value)};
  };
  std::string header =
      "IHDR" + big_endian(width) + big_endian(height) + std::string("\x08\x02\x00\x00\x00", 5);
  std::uint32_t crc = 0xffffffffu;
  for (const char character : header) {
    crc ^= static_cast<unsigned char>(character);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  return "\x89PNG\r\n\x1a\n" + big_endian(13) + header + big_endian(~crc) + big_endian(0) + "IDAT" +
         big_endian(0x35af061e);
}

TEST_F(ReadSkyImageTest, a_size_beyond_the_limit_or_beyond_the_file_is_an_error_before_memory_is_taken) {
  std::ofstream(folder_ / "huge.png") << png_of_size(40000, 40000);
  EXPECT_NE(message(folder_ / "huge.png").find("too large for a sky; expected at most 134217728 pixels"),
            std::string::npos)
      << message(folder_ / "huge.png");
  std::ofstream(folder_ / "hollow.png") << png_of_size(16384, 8192);
  EXPECT_NE(message(folder_ / "hollow.png").find("the file is too short for its pixels"), std::string::npos)
      << message(folder_ / "hollow.png");
}

class ReadPhotoTest : public ReadSkyImageTest {
 protected:
  static std::string photo_message(const std::filesystem::path& file) {
    try {
      read_photo(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST_F(ReadPhotoTest, values_are_those_that_are_displayed) {
  std::vector<float> values;
  for (int i = 0; i < 20 * 10 * 3; ++i) values.push_back(static_cast<float>(i % 256) / 255.0f);
  for (const OIIO::TypeDesc type : {OIIO::TypeUInt8, OIIO::TypeUInt16}) {
    const auto file = write("a.tif", OIIO::ImageSpec(20, 10, 3, type), values);
    EXPECT_EQ(photo_size(file), (ImageSize{20, 10}));
    const PhotoPixels pixels = read_photo(file);
    ASSERT_EQ(pixels.size, (ImageSize{20, 10}));
    ASSERT_EQ(pixels.values.size(), 200u);
    for (int i = 0; i < 20 * 10 * 3; ++i)
      ASSERT_EQ(pixels.values[static_cast<std::size_t>(i / 3)][static_cast<std::size_t>(i % 3)], i % 256);
  }
}

TEST_F(ReadPhotoTest, one_channel_is_grey_and_alpha_is_ignored) {
  using Color = std::array<std::uint8_t, 3>;
  EXPECT_EQ(read_photo(write("g.png", OIIO::ImageSpec(1, 1, 1, OIIO::TypeUInt8), {0.2f})).values[0],
            (Color{51, 51, 51}));
  EXPECT_EQ(read_photo(write("a.png", OIIO::ImageSpec(1, 1, 4, OIIO::TypeUInt8), {0.2f, 0.4f, 0.6f, 0.0f}))
                .values[0],
            (Color{51, 102, 153}));
}

TEST_F(ReadPhotoTest, what_is_no_photo_is_an_error) {
  const auto light = write("light.exr", OIIO::ImageSpec(2, 2, 3, OIIO::TypeFloat), noise(12, 5.0));
  EXPECT_NE(photo_message(light).find("light.exr: a photo with floating-point values"), std::string::npos);
  EXPECT_NE(photo_message(folder_ / "absent.jpg").find("no such file"), std::string::npos);
  std::ofstream(folder_ / "text.jpg") << "no picture";
  EXPECT_NE(photo_message(folder_ / "text.jpg").find("cannot read the image"), std::string::npos);
  const auto whole = write("cut.tif", OIIO::ImageSpec(50, 50, 3, OIIO::TypeUInt8), noise(7500, 1.0));
  std::filesystem::resize_file(whole, std::filesystem::file_size(whole) / 2);
  EXPECT_NE(photo_message(whole), "no error");
}

}  // namespace
}  // namespace alidade::test
