// SPDX-License-Identifier: MIT
#include "tests/visibility/convex_bodies.h"

#include "extensions/photos/photo_visibility.h"

namespace alidade::test {
namespace {

TEST(ConvexBodies, show_their_points_to_photos) {
  expect_in_few_writings([](const Body& body, const Writing& writing, const WrittenBody& written,
                            const Occluders& occluders, Share& share) {
    const View view = views_of(body)[3];
    const std::vector<camera::NamedCamera> photos{
        {"photo",
         camera::pinhole_from_fov(400, 400, 60.0, camera::look_at(written.world(view.eye), written.middle))}};
    const PhotoVisibility seen = photo_visibility(occluders, photos, {});
    for (std::size_t id = 0; id < view.slopes.size(); ++id)
      if (is_above_noise(view.slopes[id], writing)) share.add(seen.counts[id] == 1);
  });
}

}  // namespace
}  // namespace alidade::test
