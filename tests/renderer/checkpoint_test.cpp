// SPDX-License-Identifier: MIT
#include "renderer/checkpoint.h"
#include "renderer/image_fingerprint.h"

#include <gtest/gtest.h>
#include <filesystem>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "renderer/scene_forms.h"
#include "tests/renderer/mixed_scene.h"
#include "tests/support/seal_checkpoint.h"

namespace alidade {

using namespace geo;
using namespace image;
using namespace renderer;

namespace {

using test::expect_same;
using test::mixed_cloud;
using test::mixed_scene;

class CheckpointTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string("alidade_checkpoint_") + test->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    file_ = folder_ / "picture.state";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::vector<std::byte> bytes() const {
    std::ifstream stream(file_, std::ios::binary);
    std::ostringstream content;
    content << stream.rdbuf();
    const std::string text = content.str();
    const auto* const begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
  }

  RenderOptions options(bool resume) const {
    RenderOptions options;
    options.checkpoint = {.file = file_, .interval = 1e6, .resume = resume, .image = "a.exr"};
    return options;
  }

  /// Renders until so many reports of samples have come, and leaves a checkpoint.
  void render_in_part(const Scene& scene, const LoadedCloud* cloud, RenderOptions options, int reports) {
    options.progress = [&](std::uint64_t done, std::uint64_t) { return done == 0 || reports-- > 0; };
    EXPECT_THROW(render(scene, cloud, options), Cancelled);
    ASSERT_TRUE(std::filesystem::exists(file_));
  }

  /// The message of the error that going on ends in.
  std::string rejection(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options) {
    try {
      render(scene, cloud, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.parts().file, file_.string());
      return error.what();
    }
    return "goes on";
  }

