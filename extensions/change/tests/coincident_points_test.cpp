// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "extensions/change/change.h"
#include "octree/build.h"
#include "tests/visibility/point_clusters.h"

namespace alidade::test {

using namespace visibility;

namespace {

TEST(CoincidentPoints, of_epochs_have_one_finding_each) {
  const PointCloud before = site_with_clusters(3000);
  PointCloud after = before;
  for (auto& position : after.positions)
    if (position.z > -1000) position.x += 40;
  std::atomic<std::uint64_t> calls = 0;
  const auto counts = [&](std::uint64_t) {
    ++calls;
    return true;
  };
  const Occluders old_occluders(build(before), {.counts = counts}),
      new_occluders(build(after), {.counts = counts});
  const Changes changes = find_changes({old_occluders, {}}, {new_occluders, {}}, {});
  for (std::size_t id = 0; id < before.size(); ++id) {
    const auto same = static_cast<std::size_t>(std::ranges::find(before.positions, before.positions[id]) -
                                               before.positions.begin());
    ASSERT_EQ(changes.before.classes[id], changes.before.classes[same]) << id;
  }
  // Each of them has thousands of others around it.
  EXPECT_LT(calls, 2 * before.size() * 400);
}

}  // namespace
}  // namespace alidade::test
