// SPDX-License-Identifier: MIT
#include "jobs/cloud_fields.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "jobs/field_table.h"
#include "jobs/visibility/points.h"
#include "tests/support/garden.h"

namespace alidade::jobs {
namespace {

class CloudFieldsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    file = std::filesystem::temp_directory_path() / ("alidade_fields_" + std::to_string(::getpid()) + ".las");
    write_las(file, test::garden(test::k_metres));
  }
  void TearDown() override { std::filesystem::remove(file); }

  /// The points that fields select; the table is gone before they are read.
  PointCloud selected(const std::vector<std::pair<std::string, std::string>>& given,
                      const std::function<bool()>& stops = {}) {
    CloudInputs clouds;
    {
      const auto table = std::make_shared<FieldTable>("thing", stops);
      add_cloud(Fields(table), clouds);
      table->give("cloud", {file.string()});
      for (const auto& [name, text] : given) table->give(name, {text});
      table->read();
    }
    return read_cloud(clouds);
  }

  std::filesystem::path file;
};

TEST_F(CloudFieldsTest, points_are_those_of_all_conditions) {
  const PointCloud all = selected({}),
                   part = selected({{"crop", "690000,5325000,690010,5325020"}, {"where", "z < 601"}});
  std::size_t expected = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    expected += all.world(i).x <= 690010.0 && all.world(i).z < 601.0 ? 1 : 0;
  EXPECT_EQ(part.size(), expected);
  EXPECT_LT(part.size(), all.size());
  EXPECT_EQ(selected({{"crs", "EPSG:25832"}}).size(), all.size());
}

TEST_F(CloudFieldsTest, conditions_end_when_the_door_stops) {
  EXPECT_THROW(selected({{"where", "z < 601"}}, [] { return true; }), Cancelled);
}

TEST_F(CloudFieldsTest, a_checkpoint_requires_the_fields_of_its_request) {
  PointsRequest request;
  request.files = resolve_clouds({&file, 1});
  request.observers.positions = {visibility::parse_observer("690005,5325010,601")};
  request.checkpoint.file = file.string() + ".checkpoint";
  EXPECT_THROW((void)plan(request), Error);
  const auto table = std::make_shared<FieldTable>("thing");
  request.checkpoint.fields = Fields(table);
  EXPECT_NO_THROW((void)plan(request));
}

}  // namespace
}  // namespace alidade::jobs