  std::filesystem::path folder_, file_;
};

TEST_F(CheckpointTest, interrupted_render_resumes_to_the_same_film) {
  for (const PointShape shape : test::k_point_shapes) {
    SCOPED_TRACE(test::shape_name(shape));
    const LoadedCloud cloud = mixed_cloud(shape);
    Scene scene = mixed_scene(shape);
    scene.render.samples = 70;
    RenderStatistics whole_statistics;
    const Film whole = render(scene, &cloud, {}, &whole_statistics);
    for (const int reports : {0, 1, 3}) {
      std::filesystem::remove(file_);
      render_in_part(scene, &cloud, options(false), reports);
      if (reports == 0) {
        EXPECT_LT(read_checkpoint_summary(file_).share, 1.0);
      }
      RenderStatistics statistics;
      int resumed = 0;
      RenderOptions again = options(true);
      again.checkpoint->resumed = [&] { ++resumed; };
      expect_same(render(scene, &cloud, again, &statistics), whole);
      EXPECT_EQ(resumed, 1);
      EXPECT_EQ(statistics.ray_count, whole_statistics.ray_count);
    }
  }
}

TEST_F(CheckpointTest, interrupted_again_and_again_with_a_target_and_previews_ends_the_same) {
  const LoadedCloud cloud = mixed_cloud();
  Scene scene = mixed_scene();
  scene.render.samples = 96;
  RenderStatistics whole_statistics;
  const Film whole = render(scene, &cloud, {.target_noise = 0.08}, &whole_statistics);
  ASSERT_GT(whole_statistics.most_samples, whole_statistics.least_samples);
  int interruptions = 0;
  for (bool done = false; !done;) {
    RenderOptions again = options(true);
    again.target_noise = 0.08;
    if (interruptions % 2 == 0) again.preview = {.show = [](const Film&) {}, .interval = 0.0};
    int reports = 2;
    again.progress = [&](std::uint64_t, std::uint64_t) { return reports-- > 0; };
    try {
      RenderStatistics statistics;
      expect_same(render(scene, &cloud, again, &statistics), whole);
      EXPECT_EQ(statistics.ray_count, whole_statistics.ray_count);
      EXPECT_EQ(statistics.mean_samples, whole_statistics.mean_samples);
      done = true;
    } catch (const Cancelled&) {
      ASSERT_LT(++interruptions, 10000);
    }
  }
  EXPECT_GT(interruptions, 0);
}

TEST_F(CheckpointTest, is_written_while_the_render_continues) {
  Scene scene = mixed_scene();
  scene.render.samples = 20;
  RenderOptions often = options(false);
  often.checkpoint->interval = 1e-9;
  bool seen = false;
  often.progress = [&](std::uint64_t, std::uint64_t) {
    seen = seen || (std::filesystem::exists(file_) && read_checkpoint_summary(file_).share > 0.0);
    return true;
  };
  const Film film = render(scene, nullptr, often);
  EXPECT_TRUE(seen);
  // The checkpoint that is left can be resumed, too.
  expect_same(render(scene, nullptr, options(true)), film);
}

TEST_F(CheckpointTest, that_does_not_exist_is_a_fresh_start) {
  expect_same(render(mixed_scene(), nullptr, options(true)), render(mixed_scene(), nullptr));
}

TEST_F(CheckpointTest, keeps_the_time_that_counts_for_a_limit) {
  Scene scene = mixed_scene();
  scene.render.samples = 100'000;
  RenderOptions in_time = options(false);
  in_time.time_limit = 1e6;
  render_in_part(scene, nullptr, in_time, 3);
  const CheckpointSummary summary = read_checkpoint_summary(file_);
  EXPECT_GT(summary.seconds, 0.1);  // reports come 50 ms apart
  in_time = options(true);
  in_time.time_limit = 0.1;
  RenderStatistics statistics;
  const Film film = render(scene, nullptr, in_time, &statistics);
  EXPECT_GE(statistics.seconds, summary.seconds);
  // Nothing was left to do but to fill tiles that had no sample yet.
  EXPECT_NEAR(statistics.mean_samples * static_cast<double>(film.count()),
              static_cast<double>(summary.samples_taken), static_cast<double>(film.count()));
}

TEST_F(CheckpointTest, of_a_render_without_limit_resumes_evenly_with_one) {
  Scene scene = mixed_scene();
  scene.render.samples = 200;
  const Film whole = render(scene, nullptr);
  render_in_part(scene, nullptr, options(false), 0);
  RenderOptions in_time = options(true);
  in_time.time_limit = 1e6;
  expect_same(render(scene, nullptr, in_time), whole);
  // Out of time: tiles that had no sample get one, no more; the others none.
  const CheckpointSummary summary = read_checkpoint_summary(file_);
  in_time.time_limit = 0.0;
  RenderStatistics statistics;
  const Film film = render(scene, nullptr, in_time, &statistics);
  EXPECT_EQ(statistics.least_samples, 1);
  EXPECT_GT(statistics.most_samples, 1);
  EXPECT_LT(statistics.mean_samples * static_cast<double>(film.count()),
            static_cast<double>(summary.samples_taken + film.count()));
}

TEST_F(CheckpointTest, of_a_render_without_previews_resumes_with_them_at_once) {
  Scene scene = mixed_scene();
  scene.render.samples = 200;
  render_in_part(scene, nullptr, options(false), 0);
  std::vector<Film> previews;
  RenderOptions seen = options(true);
  seen.preview = {.show = [&](const Film& film) { previews.push_back(film); }, .interval = 1e6};
  const Film film = render(scene, nullptr, seen);
  expect_same(film, render(scene, nullptr));
  ASSERT_EQ(previews.size(), 2u);
  EXPECT_EQ(previews.back().color, film.color);
  // Most tiles had but one sample then.
  std::size_t finished = 0;
  for (std::size_t pixel = 0; pixel < film.count(); ++pixel)
    finished += previews.front().color[pixel] == film.color[pixel] ? 1 : 0;
  EXPECT_LT(finished, film.count() / 2);
}

TEST_F(CheckpointTest, says_what_it_is_of) {
  Scene scene = mixed_scene();
  render_in_part(scene, nullptr, options(false), 0);
  const CheckpointSummary summary = read_checkpoint_summary(file_);
  EXPECT_EQ(summary.image, "a.exr");
  EXPECT_GT(summary.samples_taken, 0u);
  EXPECT_DOUBLE_EQ(summary.share, static_cast<double>(summary.samples_taken) / (70.0 * 50 * 5));
  EXPECT_GE(summary.seconds, 0.0);
}

TEST_F(CheckpointTest, of_another_image_is_an_error_that_names_the_difference) {
  const LoadedCloud cloud = mixed_cloud();
  const Scene scene = mixed_scene();
  render_in_part(scene, &cloud, options(false), 0);
  const auto expect_rejection = [&](const std::string& difference, const auto& change) {
    Scene other = scene;
    LoadedCloud other_cloud = cloud;
    RenderOptions other_options = options(true);
    change(other, other_cloud, other_options);
    const std::string message = rejection(other, &other_cloud, other_options);
    EXPECT_NE(message.find(difference), std::string::npos) << difference << ": " << message;
  };
  expect_rejection("it has seed 42, this run has 2",
                   [](Scene& other, LoadedCloud&, RenderOptions&) { other.render.seed = 2; });
  expect_rejection("it has samples 5, this run has 6",
                   [](Scene& other, LoadedCloud&, RenderOptions&) { other.render.samples = 6; });
  expect_rejection("it has max_bounces 6, this run has 7",
                   [](Scene& other, LoadedCloud&, RenderOptions&) { other.render.max_bounces = 7; });
  expect_rejection("it has picture a.exr, this run has b.exr",
                   [](Scene&, LoadedCloud&, RenderOptions& asked) { asked.checkpoint->image = "b.exr"; });
  expect_rejection("it has target noise none, this run has 0.01",
                   [](Scene&, LoadedCloud&, RenderOptions& asked) { asked.target_noise = 0.01; });
  expect_rejection("it has noise sums kept, this run has not kept",
                   [](Scene&, LoadedCloud&, RenderOptions& asked) { asked.layers = {{Layer::color}}; });
  expect_rejection("camera", [](Scene& other, LoadedCloud&, RenderOptions&) { other.camera->width = 71; });
  expect_rejection(
      "camera", [](Scene& other, LoadedCloud&, RenderOptions&) { other.camera->pose.position.x += 1e-12; });
  expect_rejection("it has objects", [](Scene& other, LoadedCloud&, RenderOptions&) {
    std::get<Sphere>(other.objects[2]).material = Metal{Rgb(0.9f), 0.31};
  });
  expect_rejection("it has sky", [](Scene& other, LoadedCloud&, RenderOptions&) {
    std::get<GradientSky>(other.sky).zenith.b = 0.9999999f;
  });
  expect_rejection("it has sun", [](Scene& other, LoadedCloud&, RenderOptions&) { other.sun.reset(); });
  expect_rejection("it has cloud settings", [](Scene& other, LoadedCloud&, RenderOptions&) {
    other.cloud->normals = NormalMode::smooth;
  });
  expect_rejection("it has radius 0.0",
                   [](Scene&, LoadedCloud& other, RenderOptions&) { other.radius = 0.05; });
  expect_rejection("it has points and colours",
                   [](Scene&, LoadedCloud& other, RenderOptions&) { other.colors.back().x ^= 1; });
  expect_rejection("it has number of points 3000, this run has 1",
                   [](Scene&, LoadedCloud& other, RenderOptions&) {
                     other = test::loaded({{0, 0, 1}}, 0.06);
                   });
  EXPECT_NE(rejection(scene, nullptr, options(true)).find("number of points"), std::string::npos);
  // What follows from something else is not named instead of it.
  expect_rejection("it has radius 0.05", [](Scene& other, LoadedCloud& other_cloud, RenderOptions&) {
    other.cloud->radius = other_cloud.radius = 0.07;
    other.camera->pose.position.z += 1.0;
  });
  expect_rejection("it has cloud files , this run has b.las",
                   [](Scene& other, LoadedCloud& other_cloud, RenderOptions&) {
                     other.cloud->files = {"b.las"};
                     other_cloud.radius = 0.07;
                   });
}

TEST(Fingerprint, long_values_are_shown_from_where_they_differ) {
  const auto message_of = [](const std::string& made, const std::string& asked) -> std::string {
    try {
      check_fingerprint({{"sun", made}}, {{"sun", asked}}, "file");
    } catch (const Error& error) {
      return error.parts().problem;
    }
    return "";
  };
  const std::string same(100, '1'), problem = "this checkpoint belongs to another picture: it has sun ";
  EXPECT_EQ(message_of("1 2", "1 3"), problem + "1 2, this run has 1 3");
  EXPECT_EQ(message_of(same + " 2.25 0", same + " 2.26 0"), problem + "...2.25 0, this run has ...2.26 0");
  EXPECT_EQ(message_of(same + "2", same + "34"), problem + "...2, this run has ...34");
  EXPECT_EQ(message_of("1", "2" + same), problem + "1, this run has 2" + same.substr(0, 39) + "...");
  EXPECT_EQ(message_of(same, same + " 2"), problem + "..., this run has ... 2");
  // No character is cut apart.
  EXPECT_EQ(message_of(same + "\u00e4", same + "\u00f6"), problem + "...\u00e4, this run has ...\u00f6");
}

TEST_F(CheckpointTest, cut_short_anywhere_or_too_long_is_an_error) {
  Scene scene = mixed_scene();
  scene.camera = test::camera_at({0, -6, 3}, {0, 0, 0}, 50.0, 14);
  render_in_part(scene, nullptr, options(false), 0);
  std::vector<std::byte> whole = bytes();
  const Fingerprint fingerprint = image_fingerprint(scene, nullptr, options(false));
  const auto read = [&](std::span<const std::byte> content) {
    ImageState state(14, 14, true);
    read_checkpoint(InputFile(content, "cut"), fingerprint, 5, state);
  };
  EXPECT_NO_THROW(read(whole));
  for (std::size_t size = 0; size < whole.size(); size += size < 2000 ? 1 : 97)
    EXPECT_THROW(read(std::span(whole).first(size)), Error) << size;
  whole.push_back(std::byte{0});
  EXPECT_THROW(read(whole), Error);
}

TEST_F(CheckpointTest, with_any_bit_flipped_is_an_error) {
  Scene scene = mixed_scene();
  scene.camera = test::camera_at({0, -6, 3}, {0, 0, 0}, 50.0, 14);
  render_in_part(scene, nullptr, options(false), 0);
  std::vector<std::byte> content = bytes();
  const Fingerprint fingerprint = image_fingerprint(scene, nullptr, options(false));
  test::Random random;
  for (std::size_t offset = 0; offset < content.size(); offset += offset < 200 ? 1 : 1 + random.below(50)) {
    const auto flip = static_cast<std::byte>(1u << random.below(8));
    content[offset] ^= flip;
    ImageState state(14, 14, true);
    EXPECT_THROW(read_checkpoint(InputFile(content, "flipped"), fingerprint, 5, state), Error) << offset;
    content[offset] ^= flip;
  }
}

TEST_F(CheckpointTest, of_another_kind_version_or_byte_order_is_detected) {
  const Scene scene = mixed_scene();
  render_in_part(scene, nullptr, options(false), 0);
  const std::vector<std::byte> whole = bytes();
  const auto message_of = [&](std::size_t offset, std::uint32_t value) {
    std::vector<std::byte> content = whole;
    test::put(content, offset, value);
    test::seal_checkpoint(content);
    std::ofstream(file_, std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()), static_cast<std::streamsize>(content.size()));
    return rejection(scene, nullptr, options(true));
  };
  EXPECT_NE(message_of(0, 0x12345678).find("byte 0: not an Alidade checkpoint"), std::string::npos);
  EXPECT_NE(message_of(8, 0x04030201).find("byte order"), std::string::npos);
  EXPECT_NE(message_of(12, 2).find("unsupported checkpoint version; expected 1, found 2"), std::string::npos);
  EXPECT_NE(message_of(16, 99).find("corrupt checkpoint: wrong file size; expected"), std::string::npos);
  // Forged numbers under right checksums.
  EXPECT_NE(message_of(40, 71).find("corrupt checkpoint: its sizes contradict its fingerprint"),
            std::string::npos);
  EXPECT_NE(message_of(48, 0).find("corrupt checkpoint: its sizes contradict its fingerprint"),
            std::string::npos);
  EXPECT_NE(message_of(48, 2).find("corrupt checkpoint: invalid noise flag; expected 0 or 1, found 2"),
            std::string::npos);
  EXPECT_NE(message_of(52, 0).find("corrupt checkpoint: number of unfinished samples out of range"),
            std::string::npos);
  EXPECT_NE(message_of(52, 6).find("corrupt checkpoint: number of unfinished samples out of range"),
            std::string::npos);
  EXPECT_NE(message_of(68, 0xffffffff).find("seconds"), std::string::npos);
  EXPECT_NE(message_of(72, 0xffffffff).find("the fingerprint exceeds the file; expected at most"),
            std::string::npos);
  EXPECT_NE(message_of(80, 0xfffffff0).find("corrupt checkpoint: truncated fingerprint"), std::string::npos);
  const std::uint32_t tiles = 80 + test::get<std::uint32_t>(whole, 72);
  EXPECT_NE(message_of(tiles, 6).find("tile 0; expected at most 5 samples, stopped 0 or 1, found 6 samples"),
            std::string::npos);
  EXPECT_NE(message_of(tiles + 4, 2).find("stopped 2"), std::string::npos);
}

