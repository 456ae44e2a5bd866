// SPDX-License-Identifier: MIT
// Clouds become tables as a whole or not at all.
#include <fstream>

#include "database/stored_column.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {
namespace {

class StoreCloudTest : public SqliteTest {
 protected:
  std::string error_of_storing(const StoreOptions& options) const {
    try {
      store_cloud(file_, site(100), options);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
};

TEST_F(StoreCloudTest, several_clouds_of_any_name_share_a_file) {
  const std::string name = "we\"ird'; DROP TABLE points; --";
  store_cloud(file_, site(500));
  store_cloud(file_, site(300), {.table = name, .chunk_points = 7});
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(numbers(database, "SELECT count(*) FROM points"), std::vector<double>{500});
  EXPECT_EQ(numbers(database, "SELECT count(*) FROM " + sql_name(name)), std::vector<double>{300});
}

TEST_F(StoreCloudTest, a_table_is_replaced_only_when_that_is_wanted) {
  store_cloud(file_, site(500));
  EXPECT_NE(error_of_storing({}).find("there is a table points already"), std::string::npos);
  EXPECT_NE(error_of_storing({.table = "POINTS"}).find("already"), std::string::npos);
  {
    const Connection database(file_, Connection::Mode::write);
    EXPECT_EQ(numbers(database, "SELECT count(*) FROM points"), std::vector<double>{500});
    run(database.get(), "CREATE TABLE mine(x)");
  }
  EXPECT_EQ(error_of_storing({.replace = true}), "");
  EXPECT_NE(error_of_storing({.table = "mine", .replace = true}).find("a cloud to replace"),
            std::string::npos);
  const Connection database(file_, Connection::Mode::write);
  EXPECT_EQ(numbers(database, "SELECT count(*) FROM points"), std::vector<double>{100});
  run(database.get(), "DROP TABLE points");
  EXPECT_EQ(rows(database, "SELECT name FROM sqlite_schema"), std::vector<std::string>{"mine"});
}

TEST_F(StoreCloudTest, stopping_leaves_no_file_and_no_table) {
  const StoreOptions stopped{.table = "more",
                             .chunk_points = 1,
                             .progress = [](std::uint64_t done, std::uint64_t) { return done < 90; }};
  EXPECT_THROW(store_cloud(file_, site(100), stopped), Cancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  store_cloud(file_, site(100));
  EXPECT_THROW(store_cloud(file_, site(100), stopped), Cancelled);
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(rows(database, "SELECT name FROM sqlite_schema WHERE name LIKE 'more%'"),
            std::vector<std::string>());
}

TEST_F(StoreCloudTest, bad_requests_are_told) {
  EXPECT_NE(error_of_storing({.chunk_points = 0}).find("1 to 65536"), std::string::npos);
  EXPECT_NE(error_of_storing({.chunk_points = 65537}).find("1 to 65536"), std::string::npos);
  EXPECT_NE(error_of_storing({.table = ""}).find("no name"), std::string::npos);
  std::ofstream(file_)
      << "this is no database, whatever its name says, and long enough to be told from an empty one";
  EXPECT_NE(error_of_storing({}).find("not a database"), std::string::npos);
}

TEST_F(StoreCloudTest, an_empty_cloud_is_an_empty_table) {
  store_cloud(file_, site(0));
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(numbers(database, "SELECT count(*) FROM points"), std::vector<double>{0});
  EXPECT_EQ(numbers(database, "SELECT count(*) FROM points(0, 0, 0, 1, 0, 0) WHERE dist < 1"),
            std::vector<double>{0});
}

TEST_F(StoreCloudTest, the_same_cloud_gives_the_same_file) {
  store_cloud(file_, site(5000));
  store_cloud(folder_ / "again.db", site(5000));
  const auto bytes = [](const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  EXPECT_TRUE(bytes(file_) == bytes(folder_ / "again.db"));
}

TEST_F(StoreCloudTest, names_that_sql_takes_for_equal_are_told_apart) {
  PointCloud cloud = site(10);
  const std::string at_most(62, 'n'), umlaut = at_most + "\u00fc";
  for (const std::string& name : {std::string("X"), std::string("Red"), std::string("height"), std::string(),
                                  std::string("dist"), umlaut, umlaut, std::string("XMax")}) {
    ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
    dimension.name = name;
    dimension.type = ScalarType::uint8;
    dimension.byte_count = 1;
    dimension.values.assign(10, 1);
  }
  std::vector<std::string> names;
  for (const StoredColumn& column : stored_columns(cloud)) names.push_back(column.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{"id", "red", "green", "blue", "classification", "return_number",
                                      "return_count", "gps_time", "Height", "X_2", "Red_2", "height_2",
                                      "unnamed", "dist_2", at_most, std::string(61, 'n') + "_2", "XMax_2"}));
  store_cloud(file_, cloud);
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(numbers(database, "SELECT sum(X_2 + dist_2 + unnamed) FROM points"), std::vector<double>{30});
}

}  // namespace
}  // namespace alidade::test
