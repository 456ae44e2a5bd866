// SPDX-License-Identifier: MIT
#include "image/image_file.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>
#include <filesystem>

#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>

#include "base/error.h"
#include "camera/camera_json.h"
#include "image/srgb.h"
#include "renderer/image_metadata.h"
#include "renderer/read_scene.h"
#include "tests/renderer/describe_scene.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

constexpr float k_infinity = std::numeric_limits<float>::infinity();

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Every pixel and value different; the last pixel sees nothing. More rows than are written at once.
Film colorful_film(int width = 13, int height = 70) {
  Random random("colorful_film");
  Film film(width, height);
  const auto color = [&] { return Rgb(random.unit(), random.unit(), random.unit()); };
  for (std::size_t i = 0; i + 1 < film.color.size(); ++i) {
    film.color[i] = 2.0f * color();
    film.alpha[i] = static_cast<float>(random.unit());
    film.variance[i] = 1e-9f * color();
    film.depth_sigma[i] = i % 7 == 0 ? film.depth_sigma[i] : 0.001f * static_cast<float>(i);
    film.coverage[i] = static_cast<float>(i % 17) / 16.0f;
    film.support[i] = static_cast<std::uint32_t>(i % 40);
    film.depth[i] = static_cast<float>(random.between(1, 100));
    film.distance[i] = static_cast<float>(random.between(1, 100));
    film.normal[i] = color();
    film.position[i] = glm::dvec3(690000, 5325000, 500) + 100.0 * random.in_cube();
    film.albedo[i] = color();
    film.id[i] = static_cast<std::uint32_t>(random.bits()) | 1u;
  }
  const std::size_t last = film.color.size() - 1;
  film.depth[last] = film.distance[last] = k_infinity;
  return film;
}

ImageMetadata metadata() {
  ImageMetadata data;
  data.camera = {.width = 13, .height = 70, .fx = 41.0 / 3.0, .fy = 17.3, .cx = 6.5, .cy = 35.0, .pose = {}};
  data.camera.pose.position = {690011.1, 5324912.7, 523.0};
  data.render = {.samples = 9, .max_bounces = 4, .seed = UINT64_MAX};
  data.command = "alidade render site.json -o site.exr";
  data.cloud_files = {"a.las", "b.las"};
  data.cloud_offset = {690000.0, 5325000.0, 0.0};
  data.crs.wkt = "PROJCS[\"WGS 84 / UTM zone 32N\"]";
  data.radius = 0.1;
  data.further = {{"alidade:radius_source", "auto"}};
  return data;
}