TEST_F(CheckpointTest, that_cannot_be_written_is_reported_and_the_render_continues) {
  RenderOptions often = options(false);
  often.checkpoint->file = folder_ / "absent" / "picture.state";
  often.checkpoint->interval = 1e-9;
  EXPECT_THROW(render(mixed_scene(), nullptr, often), Error);
  int failures = 0;
  often.checkpoint->failed = [&](const Error& error) {
    ++failures;
    EXPECT_NE(std::string(error.what()).find("picture.state"), std::string::npos);
  };
  expect_same(render(mixed_scene(), nullptr, often), render(mixed_scene(), nullptr));
  EXPECT_GT(failures, 0);
}

TEST_F(CheckpointTest, of_an_index_file_identifies_it_by_its_checksums) {
  LoadedCloud one = mixed_cloud(), other = mixed_cloud();
  one.index_checksum = 1;
  other.index_checksum = 2;
  const Scene scene = mixed_scene();
  EXPECT_EQ(image_fingerprint(scene, &one, {}), image_fingerprint(scene, &one, {}));
  EXPECT_NE(image_fingerprint(scene, &one, {}), image_fingerprint(scene, &other, {}));
}

TEST(SceneText, differs_where_the_scene_does) {
  CloudSettings settings;
  settings.files = {"a.las", "b.las"};
  const std::string text = text_of(settings);
  const auto changed = [&](const auto& change) {
    CloudSettings other = settings;
    change(other);
    return text_of(other) != text;
  };
  EXPECT_EQ(text_of(CloudSettings(settings)), text);
  EXPECT_TRUE(changed([](CloudSettings& other) { other.files = {"a.las b.las"}; }));
  EXPECT_TRUE(changed([](CloudSettings& other) { other.radius = 0.1; }));
  EXPECT_TRUE(changed([](CloudSettings& other) { other.hits = HitMode::t; }));
  EXPECT_TRUE(changed([](CloudSettings& other) { other.material = Lambertian{Rgb(0.5f)}; }));
  EXPECT_TRUE(changed([](CloudSettings& other) { other.material = Dielectric{1.33}; }));
  EXPECT_TRUE(changed([](CloudSettings& other) { other.max_level = 3; }));
  EXPECT_NE(text_of(Sky(ConstantSky{})), text_of(Sky(GradientSky{})));
  EXPECT_NE(text_of(std::vector<Object>{Sphere{}}), text_of(std::vector<Object>{GroundPlane{}}));
  EXPECT_NE(text_of(std::optional<Sun>(Sun{})), text_of(std::optional<Sun>(Sun{.azimuth = 136})));
}

