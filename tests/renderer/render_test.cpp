// SPDX-License-Identifier: MIT
#include "renderer/render.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <glm/geometric.hpp>

#include "tests/renderer/mixed_scene.h"

namespace alidade {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

using test::expect_same;
using test::mixed_cloud;
using test::mixed_scene;

TEST(Render, film_does_not_depend_on_the_number_of_threads) {
  std::vector<Scene> scenes{mixed_scene()};
  scenes[0].cloud->normals = NormalMode::smooth;
  for (const PointShape shape : test::k_point_shapes) scenes.push_back(mixed_scene(shape));
  for (const Scene& scene : scenes) {
    SCOPED_TRACE(test::shape_name(scene.cloud->shape));
    const LoadedCloud cloud = mixed_cloud(scene.cloud->shape);
    Film films[3];
    RenderStatistics statistics[3];
    for (int threads = 1; threads <= 3; ++threads) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      films[threads - 1] = render(scene, &cloud, {}, &statistics[threads - 1]);
    }
    expect_same(films[0], films[1]);
    expect_same(films[0], films[2]);
    EXPECT_EQ(statistics[0].ray_count, statistics[1].ray_count);
    EXPECT_GT(statistics[0].ray_count, 70u * 50 * 5);
  }
}

TEST(Render, film_does_not_depend_on_the_instruction_set) {
  for (const PointShape shape : test::k_point_shapes) {
    const Scene scene = mixed_scene(shape);
    const LoadedCloud cloud = mixed_cloud(shape);
    const Film best = render(scene, &cloud);
    for (const InstructionSet set : available_instruction_sets()) {
      const LoadedCloud built = mixed_cloud(shape, set);
      SCOPED_TRACE(test::shape_name(shape) + " " + std::string(name(set)));
      EXPECT_EQ(built.octree.instruction_set(), set);
      expect_same(render(scene, &built), best);
    }
  }
}