class ImageTest : public ::testing::Test {
 protected:
  ImageTest()
      : folder_(std::filesystem::temp_directory_path() / ("image_test_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~ImageTest() override { std::filesystem::remove_all(folder_); }
  OutputSettings output(const std::string& name) const { return {.file = folder_ / name}; }
  static std::string error_of(const Film& film, const OutputSettings& settings, bool overwrite = false) {
    try {
      write_image(film, settings, metadata(), overwrite);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }
  std::filesystem::path folder_;
};

/// An image file as OpenImageIO sees it: one channel at a time.
class ImageFile {
 public:
  explicit ImageFile(const std::filesystem::path& file) : input_(OIIO::ImageInput::open(file.string())) {
    if (!input_) throw std::runtime_error(OIIO::geterror());
  }
  const OIIO::ImageSpec& spec() const { return input_->spec(); }
  std::string text(const std::string& key) const { return std::string(spec().get_string_attribute(key)); }
  OIIO::TypeDesc format(const std::string& name) const {
    return spec().channelformat(spec().channelindex(name));
  }

  template <typename Value>
  std::vector<Value> channel(const std::string& name) {
    const int index = spec().channelindex(name);
    EXPECT_GE(index, 0) << name;
    std::vector<Value> values(static_cast<std::size_t>(spec().width) *
                              static_cast<std::size_t>(spec().height));
    const bool read =
        input_->read_image(0, 0, index, index + 1, OIIO::BaseTypeFromC<Value>::value, values.data());
    EXPECT_TRUE(read) << input_->geterror();
    return values;
  }

 private:
  std::unique_ptr<OIIO::ImageInput> input_;
};

constexpr Layer k_all_layers[] = {Layer::color,       Layer::depth,    Layer::distance, Layer::normal,
                                  Layer::position,    Layer::albedo,   Layer::id,       Layer::variance,
                                  Layer::depth_sigma, Layer::coverage, Layer::support};

TEST_F(ImageTest, exr_holds_every_layer_under_its_conventional_names_and_types) {
  const Film film = colorful_film();
  for (const bool half : {true, false}) {
    OutputSettings settings = output(half ? "half.exr" : "float.exr");
    settings.layers.assign(std::begin(k_all_layers), std::end(k_all_layers));
    settings.half = half;
    write_image(film, settings, metadata(), false);
    ImageFile image(settings.file);
    EXPECT_EQ(image.spec().width, film.width);
    EXPECT_EQ(image.spec().height, film.height);
    EXPECT_EQ(image.spec().nchannels, 22);
    const auto expect = [&](const std::string& name, bool may_be_half, const auto& value_of) {
      const bool is_half = half && may_be_half;
      EXPECT_EQ(image.format(name), is_half ? OIIO::TypeHalf : OIIO::TypeFloat) << name;
      const std::vector<float> values = image.channel<float>(name);
      for (std::size_t i = 0; i < values.size(); ++i) {
        const float expected = value_of(i);
        // Half has 11 bits: rounding is off by at most 2^-11 of the value, or 2^-25 near zero.
        const float tolerance = is_half ? std::max(std::fabs(expected) * 0x1p-11f, 0x1p-25f) : 0.0f;
        if (std::isinf(expected))
          EXPECT_EQ(values[i], expected) << name;
        else
          ASSERT_NEAR(values[i], expected, tolerance) << name << " " << i;
      }
    };
    const std::string rgb = "RGB", xyz = "XYZ";
    for (int c = 0; c < 3; ++c) {
      const std::string color(1, rgb[static_cast<std::size_t>(c)]), axis(1, xyz[static_cast<std::size_t>(c)]);
      expect(color, true, [&](std::size_t i) { return film.color[i][c]; });
      expect("albedo." + color, true, [&](std::size_t i) { return film.albedo[i][c]; });
      expect("variance." + color, false, [&](std::size_t i) { return film.variance[i][c]; });
      expect("N." + axis, true, [&](std::size_t i) { return film.normal[i][c]; });
      expect("P." + axis, false, [&](std::size_t i) {
        const glm::dvec3 offset(690000, 5320000, 0);
        return film.id[i] == 0 ? 0.0f : static_cast<float>(film.position[i][c] - offset[c]);
      });
    }
    expect("A", true, [&](std::size_t i) { return film.alpha[i]; });
    expect("Z", false, [&](std::size_t i) { return film.depth[i]; });
    expect("distance.T", false, [&](std::size_t i) { return film.distance[i]; });
    expect("depth.sigma", false, [&](std::size_t i) { return film.depth_sigma[i]; });
    expect("coverage", false, [&](std::size_t i) { return film.coverage[i]; });
    EXPECT_EQ(image.format("id"), OIIO::TypeUInt);
    EXPECT_EQ(image.channel<std::uint32_t>("id"), film.id);
    EXPECT_EQ(image.format("support"), OIIO::TypeUInt);
    EXPECT_EQ(image.channel<std::uint32_t>("support"), film.support);
  }
}

TEST_F(ImageTest, exr_holds_only_the_requested_layers) {
  OutputSettings settings = output("few.exr");
  settings.layers = {Layer::id, Layer::depth};
  write_image(colorful_film(), settings, metadata(), false);
  std::vector<std::string> names = ImageFile(settings.file).spec().channelnames;
  std::ranges::sort(names);
  EXPECT_EQ(names, (std::vector<std::string>{"Z", "id"}));
}

TEST_F(ImageTest, layer_that_the_film_lacks_is_an_error) {
  OutputSettings settings = output("lacking.exr");
  settings.layers = {Layer::color, Layer::depth};
  constexpr Layer k_color[] = {Layer::color};
  try {
    write_image(Film(4, 4, k_color), settings, metadata(), false);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("the layer depth was not rendered"), std::string::npos);
  }
  EXPECT_FALSE(std::filesystem::exists(settings.file));
}

TEST_F(ImageTest, half_never_becomes_infinite) {
  Film film(1, 1);
  film.color[0] = {1e6f, 65504.0f, 1e-30f};
  write_image(film, output("bright.exr"), ImageMetadata(), false);
  ImageFile image(folder_ / "bright.exr");
  EXPECT_EQ(image.channel<float>("R")[0], 65504.0f);
  EXPECT_EQ(image.channel<float>("G")[0], 65504.0f);
  EXPECT_EQ(image.channel<float>("B")[0], 0.0f);
}

TEST_F(ImageTest, positions_are_precise_far_from_the_origin) {
  OutputSettings settings = output("position.exr");
  settings.layers = {Layer::position};
  const Film film = colorful_film();
  write_image(film, settings, metadata(), false);
  ImageFile image(settings.file);
  EXPECT_EQ(image.text("alidade:position_offset"), "690000 5320000 0");
  const std::vector<float> y = image.channel<float>("P.Y");
  for (std::size_t i = 0; i + 1 < y.size(); ++i) EXPECT_NEAR(5320000.0 + y[i], film.position[i].y, 0.0003);
}

TEST_F(ImageTest, positions_need_no_other_layer) {
  OutputSettings settings = output("position.exr");
  settings.layers = {Layer::position};
  Film film(2, 1, settings.layers);
  film.position[1] = {690012.5, 5320007.25, 3.5};
  write_image(film, settings, metadata(), false);
  ImageFile image(settings.file);
  EXPECT_EQ(image.channel<float>("P.X"), (std::vector<float>{0.0f, 12.5f}));
  EXPECT_EQ(image.channel<float>("P.Y"), (std::vector<float>{0.0f, 7.25f}));
}

TEST(PositionOffsetTest, is_zero_near_the_origin_and_round_elsewhere) {
  Camera camera;
  camera.pose.position = {-4999, 4999, 0};
  EXPECT_EQ(position_offset(camera), glm::dvec3(0.0));
  EXPECT_FALSE(std::signbit(position_offset(camera).x));
  camera.pose.position = {-15001, 684999, 1e7};
  EXPECT_EQ(position_offset(camera), glm::dvec3(-20000, 680000, 1e7));
}

TEST_F(ImageTest, exr_and_png_contain_metadata) {
  for (const std::string name : {"site.exr", "site.png"}) {
    write_image(colorful_film(), output(name), metadata(), false);
    const ImageFile image(folder_ / name);
    EXPECT_TRUE(image.text("Software").starts_with("Alidade ")) << image.text("Software");
    EXPECT_EQ(image.text("alidade:command"), metadata().command);
    EXPECT_EQ(image.text("alidade:cloud_files"), "a.las\nb.las");
    EXPECT_EQ(image.text("alidade:cloud_offset"), "690000 5325000 0");
    EXPECT_EQ(image.text("alidade:crs"), metadata().crs.wkt);
    EXPECT_EQ(image.text("alidade:radius"), "0.10000000000000001");
    EXPECT_EQ(image.text("alidade:samples"), "9");
    EXPECT_EQ(image.text("alidade:max_bounces"), "4");
    EXPECT_EQ(image.text("alidade:seed"), "18446744073709551615");
    EXPECT_EQ(image.text("alidade:radius_source"), "auto");
    EXPECT_NE(image.text("alidade:camera").find("at 690011.100 5324912.700 523.000"), std::string::npos);
    EXPECT_EQ(describe(parse_camera(image.text("alidade:camera_json"), "metadata")),
              describe(metadata().camera));
  }
}

TEST_F(ImageTest, same_film_gives_the_same_bytes_in_every_format) {
  const Film film = colorful_film();
  for (const std::string extension : {".exr", ".png", ".jpg"}) {
    OutputSettings settings = output("a" + extension);
    settings.layers.assign(std::begin(k_all_layers), std::end(k_all_layers));
    write_image(film, settings, metadata(), false);
    const std::string first = bytes_of(settings.file);
    OIIO::attribute("threads", 1);
    settings.file = folder_ / ("b" + extension);
    write_image(film, settings, metadata(), false);
    OIIO::attribute("threads", 0);
    EXPECT_GT(first.size(), 1000u);
    EXPECT_TRUE(bytes_of(settings.file) == first) << extension;
    EXPECT_EQ(ImageFile(settings.file).text("DateTime"), "") << extension;
  }
}

TEST_F(ImageTest, png_and_jpeg_show_the_colour_with_exposure_and_srgb_curve) {
  Film film(5, 1);
  film.color = {Rgb(0.0f), Rgb(0.25f, 0.5f, 1.0f), Rgb(-1.0f, 3.0f, std::nanf("")), Rgb(0.0909f),
                Rgb(0.2140f)};
  OutputSettings settings = output("codes.png");
  write_image(film, settings, ImageMetadata(), false);
  ImageFile png(settings.file);
  EXPECT_EQ(png.spec().nchannels, 3);
  // IEC 61966-2-1 by hand: 0.25 -> 136.96, 0.5 -> 187.52, 0.0909 -> 84.96, 0.2140 -> 127.5
  EXPECT_EQ(png.channel<std::uint8_t>("R"), (std::vector<std::uint8_t>{0, 137, 0, 85, 127}));
  EXPECT_EQ(png.channel<std::uint8_t>("G")[1], 188);
  EXPECT_EQ(png.channel<std::uint8_t>("G")[2], 255);
  EXPECT_EQ(png.channel<std::uint8_t>("B")[1], 255);
  EXPECT_EQ(png.channel<std::uint8_t>("B")[2], 0);
  settings.exposure = 1.0;
  write_image(film, settings, ImageMetadata(), true);
  EXPECT_EQ(ImageFile(settings.file).channel<std::uint8_t>("R")[1], 188);

  Film grey(16, 16);
  for (Rgb& color : grey.color) color = Rgb(0.25f);
  for (const std::string name : {"grey.jpg", "grey.jpeg", "GREY.JPG"}) {
    write_image(grey, output(name), ImageMetadata(), false);
    for (const std::uint8_t code : ImageFile(folder_ / name).channel<std::uint8_t>("G"))
      EXPECT_NEAR(code, 137, 1);
  }
}

TEST(DisplayTest, codes_are_the_nearest_to_the_srgb_curve) {
  for (int i = 0; i <= 100000; ++i) {
    const double linear = i / 100000.0;
    const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    ASSERT_NEAR(srgb_code(linear), 255.0 * encoded, 0.5 + 1e-3) << linear;
  }
  EXPECT_EQ(srgb_code(INFINITY), 255);
  EXPECT_EQ(srgb_code(-INFINITY), 0);
}

TEST(DisplayTest, exposure_is_a_power_of_two) {
  for (double stops = -64.0; stops <= 64.0; stops += 0.37) {
    EXPECT_NEAR(exposure_scale(stops) / std::exp2(stops), 1.0, 1e-13) << stops;
  }
  EXPECT_EQ(exposure_scale(0.0), 1.0);
  EXPECT_EQ(exposure_scale(-3.0), 0.125);
  EXPECT_EQ(exposure_scale(0.5), std::sqrt(2.0));
}

TEST_F(ImageTest, an_existing_file_is_kept_unless_overwriting_is_requested) {
  write_image(Film(2, 2), output("kept.png"), ImageMetadata(), false);
  const std::string before = bytes_of(folder_ / "kept.png");
  EXPECT_NE(error_of(colorful_film(), output("kept.png")), "no error");
  EXPECT_EQ(bytes_of(folder_ / "kept.png"), before);
  EXPECT_EQ(error_of(colorful_film(), output("kept.png"), true), "no error");
  EXPECT_NE(bytes_of(folder_ / "kept.png"), before);
}

TEST_F(ImageTest, failures_are_errors_and_leave_nothing_behind) {
  EXPECT_NE(error_of(Film(1, 1), output("a.bmp")).find("unknown output format; expected the extension"),
            std::string::npos);
  EXPECT_NE(error_of(Film(1, 1), output("a")).find("no extension"), std::string::npos);
  OutputSettings empty = output("empty.exr");
  empty.layers.clear();
  EXPECT_NE(error_of(Film(1, 1), empty).find("no layer"), std::string::npos);
  // JPEG ends at 65500 pixels.
  const std::string wide = error_of(Film(70000, 1), output("wide.jpg"));
  EXPECT_NE(wide.find("wide.jpg: cannot write the image: "), std::string::npos) << wide;
  EXPECT_EQ(error_of(Film(65500, 1), output("wide.jpg")), "no error");
  std::filesystem::remove(folder_ / "wide.jpg");
  EXPECT_NE(error_of(Film(1, 1), {.file = folder_ / "no" / "folder.png"}), "no error");
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

/// While it lives, files of this process end at so many bytes, as on a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST_F(ImageTest, a_full_disk_is_an_error_in_every_format_and_leaves_nothing_behind) {
  const Film film = colorful_film(200, 200);
  for (const std::string name : {"full.png", "full.jpg", "full.exr"}) {
    // Nothing fits; the beginning fits; all but the end fits.
    write_image(film, output(name), metadata(), false);
    const std::uintmax_t size = std::filesystem::file_size(folder_ / name);
    std::filesystem::remove(folder_ / name);
    for (const std::uintmax_t bytes : {std::uintmax_t{0}, std::uintmax_t{5000}, size - 1}) {
      std::string error;
      {
        const FileSizeLimit limit(bytes);
        error = error_of(film, output(name));
      }
      EXPECT_NE(error.find(name + ": cannot write the file"), std::string::npos) << error;
      EXPECT_TRUE(std::filesystem::is_empty(folder_)) << name << " " << bytes;
    }
  }
}

}  // namespace
}  // namespace alidade::test