/// Texts of parts that must all differ.
struct DifferentTexts {
  std::set<std::string> seen{};

  template <class Part>
  void add(const Part& part) {
    EXPECT_TRUE(seen.insert(text_of(part)).second) << text_of(part);
  }
};

// Structs are taken apart: a member that is added to one of them does not compile here until it is changed,
// too, which fails until its key is in scene_forms.cpp.
TEST(SceneText, has_every_member_of_a_cloud) {
  CloudSettings cloud;
  DifferentTexts texts;
  texts.add(cloud);
  const auto change = [&](auto& member, auto value) {
    member = value;
    texts.add(cloud);
  };
  auto& [files, partial, color_depth, radius, adapted_radius, hits, color, material, normals, shape,
         max_level] = cloud;
  change(files, std::vector<std::filesystem::path>{"a.las"});
  change(partial, true);
  change(color_depth, ColorDepth::bits_8);
  change(radius, 0.1);
  change(hits, HitMode::t);
  change(normals, NormalMode::smooth);
  change(shape, PointShape::blend);
  change(max_level, 3);
  change(adapted_radius, AdaptedRadius{});
  auto& [neighbours, factor, max] = *adapted_radius;
  change(neighbours, 9);
  change(factor, 0.5);
  change(max, 2.0);
  auto& [by, attribute, map, range, percentiles, classes] = color;
  change(by, PointColor::height);
  change(map, ColorMap::viridis);
  change(range, ValueRange{0, 1});
  change(percentiles, ValueRange{2, 98});
  change(classes, std::vector<ClassColor>{{}});
  auto& [number, class_color, name] = classes[0];
  change(number, std::uint8_t{2});
  change(class_color, Color16(257));
  change(class_color, Color16(258));
  change(name, "ground");
  color = {.by = PointColor::attribute};
  change(color.attribute, "Range");
}

