// SPDX-License-Identifier: MIT
#include "jobs/render/render.h"

#include "base/progress.h"
#include "jobs/render/merge.h"
#include "tests/jobs/render_job.h"

namespace alidade::test {
namespace {

/// Stops the job at a report of a stage, once it is half done.
class StoppingAt : public Heard {
 public:
  explicit StoppingAt(std::string task) : task_(std::move(task)) {}
  std::unique_ptr<Stage> begin(std::string task, std::string unit) override {
    if (task == task_) return std::make_unique<HalfStage>();
    return Heard::begin(std::move(task), std::move(unit));
  }

 private:
  struct HalfStage : Stage {
    Progress callback() override {
      return [](std::uint64_t done, std::uint64_t total) { return 2 * done < total; };
    }
    void skip(std::uint64_t) override {}
    void finish() override {}
  };

  std::string task_;
};

class RenderTest : public RenderJobTest {
 protected:
  /// A small image of the square.
  static jobs::RenderRequest square(const std::filesystem::path& output) {
    jobs::RenderRequest request;
    request.scene = renderer::daylight_scene({"square.xyz"});
    request.views.size = jobs::ImageSize{24, 16};
    request.samples = 4;
    request.output = output;
    return request;
  }
  void SetUp() override {
    RenderJobTest::SetUp();
    write_square("square.xyz");
  }
  static Words small(Words words) {
    words.insert(words.end(), {"--size=24x16", "--samples=4"});
    return words;
  }
  /// A house of one wall, of 2 m.
  void write_wall(const std::string& name) {
    write(name, "v 100 200 5\nv 102 200 5\nv 102 200 7\nv 100 200 7\nf 1 2 3\nf 1 3 4\n");
  }