TEST(Render, a_model_without_surfaces_is_an_error) {
  Scene scene = mixed_scene();
  scene.objects.emplace_back(Model{.surfaces = {}, .mesh = MeshFile{"house.obj", {}}});
  const auto message = [&](const LoadedCloud* cloud, const RenderOptions& options) -> std::string {
    try {
      render(scene, cloud, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const LoadedCloud cloud = mixed_cloud();
  const std::string expected = fmt::format("house.obj: object {} has no surfaces", scene.objects.size() - 1);
  EXPECT_NE(message(&cloud, {}).find(expected), std::string::npos) << message(&cloud, {});
  EXPECT_NE(message(nullptr, {}).find(expected), std::string::npos);
  RenderOptions kept;
  kept.checkpoint.emplace();
  kept.checkpoint->file = std::filesystem::path(::testing::TempDir()) / "a_model_without_surfaces";
  EXPECT_NE(message(&cloud, kept).find(expected), std::string::npos);
  PartOutput part;
  part.file = kept.checkpoint->file;
  EXPECT_THROW(render_part(scene, &cloud, {}, part), Error);
}

/// Otherwise the comparisons of films of discs would prove little.
TEST(Render, film_of_discs_has_sheets_rims_and_points_without_a_sheet) {
  const LoadedCloud cloud = mixed_cloud(PointShape::blend);
  const Film film = render(mixed_scene(PointShape::blend), &cloud);
  int sheets = 0, rims = 0, lone = 0, before_nothing = 0;
  for (std::size_t pixel = 0; pixel < film.count(); ++pixel) {
    sheets += film.support[pixel] > 3 ? 1 : 0;
    lone += film.support[pixel] == 1 ? 1 : 0;
    rims += film.coverage[pixel] > 0.0f && film.coverage[pixel] < 1.0f ? 1 : 0;
    before_nothing += film.support[pixel] > 0 && std::isinf(film.depth_sigma[pixel]) ? 1 : 0;
  }
  EXPECT_GT(sheets, 150);
  EXPECT_GT(rims, 50);
  EXPECT_GT(lone, 50);
  EXPECT_GT(before_nothing, 20);
}

TEST(Render, another_seed_is_another_noise_around_the_same_image) {
  const LoadedCloud cloud = mixed_cloud();
  Scene scene = mixed_scene();
  const Film a = render(scene, &cloud);
  scene.render.seed = 43;
  const Film b = render(scene, &cloud);
  EXPECT_NE(a.color, b.color);
  EXPECT_EQ(a.id, b.id);
  EXPECT_NEAR(test::image_mean(a).mean, test::image_mean(b).mean, 0.02 * test::image_mean(a).mean);
}

TEST(Render, layers_come_from_the_ray_through_the_pixels_centre) {
  const LoadedCloud cloud = test::loaded({{0, 0, 5}, {0, 0, 2}}, 1.0);
  Scene scene =
      test::dark_scene(pinhole_from_fov(3, 3, 90.0, look_at({0, 0, 10}, {0, 0, 0}, {0, 1, 0})), 2, 0);
  scene.cloud.emplace();
  scene.objects = {Sphere{{0, 100, 0}, 1.0}, GroundPlane{0.0, Lambertian{Rgb(0.25f)}}};
  const Film film = render(scene, &cloud);
  const std::size_t middle = film.index(1, 1), corner = film.index(0, 2);
  EXPECT_EQ(film.id[middle], 1u);
  EXPECT_NEAR(film.depth[middle], 4.0f, 1e-6f);
  EXPECT_NEAR(film.distance[middle], 4.0f, 1e-6f);
  EXPECT_NEAR(glm::length(film.normal[middle] - glm::vec3(0, 0, 1)), 0.0f, 1e-6f);
  EXPECT_NEAR(glm::length(film.position[middle] - glm::dvec3(0, 0, 6)), 0.0, 1e-9);
  EXPECT_EQ(film.albedo[middle], Rgb(0.95f));
  EXPECT_EQ(film.alpha[middle], 1.0f);
  // The corner pixel looks down at slopes of 2/3 on both axes and meets the plane; objects count down from
  // the largest id.
  EXPECT_EQ(film.id[corner], 4294967294u);
  EXPECT_NEAR(film.depth[corner], 10.0f, 1e-5f);
  EXPECT_NEAR(film.distance[corner], 10.0 * std::sqrt(1.0 + 8.0 / 9.0), 1e-5);
  EXPECT_NEAR(glm::length(film.position[corner] - glm::dvec3(-20.0 / 3, -20.0 / 3, 0)), 0.0, 1e-9);
  EXPECT_EQ(film.albedo[corner], Rgb(0.25f));
}

TEST(Render, a_pixel_that_sees_nothing_has_the_values_of_nothing) {
  Scene scene = test::dark_scene(test::camera_at({0, 0, 0}, {0, 1, 0}, 30.0, 2), 3, 2);
  scene.sky = ConstantSky{Rgb(0.5f)};
  const Film film = render(scene, nullptr);
  for (std::size_t pixel = 0; pixel < 4; ++pixel) {
    EXPECT_EQ(film.color[pixel], Rgb(0.5f));
    EXPECT_EQ(film.alpha[pixel], 0.0f);
    EXPECT_EQ(film.variance[pixel], Rgb(0.0f));
    EXPECT_EQ(film.depth[pixel], INFINITY);
    EXPECT_EQ(film.distance[pixel], INFINITY);
    EXPECT_EQ(film.normal[pixel], glm::vec3(0.0f));
    EXPECT_EQ(film.id[pixel], 0u);
  }
}

TEST(Render, normals_in_the_film_face_the_camera) {
  Scene scene = test::dark_scene(test::camera_at({0, 0, 0}, {0, 1, 0}, 30.0, 3), 1, 0);
  scene.objects = {Sphere{glm::dvec3(0.0), 2.0}};
  EXPECT_NEAR(render(scene, nullptr).normal[4].y, -1.0f, 1e-6f);
}

TEST(Render, variance_of_a_single_sample_is_infinite) {
  Scene scene = mixed_scene();
  scene.render.samples = 1;
  RenderStatistics statistics;
  const Film film = render(scene, nullptr, {}, &statistics);
  ASSERT_EQ(film.variance.size(), film.count());
  for (const Rgb& variance : film.variance) ASSERT_EQ(variance, Rgb(INFINITY));
  EXPECT_EQ(statistics.noise->median, INFINITY);
  EXPECT_EQ(statistics.noise->worst, INFINITY);
}

TEST(Render, layers_that_are_not_requested_are_empty_and_the_others_the_same) {
  const LoadedCloud cloud = mixed_cloud();
  const Film all = render(mixed_scene(), &cloud);
  for (const NamedLayer& known : k_layers) {
    RenderOptions options;
    options.layers = {{known.layer}};
    Film film = render(mixed_scene(), &cloud, options);
    EXPECT_EQ(film.color, all.color) << known.name;
    EXPECT_EQ(film.alpha, all.alpha) << known.name;
    Film expected(all.width, all.height, *options.layers);
    expected.color = all.color;
    expected.alpha = all.alpha;
    if (known.layer == Layer::variance) expected.variance = all.variance;
    if (known.layer == Layer::depth) expected.depth = all.depth;
    if (known.layer == Layer::distance) expected.distance = all.distance;
    if (known.layer == Layer::normal) expected.normal = all.normal;
    if (known.layer == Layer::position) expected.position = all.position;
    if (known.layer == Layer::albedo) expected.albedo = all.albedo;
    if (known.layer == Layer::id) expected.id = all.id;
    if (known.layer == Layer::depth_sigma) expected.depth_sigma = all.depth_sigma;
    if (known.layer == Layer::coverage) expected.coverage = all.coverage;
    if (known.layer == Layer::support) expected.support = all.support;
    expect_same(film, expected);
  }
}

TEST(Render, progress_grows_to_the_total_and_can_stop_the_work) {
  const LoadedCloud cloud = mixed_cloud();
  std::uint64_t last = 0, last_total = 0;
  RenderOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last);
    last = done;
    last_total = total;
    return true;
  };
  render(mixed_scene(), &cloud, options);
  EXPECT_EQ(last, 70u * 50 * 5);
  EXPECT_EQ(last_total, last);
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(render(mixed_scene(), &cloud, options), Cancelled);
}

TEST(Render, progress_comes_within_a_pixel_of_many_samples_too) {
  Scene scene = test::dark_scene(test::camera_at({0, 0, 1}, {0, 0, 0}, 30.0, 1), 100'000, 0);
  std::vector<std::uint64_t> reports;
  RenderOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t) {
    reports.push_back(done);
    return false;
  };
  EXPECT_THROW(render(scene, nullptr, options), Cancelled);
  ASSERT_FALSE(reports.empty());
  EXPECT_LT(reports.front(), 20'000u);
}

TEST(Render, a_scene_that_cannot_be_rendered_is_an_error) {
  Scene scene = mixed_scene();
  scene.camera.reset();
  EXPECT_THROW(render(scene, nullptr), Error);
  scene = mixed_scene();
  scene.render.samples = 0;
  EXPECT_THROW(render(scene, nullptr), Error);
}

}  // namespace
}  // namespace alidade