TEST(SceneText, has_every_member_of_render_settings) {
  RenderSettings settings;
  std::set<std::string> seen{render_form().write(settings).dump()};
  const auto change = [&](auto& member, auto value) {
    member = value;
    EXPECT_TRUE(seen.insert(render_form().write(settings).dump()).second);
  };
  auto& [samples, max_bounces, seed, mode, ao_distance] = settings;
  change(samples, 7);
  change(max_bounces, 7);
  change(seed, 7u);
  change(mode, RenderMode::flat);
  change(ao_distance, 7.0);
}

TEST(SceneText, has_every_member_of_what_is_around) {
  DifferentTexts texts;
  const auto add_material = [&](const Material& material) {
    texts.add(std::vector<Object>{Sphere{.material = material}});
  };
  {
    [[maybe_unused]] const auto& [albedo] = Lambertian{};
    [[maybe_unused]] const auto& [metal_albedo, roughness] = Metal{};
    [[maybe_unused]] const auto& [refractive_index] = Dielectric{};
    [[maybe_unused]] const auto& [radiance] = Emissive{};
  }
  add_material(Lambertian{});
  add_material(Lambertian{Rgb(0.1f)});
  add_material(Lambertian{Rgb(std::nextafter(0.1f, 1.0f))});
  add_material(Metal{});
  add_material(Metal{Rgb(0.1f)});
  add_material(Metal{.albedo = Rgb(0.1f), .roughness = 0.25});
  add_material(Dielectric{});
  add_material(Dielectric{1.25});
  add_material(Emissive{});
  add_material(Emissive{Rgb(7.0f)});
  Sphere sphere;
  auto& [center, sphere_radius, sphere_material] = sphere;
  center = {0, 0, -0.0};
  texts.add(std::vector<Object>{sphere});
  sphere_radius = 2;
  texts.add(std::vector<Object>{sphere});
  GroundPlane plane;
  auto& [height, plane_material] = plane;
  texts.add(std::vector<Object>{plane});
  height = 1;
  texts.add(std::vector<Object>{plane});
  plane_material = Metal{};
  texts.add(std::vector<Object>{plane});

  texts.add(Sky(ConstantSky{}));
  texts.add(Sky(ConstantSky{Rgb(1.0f)}));
  texts.add(Sky(GradientSky{}));
  texts.add(Sky(GradientSky{.horizon = Rgb(0.0f)}));
  texts.add(Sky(GradientSky{.zenith = Rgb(0.0f)}));
  ImageSky image_sky;
  auto& [file, scale, rotation, image] = image_sky;
  texts.add(Sky(image_sky));
  file = "a.hdr";
  texts.add(Sky(image_sky));
  scale = 2;
  texts.add(Sky(image_sky));
  rotation = 5;
  texts.add(Sky(image_sky));

  std::optional<Sun> sun;
  texts.add(sun);
  sun.emplace();
  texts.add(sun);
  auto& [azimuth, elevation, irradiance, angular_diameter] = *sun;
  azimuth = 1;
  texts.add(sun);
  elevation = 1;
  texts.add(sun);
  irradiance = Rgb(1.0f);
  texts.add(sun);
  angular_diameter = 1;
  texts.add(sun);
}

TEST(SceneText, has_names_that_are_not_utf_8) {
  CloudSettings cloud;
  DifferentTexts texts;
  for (const char* const name : {"a\xE9.las", "a\xE8.las", "a\uFFFD.las", "a.las"}) {
    cloud.files = {name};
    texts.add(cloud);
  }
}

}  // namespace
}  // namespace alidade
