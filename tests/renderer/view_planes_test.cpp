// SPDX-License-Identifier: MIT
#include "renderer/cloud_in_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "camera/camera.h"
#include "octree/distance.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace camera;
using namespace renderer;

namespace {

bool is_inside(const HalfSpaces& planes, const glm::dvec3& point) {
  return std::ranges::all_of(planes.planes,
                             [&](const Plane& plane) { return signed_distance(plane, point) >= -1e-9; });
}

struct Shares {
  int seen = 0, kept = 0;
};

/// What is seen is kept, of points around the camera.
Shares shares_of(const Camera& camera) {
  const HalfSpaces planes = view_planes(camera);
  Random random("view planes");
  Shares shares;
  for (int i = 0; i < 100'000; ++i) {
    const glm::dvec3 point =
        camera.pose.position +
        glm::dvec3(random.between(-50, 50), random.between(-50, 50), random.between(-50, 50));
    const std::optional<glm::dvec2> film = project_to_film(camera, point);
    const bool is_ahead = glm::dot(point - camera.pose.position, camera.pose.forward) > 0.0;
    const bool is_seen = film && is_ahead && film->x >= 0.0 && film->x <= camera.width && film->y >= 0.0 &&
                         film->y <= camera.height;
    const bool is_kept = is_inside(planes, point);
    EXPECT_TRUE(is_kept || !is_seen);
    shares.seen += is_seen ? 1 : 0;
    shares.kept += is_kept ? 1 : 0;
  }
  EXPECT_GT(shares.seen, 1000);
  return shares;
}

const CameraPose k_pose = look_at({690000, 5325000, 600}, {690030, 5325010, 590});

TEST(ViewPlanes, are_tight_around_a_pinhole) {
  const Shares shares = shares_of(pinhole_from_fov(600, 400, 40.0, k_pose));
  EXPECT_EQ(shares.kept, shares.seen);
}

TEST(ViewPlanes, are_tight_around_parallel_rays) {
  Camera camera{.width = 300, .height = 200, .fx = 10, .fy = 10, .cx = 140, .cy = 100, .pose = k_pose};
  camera.lens = OrthographicLens{};
  const Shares shares = shares_of(camera);
  EXPECT_EQ(shares.kept, shares.seen);
}

TEST(ViewPlanes, contain_what_bent_lenses_see) {
  Camera camera = pinhole_from_fov(600, 400, 50.0, k_pose);
  camera.lens = DivisionLens{.k = -0.05};
  const Shares shares = shares_of(camera);
  EXPECT_LT(shares.kept, shares.seen * 1.2);
}

TEST(ViewPlanes, wide_views_have_no_planes) {
  EXPECT_TRUE(view_planes(panorama_camera({0, 0, 0}, 400, 200)).planes.empty());
}

}  // namespace
}  // namespace alidade::test