  Heard heard_;
};

TEST_F(RenderTest, a_plain_request_gives_the_image_of_its_fields) {
  const jobs::RenderResult result = jobs::run(jobs::plan(square("plain.png")), heard_);
  ASSERT_TRUE(render({"square.xyz", "--size", "24x16", "--samples", "4", "-o", "fields.png"}).is_done);
  EXPECT_EQ(read("plain.png"), read("fields.png"));
  EXPECT_EQ(result.files, (std::vector<std::filesystem::path>{"plain.png"}));
  EXPECT_TRUE(result.empty_views.empty());
  ASSERT_EQ(result.images.size(), 1u);
  EXPECT_EQ(result.images.front().statistics.most_samples, 4);
  EXPECT_EQ(result.images.front().film.count(), 0u);
}

TEST_F(RenderTest, films_are_returned_without_an_output) {
  jobs::RenderRequest request = square("");
  request.returns_films = true;
  request.layers = {image::Layer::color, image::Layer::depth};
  const jobs::RenderResult result = jobs::run(jobs::plan(request), heard_);
  ASSERT_EQ(result.images.size(), 1u);
  const image::Film& film = result.images.front().film;
  EXPECT_EQ(film.width, 24);
  EXPECT_EQ(film.color.size(), 24u * 16u);
  EXPECT_EQ(film.depth.size(), 24u * 16u);
  EXPECT_TRUE(film.sees_anything());
  EXPECT_NE(result.output.exposure, 0.0);
  request.part = renderer::ImagePart{1, 2};
  EXPECT_THROW(jobs::plan(request), Error);
  EXPECT_EQ(names(), Words{"square.xyz"});
}

TEST_F(RenderTest, an_output_is_written_and_not_returned_too) {
  jobs::RenderRequest request = square("image.png");
  request.returns_films = true;
  EXPECT_EQ(jobs::run(jobs::plan(request), heard_).images.front().film.count(), 0u);
  EXPECT_EQ(names(), (Words{"image.png", "square.xyz"}));
}

TEST_F(RenderTest, a_stopped_job_without_an_output_resumes_with_the_same_film) {
  jobs::RenderRequest request = square("");
  request.returns_films = true;
  request.scene.output.file = "of_scene.png";
  request.samples = 64;
  const jobs::RenderResult whole = jobs::run(jobs::plan(request), heard_);
  request.checkpoint.file = "image.checkpoint";
  StoppingAt stopping("rendering");
  EXPECT_THROW(jobs::run(jobs::plan(request), stopping), Cancelled);
  request.checkpoint.resume = true;
  Heard resumed;
  const jobs::RenderResult result = jobs::run(jobs::plan(request), resumed);
  EXPECT_TRUE(contains(resumed.text(), "image.checkpoint: the image has")) << resumed.text();
  EXPECT_TRUE(std::ranges::equal(result.images.front().film.alpha, whole.images.front().film.alpha));
  EXPECT_EQ(names(), Words{"square.xyz"});
}

TEST_F(RenderTest, parts_are_merged_without_an_output) {
  jobs::RenderRequest request = square("image.png");
  jobs::MergeRequest merge;
  for (const int number : {1, 2}) {
    request.part = renderer::ImagePart{number, 2};
    merge.parts.push_back(jobs::run(jobs::plan(request), heard_).files.front());
  }
  const renderer::MergedImage merged = jobs::run(jobs::plan(merge), heard_);
  EXPECT_EQ(merged.film.count(), 24u * 16u);
  EXPECT_EQ(names(), (Words{"image.png.part1of2", "image.png.part2of2", "square.xyz"}));
}

TEST_F(RenderTest, meshes_and_a_sun_by_time_need_no_command_line) {
  write_wall("wall.obj");
  jobs::RenderRequest request = square("wall.png");
  request.scene.objects.emplace_back(
      renderer::Model{.surfaces = {}, .mesh = renderer::MeshFile{"wall.obj", {}}});
  request.scene.sun_by_time.emplace();
  request.scene.sun_by_time->moment = jobs::parse_moment("2026-06-21T12:00:00+02:00");
  request.scene.sun_by_time->latitude = 48.0;
  request.scene.sun_by_time->longitude = 11.5;
  jobs::run(jobs::plan(request), heard_);
  EXPECT_TRUE(contains(heard_.text(), "2 triangles from wall.obj")) << heard_.text();
  EXPECT_TRUE(contains(heard_.text(), "sun at azimuth")) << heard_.text();
  // Other triangles make another image, whose checkpoints are not taken for this one: the name has a checksum.
  const std::string png = read("wall.png"), name = "wall.obj ";
  const std::size_t found = png.find(name);
  ASSERT_NE(found, std::string::npos);
  EXPECT_EQ(png.find_first_not_of("0123456789abcdef", found + name.size()), found + name.size() + 16);
}

TEST_F(RenderTest, a_plan_checks_before_a_point_is_read) {
  const auto error_of = [](const jobs::RenderRequest& request) -> std::string {
    try {
      jobs::plan(request);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(error_of(square("a.png")), "");
  EXPECT_TRUE(contains(error_of({}), "nothing to render"));
  EXPECT_TRUE(contains(error_of(square("")), "missing output"));
  EXPECT_TRUE(contains(error_of(square("square.xyz")), "unknown output format"));
  jobs::RenderRequest request = square("a.png");
  request.layers = {image::Layer::depth};
  EXPECT_TRUE(contains(error_of(request), "layers require EXR"));
  request = square("a.png");
  request.scene.cloud->radius = 0.1;
  EXPECT_TRUE(contains(error_of(request), "discs do not support one radius"));
  request = square("a.png");
  request.legend = "legend.png";
  request.scene.cloud->color = image::coloring_by("rgb");
  EXPECT_TRUE(contains(error_of(request), "rgb colours have no legend"));
  EXPECT_EQ(names(), Words{"square.xyz"});
}

TEST_F(RenderTest, rasters_of_the_ground_require_a_cloud) {
  write_wall("wall.obj");
  const RenderOutcome result = render({"--mesh", "wall.obj", "--orthographic", "top", "--resolution", "0.5",
                                       "--layers", "elevation", "-o", "wall.tif"});
  EXPECT_FALSE(result.is_done);
  EXPECT_TRUE(contains(result.said, "wall.tif: layers of the ground require a cloud")) << result.said;
  EXPECT_EQ(names(), (Words{"square.xyz", "wall.obj"}));
}

TEST_F(RenderTest, a_stopped_job_resumes_from_its_checkpoint_with_the_same_bytes) {
  jobs::RenderRequest request = square("image.png");
  request.samples = 64;
  jobs::run(jobs::plan(request), heard_);
  const std::string whole = read("image.png");
  std::filesystem::remove("image.png");
  request.checkpoint.file = "image.checkpoint";
  StoppingAt stopping("rendering");
  EXPECT_THROW(jobs::run(jobs::plan(request), stopping), Cancelled);
  EXPECT_TRUE(contains(stopping.text(), "saved to image.checkpoint")) << stopping.text();
  EXPECT_EQ(names(), (Words{"image.checkpoint", "square.xyz"}));
  request.checkpoint.resume = true;
  Heard resumed;
  jobs::run(jobs::plan(request), resumed);
  EXPECT_TRUE(contains(resumed.text(), "resuming from image.checkpoint")) << resumed.text();
  EXPECT_EQ(read("image.png"), whole);
  EXPECT_EQ(names(), (Words{"image.png", "square.xyz"}));
}

TEST_F(RenderTest, a_video_without_images_leaves_no_folder) {
  jobs::RenderRequest request = square("yard.mp4");
  request.flight.orbits = true;
  {
    const jobs::RenderPlan plan = jobs::plan(request);
    EXPECT_TRUE(std::filesystem::is_directory("yard_frames"));
    EXPECT_EQ(plan.images.size(), 150u);
  }
  EXPECT_EQ(names(), Words{"square.xyz"});
}

TEST_F(RenderTest, a_plan_has_what_is_read_and_written) {
  write_wall("wall.obj");
  using Files = std::vector<std::filesystem::path>;
  const auto without_none = [](Files files) {
    std::erase(files, "");
    return files;
  };
  jobs::RenderRequest request = square("site.tif");
  request.scene.cloud->partial = true;
  request.scene.cloud->color = image::coloring_by("height");
  request.scene.objects.emplace_back(
      renderer::Model{.surfaces = {}, .mesh = renderer::MeshFile{"wall.obj", {}}});
  request.views = {};
  request.views.from_above = true;
  request.views.resolution = 0.5;
  request.ground.layers = {jobs::GroundLayer::elevation};
  request.legend = "legend.png";
  request.checkpoint.file = "site.checkpoint";
  request.depth.file = "depth.npy";
  jobs::PlannedWork work = jobs::plan(request).work();
  EXPECT_TRUE(work.partial);
  EXPECT_EQ(work.clouds.names(), Files{"square.xyz"});
  EXPECT_EQ(without_none(work.reads), Files{"wall.obj"});
  EXPECT_EQ(without_none(work.writes),
            (Files{"site.tif", "site_elevation.tif", "site.checkpoint", "legend.png", "depth.npy"}));
  // The other parts have no more than their part of the image.
  request.part = renderer::ImagePart{2, 3};
  EXPECT_EQ(without_none(jobs::plan(request).work().writes), (Files{"site.tif.part2of3", "site.checkpoint"}));
  request.part.reset();
  request.ground.with_color = false;
  EXPECT_EQ(without_none(jobs::plan(request).work().writes).front(), "site.tif");
  request.depth.file = "site.tif";
  EXPECT_THROW(jobs::plan(request), Error) << "the raster and the depth map are one file";
  request = square("image.png");
  request.scene.objects.emplace_back(
      renderer::Model{.surfaces = {}, .mesh = renderer::MeshFile{"wall.las", {}}});
  EXPECT_THROW(jobs::plan(request), Error) << "the mesh is of another format";

  request = square("image.png");
  request.skips_existing = true;
  write("image.png", "an image");
  EXPECT_TRUE(without_none(jobs::plan(request).work().writes).empty());
  EXPECT_TRUE(jobs::plan(request).work().clouds.empty());
  const double small = jobs::plan(square("a.png")).work().bytes_beside;
  request = square("a.png");
  request.views.size = jobs::ImageSize{4000, 4000};
  EXPECT_GT(jobs::plan(request).work().bytes_beside, small + 16e6 * 40);
}

TEST_F(RenderTest, a_video_replaces_its_images) {
  write("ffmpeg", "#!/bin/sh\nfor last; do :; done\necho video > \"$last\"\n");
  std::filesystem::permissions("ffmpeg", std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (folder.string() + ":" + path).c_str(), 1);
  jobs::RenderRequest request = square("yard.mp4");
  request.flight.orbits = true;
  request.flight.frames = 3;
  EXPECT_EQ(jobs::plan(request).work().writes.front(), "yard.mp4");
  const jobs::RenderResult result = jobs::run(jobs::plan(request), heard_);
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(result.files, (std::vector<std::filesystem::path>{"yard.mp4"}));
  ASSERT_EQ(result.images.size(), 3u);
  EXPECT_EQ(result.images.front().file, "");
  EXPECT_EQ(names(), (Words{"ffmpeg", "square.xyz", "yard.mp4"}));
}

TEST_F(RenderTest, a_video_has_no_parts_and_an_even_size) {
  write("way.csv", "x,y,z,look_at_x,look_at_y,look_at_z\n95,195,6,101,201,5\n108,195,8,101,201,5\n");
  const auto error_of = [&](const Words& more) {
    Words words{"square.xyz", "-o", "yard.mp4"};
    words.insert(words.end(), more.begin(), more.end());
    return render(words).said;
  };
  EXPECT_TRUE(contains(error_of({"--orbit", "--part", "1/2"}), "yard.mp4: a video has no parts"));
  write("lens.json", R"({"version": 1, "model": "pinhole", "width": 25, "height": 16,
    "intrinsics": {"vertical_fov": 50}, "pose": {"look_at": {"eye": [0, -5, 1], "target": [0, 0, 0]}}})");
  write("scene.json", R"({"version": 1, "cloud": {"file": "square.xyz"}, "camera": "lens.json"})");
  const RenderOutcome odd = render({"scene.json", "-o", "yard.mp4", "--keyframes", "way.csv"});
  EXPECT_TRUE(contains(odd.said, "yard.mp4: the size of a video must be even")) << odd.said;
  EXPECT_TRUE(contains(odd.said, "25x16")) << odd.said;
  EXPECT_EQ(names(), (Words{"lens.json", "scene.json", "square.xyz", "way.csv"}));
}

TEST_F(RenderTest, rasters_of_the_ground_come_with_the_first_part) {
  const auto part = [&](const std::string& number, const std::string& layers) {
    return render({"square.xyz", "--orthographic", "top", "--resolution", "0.5", "--layers", layers, "-o",
                   "site.tif", "--part", number});
  };
  ASSERT_TRUE(part("1/2", "color,elevation").is_done);
  const RenderOutcome second = part("2/2", "color,elevation");
  EXPECT_TRUE(second.is_done) << second.said;
  EXPECT_EQ(names(), (Words{"site.tif.part1of2", "site.tif.part2of2", "site_elevation.tif", "square.xyz"}));
  EXPECT_TRUE(contains(part("1/2", "elevation").said, "--part requires an image"));
}

TEST_F(RenderTest, a_plan_to_merge_checks_the_parts) {
  jobs::MergeRequest merge;
  merge.parts = {"image.png.part1of2", "image.png.part2of2"};
  EXPECT_THROW(jobs::plan(merge), Error);
  jobs::RenderRequest request = square("image.png");
  request.part = renderer::ImagePart{1, 2};
  jobs::run(jobs::plan(request), heard_);
  merge.parts.pop_back();
  EXPECT_THROW(jobs::plan(merge), Error) << "the second part is missing";
  request.part = renderer::ImagePart{2, 2};
  merge.parts.push_back(jobs::run(jobs::plan(request), heard_).files.front());
  EXPECT_NO_THROW(jobs::plan(merge));
  merge.output = "image.exr";
  EXPECT_THROW(jobs::plan(merge), Error) << "the parts are of a PNG";
}

TEST_F(RenderTest, another_seed_gives_another_image) {
  ASSERT_TRUE(render(small({"--cloud", "square.xyz", "--seed", "1", "-o", "a.png"})).is_done);
  ASSERT_TRUE(render(small({"--cloud", "square.xyz", "--seed", "2", "-o", "b.png"})).is_done);
  EXPECT_NE(read("a.png"), read("b.png"));
}

TEST_F(RenderTest, cloud_options_for_a_scene_without_a_cloud_are_an_error) {
  write("scene.json", R"({"version": 1, "camera": {"version": 1, "model": "pinhole", "width": 8, "height": 8,
    "intrinsics": {"vertical_fov": 50}, "pose": {"look_at": {"eye": [0, -5, 1], "target": [0, 0, 0], "up": [0, 0, 1]}}},
    "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1,
                 "material": {"type": "lambertian", "albedo": [0.5, 0.5, 0.5]}}]})");
  for (const Words& words : std::vector<Words>{{"--radius", "0.1"},
                                               {"--radius-max", "0.1"},
                                               {"--hits", "t"},
                                               {"--color-by", "height"},
                                               {"--max-level", "3"}}) {
    const RenderOutcome rejected = render({"scene.json", words[0], words[1], "-o", "out.png"});
    EXPECT_FALSE(rejected.is_done);
    EXPECT_TRUE(contains(rejected.said, "scene.json: the scene has no cloud for " + words[0] + "\n"))
        << rejected.said;
  }
  const RenderOutcome result = render(small({"scene.json", "-o", "out.png"}));
  EXPECT_TRUE(result.is_done) << result.said;
}

