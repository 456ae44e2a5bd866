// SPDX-License-Identifier: MIT
#include "extensions/photos/job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "base/error.h"
#include "cloud/read_cloud.h"
#include "tests/jobs/garden_job.h"

namespace alidade::test {
namespace {

using PhotosJobTest = GardenJobTest;

TEST_F(PhotosJobTest, photos_have_cameras_and_what_they_see) {
  std::ofstream(folder / "north.json")
      << R"({"version":1,"model":"pinhole","width":60,"height":40,"intrinsics":{"vertical_fov":60},)"
      << R"("pose":{"look_at":{"eye":[690005,5325002,603],"target":[690005,5325015,600],"up":[0,0,1]}}})";
  auto photos = request<jobs::PhotosRequest>();
  EXPECT_THROW(plan(photos), Error) << "no cameras";
  photos.cameras.file = folder / "north.json";
  photos.output = folder / "seen.las";
  const jobs::PhotosPlan checked = plan(photos);
  EXPECT_EQ(checked.request().camera_set.cameras.size(), 1u);
  const jobs::PhotosResult result = run(checked, heard);
  ASSERT_EQ(result.cameras.size(), 1u);
  ASSERT_EQ(result.seen.photos.size(), 1u);
  EXPECT_GT(result.seen.photos[0].points, 100u);
  EXPECT_EQ(static_cast<std::uint64_t>(std::ranges::count(result.seen.counts, 1u)),
            result.seen.photos[0].points);
  EXPECT_EQ(read_cloud(photos.output).size(), result.seen.counts.size());
}

}  // namespace
}  // namespace alidade::test
