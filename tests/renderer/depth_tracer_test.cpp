// SPDX-License-Identifier: MIT
#include "renderer/depth_tracer.h"

#include <tbb/global_control.h>

#include <cmath>

#include "renderer/render.h"
#include "tests/renderer/mixed_scene.h"

namespace alidade::test {
namespace {

TEST(DepthTracer, gives_the_layers_of_the_image_to_the_last_bit_on_any_number_of_threads) {
  for (const PointShape shape : k_point_shapes) {
    SCOPED_TRACE(shape_name(shape));
    Scene scene = mixed_scene(shape);
    const LoadedCloud cloud = mixed_cloud(shape);
    scene.cloud->normals = NormalMode::smooth;
    const Camera pinhole = *scene.camera;
    Camera panorama = panorama_camera({0, -3, 1}, 40, 20);
    Camera orthographic = pinhole;
    orthographic.lens = OrthographicLens{};
    orthographic.fx = orthographic.fy = 10.0;
    Camera fisheye = pinhole;
    fisheye.lens = FisheyeLens{};
    fisheye.fx = fisheye.fy = 12.0;
    const DepthTracer tracer(scene, &cloud);
    for (const Camera& camera : {pinhole, panorama, orthographic, fisheye}) {
      scene.camera = camera;
      const Film film = render(scene, &cloud);
      for (const int threads : {1, 3}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(threads));
        EXPECT_EQ(tracer.trace(camera, Layer::depth).depth, film.depth);
        EXPECT_EQ(tracer.trace(camera, Layer::distance).distance, film.distance);
      }
    }
  }
}

TEST(DepthTracer, depth_is_along_the_axis_and_distance_along_the_ray) {
  Scene scene;
  scene.objects = {GroundPlane{0.0, Lambertian{}}};
  const Camera camera = pinhole_from_fov(41, 31, 60.0, look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}));
  const DepthTracer tracer(scene, nullptr);
  const Film depth = tracer.trace(camera, Layer::depth), distance = tracer.trace(camera, Layer::distance);
  EXPECT_TRUE(distance.depth.empty());
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double u = (x + 0.5 - camera.cx) / camera.fx, v = (y + 0.5 - camera.cy) / camera.fy;
      EXPECT_NEAR(depth.depth[depth.index(x, y)], 5.0, 1e-6);
      EXPECT_NEAR(distance.distance[depth.index(x, y)], 5.0 * std::sqrt(1.0 + u * u + v * v), 1e-6);
    }
  }
}

TEST(DepthTracer, counts_every_pixel_and_stops_when_asked_to) {
  const Scene scene = mixed_scene();
  const LoadedCloud cloud = mixed_cloud();
  const DepthTracer tracer(scene, &cloud);
  std::uint64_t done = 0, total = 0;
  tracer.trace(*scene.camera, Layer::depth, [&](std::uint64_t now, std::uint64_t all) {
    done = now;
    total = all;
    return true;
  });
  EXPECT_EQ(done, 70u * 50u);
  EXPECT_EQ(total, 70u * 50u);
  EXPECT_THROW(tracer.trace(*scene.camera, Layer::depth, [](std::uint64_t, std::uint64_t) { return false; }),
               Cancelled);
}

}  // namespace
}  // namespace alidade::test