TEST_F(RenderTest, clouds_are_discs_unless_options_are_of_spheres) {
  int number = 0;
  const auto expect_surface = [&](Words options, const std::string& surface) {
    options.insert(options.begin(), {"--cloud", "square.xyz", "-o", std::to_string(number++) + ".png"});
    const RenderOutcome result = render(small(options));
    ASSERT_TRUE(result.is_done) << result.said;
    EXPECT_TRUE(contains(result.said, surface)) << result.said;
  };
  expect_surface({}, "discs of radius 0.92 times the distance to neighbour 8");
  expect_surface({"--surface", "disc", "--radius-factor", "0.5"}, "discs of radius 0.5 times");
  expect_surface({"--surface", "sphere"}, "spheres of radius");
  expect_surface({"--radius", "0.5"}, "spheres of radius 0.5");
  expect_surface({"--normals", "sphere"}, "spheres of radius");
  expect_surface({"--radius", "adapted", "--radius-neighbours", "2"}, "spheres of radius 0.75 times");
  for (const Words& option : {Words{"--radius", "0.5"}, {"--hits", "t"}, {"--normals", "smooth"}}) {
    const RenderOutcome result =
        render(small({"--cloud", "square.xyz", "--surface", "disc", option[0], option[1], "-o", "no.png"}));
    EXPECT_FALSE(result.is_done);
    EXPECT_TRUE(contains(result.said, option[0])) << result.said;
    EXPECT_TRUE(contains(result.said, "has no effect on discs")) << result.said;
  }
}

