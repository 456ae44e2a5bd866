// SPDX-License-Identifier: MIT
// A cloud that comes back out of a database is the one that went in.
#include <cstring>

#include "cloud/point_cloud.h"
#include "cloud/read_cloud.h"
#include "database/sqlite/stored_cloud.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

namespace {

CloudInputs clouds_of(std::initializer_list<std::filesystem::path> names) {
  static const std::vector<const CloudFormat*> formats = with_file_formats({&k_sqlite_format});
  return resolve_clouds(std::span(names.begin(), names.size()), formats);
}

class ReadCloudTableTest : public SqliteTest {
 protected:
  std::string error_of_reading(const std::string& name) const {
    try {
      read_cloud(clouds_of({name}));
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

  std::string error_after(const std::string& change) const {
    std::filesystem::remove(file_);
    store_cloud(file_, site(1000), {.chunk_points = 10});
    run(Connection(file_, Connection::Mode::write).get(), change);
    return error_of_reading(file_);
  }
};

void expect_same_columns(const PointCloud& a, const PointCloud& b) {
  for_each_column(a, b, [](Attribute attribute, const auto& one, const auto& other) {
    const bool is_equal =
        one.size() == other.size() &&
        (one.empty() || std::memcmp(one.data(), other.data(), one.size() * sizeof one[0]) == 0);
    EXPECT_TRUE(is_equal) << static_cast<std::uint32_t>(attribute);
  });
  ASSERT_EQ(a.extra_dimensions.size(), b.extra_dimensions.size());
  for (std::size_t i = 0; i < a.extra_dimensions.size(); ++i) {
    EXPECT_EQ(a.extra_dimensions[i].name, b.extra_dimensions[i].name);
    EXPECT_EQ(a.extra_dimensions[i].type, b.extra_dimensions[i].type);
    EXPECT_EQ(a.extra_dimensions[i].scale, b.extra_dimensions[i].scale);
    EXPECT_EQ(a.extra_dimensions[i].has_scale, b.extra_dimensions[i].has_scale);
    EXPECT_EQ(a.extra_dimensions[i].no_data, b.extra_dimensions[i].no_data);
    EXPECT_EQ(a.extra_dimensions[i].values, b.extra_dimensions[i].values);
  }
}

TEST_F(ReadCloudTableTest, rows_and_attributes_come_back) {
  PointCloud cloud = site(5000);
  cloud.crs.wkt = "LOCAL_CS[\"yard\"]";
  cloud.normals.assign(5000, glm::vec3(0.0f, 0.6f, 0.8f));
  cloud.intensities.assign(5000, 7);
  store_cloud(file_, cloud, {.chunk_points = 64});
  const PointCloud back = read_cloud(clouds_of({file_}));
  EXPECT_EQ(back.lattice, cloud.lattice);
  EXPECT_EQ(back.positions, cloud.positions);
  EXPECT_EQ(back.crs.wkt, cloud.crs.wkt);
  expect_same_columns(back, cloud);
  EXPECT_EQ(back.files.front().format, "SQLite");
  const Bounds box = stated_size(clouds_of({file_})).box;
  EXPECT_EQ(box.min, cloud.bounds().min);
  EXPECT_EQ(box.max, cloud.bounds().max);

  const PointCloud some = read_cloud(clouds_of({file_}), {.attributes = Attribute::classification});
  EXPECT_EQ(some.attributes(), AttributeSet(Attribute::classification));
  EXPECT_EQ(some.classifications, cloud.classifications);
}

TEST_F(ReadCloudTableTest, clouds_are_joined_on_the_first_ones_lattice) {
  PointCloud other = site(300);
  other.lattice.offset.x += 5.0;
  store_cloud(file_, site(500));
  store_cloud(file_, other, {.table = "it's"});
  const std::string name = file_.string() + "?table=";
  const PointCloud both = read_cloud(clouds_of({name + "points", name + "it's"}));
  ASSERT_EQ(both.size(), 800u);
  for (std::size_t row = 0; row < 300; ++row) EXPECT_EQ(both.world(500 + row).x, other.world(row).x);
}

TEST_F(ReadCloudTableTest, ambiguous_clouds_are_errors) {
  store_cloud(file_, site(50));
  EXPECT_EQ(read_cloud(clouds_of({file_})).size(), 50u);
  store_cloud(file_, site(60), {.table = "more"});
  EXPECT_EQ(read_cloud(clouds_of({file_.string() + "?table=more"})).size(), 60u);
  for (const char* const name : {"", "?table=", "?table=mor", "?table=more'; DROP TABLE more; --"}) {
    const std::string error = error_of_reading(file_.string() + name);
    EXPECT_NE(error.find("more, points"), std::string::npos) << error;
  }
  run(Connection(file_, Connection::Mode::write).get(), "DROP TABLE points");
  run(Connection(file_, Connection::Mode::write).get(), "DROP TABLE more");
  EXPECT_NE(error_of_reading(file_).find("contains no cloud"), std::string::npos);
  EXPECT_NE(error_of_reading(folder_ / "no.db?table=points").find("no.db"), std::string::npos);
}

TEST_F(ReadCloudTableTest, an_empty_cloud_is_one) {
  store_cloud(file_, PointCloud());
  EXPECT_EQ(read_cloud(clouds_of({file_})).size(), 0u);
}

TEST_F(ReadCloudTableTest, damage_is_reported) {
  EXPECT_NE(error_after("UPDATE points_cloud SET points = chunks * 65536")
                .find("the number of points exceeds the file"),
            std::string::npos);
  EXPECT_NE(error_after("UPDATE points_cloud SET points = 1001").find("missing points"), std::string::npos);
  EXPECT_NE(error_after("UPDATE points_cloud SET points = 999").find("ids do not match the rows"),
            std::string::npos);
  EXPECT_NE(error_after("UPDATE points_value SET data = (SELECT data FROM points_value WHERE id = 1)"
                        " WHERE id = 2")
                .find("chunk 2"),
            std::string::npos);
  EXPECT_NE(error_after("UPDATE points_column SET size = 1, type = 1 WHERE name = 'id'").find("ids"),
            std::string::npos);
  EXPECT_NE(error_after("UPDATE points_column SET blob = 1 WHERE name = 'Height'").find("Height"),
            std::string::npos);
  EXPECT_NE(error_after("UPDATE points_chunk SET positions = zeroblob(12), points = 1 WHERE id = 4"), "");
}

}  // namespace
}  // namespace alidade::test