TEST_F(RenderTest, options_of_adapted_radii_beside_one_radius_are_an_error) {
  for (const std::string radius : {"0.1", "auto"}) {
    for (const std::string option : {"--radius-factor", "--radius-neighbours", "--radius-max"}) {
      const RenderOutcome result =
          render({"--cloud", "square.xyz", "-o", "out.png", option, "2", "--radius", radius});
      EXPECT_FALSE(result.is_done);
      EXPECT_TRUE(contains(result.said, ": requires --radius adapted")) << result.said;
    }
  }
}

TEST_F(RenderTest, options_of_adapted_radii_leave_the_others_as_the_scene_has_them) {
  const auto said = [&](const std::string& radius, const Words& more) {
    write("scene.json", R"({"version": 1, "cloud": {"file": "square.xyz", "radius": )" + radius + "}}");
    Words words = small({"scene.json", "-o", "out.png", "--overwrite"});
    words.insert(words.end(), more.begin(), more.end());
    return render(words).said;
  };
  const std::string own = R"({"neighbours": 3, "factor": 1.5, "max": 0.5})";
  EXPECT_TRUE(contains(said(own, {"--radius-factor", "2"}),
                       "radius 2 times the distance to neighbour 3, at most 0.5"));
  EXPECT_TRUE(contains(said(own, {"--radius-neighbours", "5", "--radius-max", "0.25"}),
                       "radius 1.5 times the distance to neighbour 5, at most 0.25"));
  EXPECT_TRUE(contains(said(own, {"--radius", "adapted"}),
                       "radius 1.5 times the distance to neighbour 3, at most 0.5"));
  EXPECT_FALSE(contains(said(own, {"--radius-max", "auto"}), "at most 0.5"));
  EXPECT_TRUE(contains(said(own, {"--radius", "0.125"}), "spheres of radius 0.125\n"));
  EXPECT_TRUE(contains(said(own, {"--radius", "auto"}), "(from the spacing of the points)"));
  EXPECT_TRUE(contains(said("0.125", {"--radius-max", "0.25"}),
                       "radius 0.75 times the distance to neighbour 8, at most 0.25"));
}

TEST_F(RenderTest, one_point_is_an_image) {
  write("one.xyz", "690000 5325000 500\n");
  EXPECT_TRUE(render(small({"--cloud", "one.xyz", "-o", "out.png"})).is_done);
}

TEST_F(RenderTest, an_exact_site_takes_the_place_of_the_cloud) {
  ASSERT_TRUE(render(small({"--site", "courtyard", "-o", "site.png"})).is_done);
  write("scene.json", R"({"version": 1, "cloud": {"file": "none.las"}})");
  ASSERT_TRUE(render(small({"scene.json", "--site", "courtyard", "-o", "scene.png"})).is_done);
  EXPECT_NE(read("site.png"), read("scene.png"));  // whose light is another
  const RenderOutcome radius = render(small({"--site", "courtyard", "--radius", "0.1", "-o", "no.png"}));
  EXPECT_FALSE(radius.is_done);
  EXPECT_TRUE(contains(radius.said, "--radius has no effect with --site")) << radius.said;
  write("glass.json", R"({"version": 1, "cloud": {"file": "none.las", "material": {"type": "dielectric"}}})");
  const RenderOutcome glass = render(small({"glass.json", "--site", "courtyard", "-o", "no.png"}));
  EXPECT_FALSE(glass.is_done);
  EXPECT_TRUE(contains(glass.said, "--site does not support glass")) << glass.said;
  EXPECT_FALSE(render(small({"--site", "moon", "-o", "no.png"})).is_done);
}

}  // namespace
}  // namespace alidade::test
