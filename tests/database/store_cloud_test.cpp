// SPDX-License-Identifier: MIT
// Clouds become tables completely or not at all.
#include <tbb/task_arena.h>

#include <climits>
#include <fstream>
#include <thread>

#include "cloud/las/write_las.h"
#include "database/sqlite/cloud_schema.h"
#include "database/sqlite/stored_cloud.h"
#include "database/stored_column.h"
#include "octree/build.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/save_index.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

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
  EXPECT_NE(error_of_storing({}).find("the table points exists"), std::string::npos);
  EXPECT_NE(error_of_storing({.table = "POINTS"}).find("exists"), std::string::npos);
  {
    const Connection database(file_, Connection::Mode::write);
    EXPECT_EQ(numbers(database, "SELECT count(*) FROM points"), std::vector<double>{500});
    run(database.get(), "CREATE TABLE mine(x)");
  }
  EXPECT_EQ(error_of_storing({.replace = true}), "");
  EXPECT_NE(error_of_storing({.table = "mine", .replace = true}).find("a cloud"), std::string::npos);
  const Connection database(file_, Connection::Mode::write);
  EXPECT_EQ(numbers(database, "SELECT count(*) FROM points"), std::vector<double>{100});
  run(database.get(), "DROP TABLE points");
  EXPECT_EQ(rows(database, "SELECT name FROM sqlite_schema"), std::vector<std::string>{"mine"});
}

TEST_F(StoreCloudTest, what_is_replaced_is_a_cloud_by_more_than_its_name) {
  store_cloud(file_, site(10), {.table = "other"});
  {
    const Connection database(file_, Connection::Mode::write);
    run(database.get(), "CREATE TABLE points(mine)");
    run(database.get(), "CREATE TABLE points_bounds(mine)");
  }
  EXPECT_NE(error_of_storing({.replace = true}).find("a cloud"), std::string::npos);
  EXPECT_NE(error_of_storing({.table = std::string("a\0b", 3)}).find("name"), std::string::npos);
  EXPECT_NE(error_of_storing({.table = "SQLite_points"}).find("name"), std::string::npos);
}

TEST_F(StoreCloudTest, a_cloud_can_be_renamed) {
  store_cloud(file_, site(50));
  const Connection database(file_, Connection::Mode::write);
  run(database.get(), "ALTER TABLE points RENAME TO \"my \"\"points\"");
  EXPECT_EQ(numbers(database, "SELECT sum(red) FROM \"my \"\"points\""), std::vector<double>{49 * 25});
  run(database.get(), "BEGIN");
  run(database.get(), "ALTER TABLE \"my \"\"points\" RENAME TO mine");
  run(database.get(), "ROLLBACK");
  EXPECT_EQ(numbers(database, "SELECT sum(red) FROM \"my \"\"points\""), std::vector<double>{49 * 25});
  run(database.get(), "ALTER TABLE \"my \"\"points\" RENAME TO mine");
  run(database.get(), "DROP TABLE mine");
  EXPECT_EQ(rows(database, "SELECT name FROM sqlite_schema"), std::vector<std::string>());
}

TEST_F(StoreCloudTest, storing_waits_for_readers) {
  store_cloud(file_, site(50));
  const Connection reader(file_, Connection::Mode::read);
  std::optional<Statement> reading(std::in_place, reader.get(), "SELECT id FROM points");
  ASSERT_TRUE(reading->step());
  std::jthread ends([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    reading.reset();
  });
  EXPECT_EQ(error_of_storing({.table = "more"}), "");
}

TEST_F(StoreCloudTest, only_clouds_that_are_made_are_tables) {
  store_cloud(file_, site(50), {.table = "pointcloud_"});
  store_cloud(file_, site(50), {.table = "points"});
  const Connection database(file_, Connection::Mode::write);
  EXPECT_NE(error_of(database, "SELECT * FROM pointcloud").find("no such table: pointcloud"),
            std::string::npos);
}

TEST_F(StoreCloudTest, views_over_clouds_are_no_risk) {
  store_cloud(file_, site(50));
  const Connection database(file_, Connection::Mode::write);
  run(database.get(), "CREATE VIEW reds AS SELECT red FROM points");
  run(database.get(), "PRAGMA trusted_schema = OFF");
  EXPECT_EQ(numbers(database, "SELECT sum(red) FROM reds"), std::vector<double>{49 * 25});
}

TEST_F(StoreCloudTest, marks_for_no_value_are_compared_as_they_are) {
  PointCloud cloud = site(8);
  const auto add = [&]<class Value>(const char* name, ScalarType type, auto mark,
                                    const std::vector<Value>& values) {
    ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
    dimension.name = name;
    dimension.type = type;
    dimension.byte_count = sizeof(Value);
    dimension.no_data.emplace();
    std::memcpy(dimension.no_data->data(), &mark, sizeof mark);
    dimension.values.resize(sizeof(Value) * values.size());
    std::memcpy(dimension.values.data(), values.data(), dimension.values.size());
  };
  const std::uint64_t most = UINT64_MAX;
  const std::int64_t greatest = INT64_MAX;
  add("u", ScalarType::uint64, most,
      std::vector<std::uint64_t>{most, most - 1, most - 2, most - 3, 1, 2, 3, 4});
  add("i", ScalarType::int64, greatest,
      std::vector<std::int64_t>{greatest, greatest - 1, greatest - 2, -1, 1, 2, 3, 4});
  add("f", ScalarType::float32, -9999.9, std::vector<float>{-9999.9f, 1, 2, 3, 4, 5, 6, 7});
  add("d", ScalarType::float64, -9999.9, std::vector<double>{-9999.9, -9999.900390625, 2, 3, 4, 5, 6, 7});
  ExtraDimension& odd = cloud.extra_dimensions.emplace_back();
  odd.name = "odd";
  odd.type = ScalarType::uint8;
  odd.byte_count = 1;
  odd.values.assign(8, 3);
  odd.has_scale = odd.has_offset = true;
  odd.scale = std::numeric_limits<double>::quiet_NaN();
  store_cloud(file_, cloud);
  const Connection database(file_, Connection::Mode::read);
  for (const char* const name : {"u", "i", "f", "d"})
    EXPECT_EQ(numbers(database, fmt::format("SELECT count({}) FROM points", name)), std::vector<double>{7})
        << name;
  EXPECT_EQ(numbers(database, "SELECT sum(odd) FROM points"), std::vector<double>{24})
      << "a scale of NaN is ignored";
  EXPECT_EQ(numbers(database, "SELECT max(u) FROM points"), std::vector<double>{18446744073709551614.0})
      << "beyond the whole numbers of SQLite";
}

TEST_F(StoreCloudTest, numbers_are_scaled_before_their_offset_is_added) {
  PointCloud cloud = site(8);
  ExtraDimension lifted = plain_dimension("lifted", ScalarType::uint8);
  lifted.values.assign(8, 3);
  lifted.has_scale = lifted.has_offset = true;
  lifted.scale = 0.5;
  lifted.offset = 100.0;
  cloud.extra_dimensions.push_back(lifted);
  store_cloud(file_, cloud);
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(numbers(database, "SELECT DISTINCT lifted FROM points"), std::vector<double>{101.5});
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

TEST_F(StoreCloudTest, bad_requests_are_errors) {
  EXPECT_NE(error_of_storing({.chunk_points = 0}).find("1 to 65536"), std::string::npos);
  EXPECT_NE(error_of_storing({.chunk_points = 65537}).find("1 to 65536"), std::string::npos);
  EXPECT_NE(error_of_storing({.table = ""}).find("invalid table name"), std::string::npos);
  std::ofstream(file_)
      << "this is not a database, whatever its name is, and too long to be taken for an empty one";
  EXPECT_NE(error_of_storing({}).find("not a database"), std::string::npos);
}

TEST_F(StoreCloudTest, an_empty_cloud_is_an_empty_table) {
  store_cloud(file_, site(0));
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(numbers(database, "SELECT count(*) FROM points"), std::vector<double>{0});
  EXPECT_EQ(numbers(database, "SELECT count(*) FROM points(0, 0, 0, 1, 0, 0) WHERE dist < 1"),
            std::vector<double>{0});
}

std::string bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

TEST_F(StoreCloudTest, the_same_cloud_gives_the_same_file) {
  store_cloud(file_, site(5000));
  store_cloud(folder_ / "again.db", site(5000));
  EXPECT_TRUE(bytes(file_) == bytes(folder_ / "again.db"));
}

/// Files whose points lie among each other, some of them at equal positions: LAS with colours of 8 bits and
/// GeoTIFF keys, a text with a column of its own, an index file.
CloudInputs site_files(const std::filesystem::path& folder, PointCloud cloud) {
  for (Color16& color : cloud.colors) color = {color.x % 256, color.y % 256, 7};
  cloud.crs.geotiff_keys = {1, 1, 0, 1, 3072, 0, 1, 32632};
  cloud.crs.geotiff_doubles = {0.5};
  cloud.crs.geotiff_ascii = "UTM|";
  write_las(folder / "site.las", cloud);
  std::ofstream text(folder / "site.csv");
  text << "x,y,z,intensity,spare\n";
  for (std::size_t i = 0; i < cloud.size(); i += 2) {
    const glm::dvec3 world = cloud.world(i);
    text << fmt::format("{:.3f},{:.3f},{:.3f},{},{}\n", world.x, world.y, world.z, i % 999, i);
  }
  text.close();
  save_index(folder / "site.alidade", build(cloud), cloud);
  return resolve_clouds(std::vector{folder / "site.las", folder / "site.csv", folder / "site.alidade"},
                        index_and_file_formats());
}

TEST_F(StoreCloudTest, files_that_memory_does_not_hold_give_the_same_database) {
  const CloudInputs files = site_files(folder_, site(3000));
  const PointCloud cloud = read_cloud(files);
  store_cloud(file_, cloud);
  const std::filesystem::path other = folder_ / "other.db";
  for (const int threads : {1, 3}) {
    tbb::task_arena arena(threads);
    for (const std::uint64_t memory :
         {std::uint64_t{20'000}, std::uint64_t{200'000}, std::uint64_t{1} << 30}) {
      arena.execute([&] {
        const StoredFiles stored = store_files(other, files, {}, {}, memory);
        EXPECT_EQ(stored.point_count, cloud.size());
        EXPECT_EQ(stored.warnings, cloud.warnings);
      });
      EXPECT_TRUE(bytes(file_) == bytes(other)) << memory << " bytes, " << threads << " threads";
      std::filesystem::remove(other);
    }
  }
}

TEST_F(StoreCloudTest, the_reference_system_is_kept_as_it_came) {
  const CloudInputs files = site_files(folder_, site(10));
  store_files(file_, CloudInputs{{files.inputs[0]}});
  const Connection database(file_, Connection::Mode::read);
  const CloudSchema schema = read_cloud_schema(database.get(), "main", "points");
  const PointCloud cloud = read_cloud(files.first_name());
  EXPECT_FALSE(cloud.crs.geotiff_keys.empty());
  EXPECT_EQ(schema.crs, cloud.crs);
  EXPECT_EQ(schema.gps_time_is_standard, cloud.gps_time_is_standard);
}

TEST_F(StoreCloudTest, a_load_that_is_stopped_leaves_nothing_whenever_that_is) {
  // On one thread: reports of several are joined, now these and then those.
  tbb::task_arena one(1);
  const CloudInputs files = site_files(folder_, site(3000));
  const auto count_files = [&] {
    return std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator());
  };
  int calls = 0, most = INT_MAX;
  const Progress watch = [&](std::uint64_t, std::uint64_t) { return ++calls < most; };
  constexpr std::uint64_t k_memory = 50'000;
  const StoreOptions options{.chunk_points = 64, .progress = watch};
  one.execute([&] { store_files(file_, files, {.progress = watch}, options, k_memory); });
  const int all = calls;
  EXPECT_GT(all, 8);
  const std::string before = bytes(file_);
  StoreOptions again = options;
  again.table = "again";
  for (most = 1; most <= all; ++most) {
    for (const bool is_new : {true, false}) {
      calls = 0;
      const std::filesystem::path target = is_new ? folder_ / "new.db" : file_;
      const auto store = [&] { store_files(target, files, {.progress = watch}, again, k_memory); };
      EXPECT_THROW(one.execute(store), Cancelled);
    }
    EXPECT_EQ(count_files(), 4) << "three clouds and a database";
    EXPECT_TRUE(bytes(file_) == before) << most;
  }
}

TEST_F(StoreCloudTest, names_that_sql_takes_for_equal_are_made_distinct) {
  PointCloud cloud = site(10);
  const std::string at_most(62, 'n'), umlaut = at_most + "\u00fc";
  for (const std::string& name : {std::string("X"), std::string("Red"), std::string("height"), std::string(),
                                  std::string("dist"), umlaut, umlaut, std::string("XMax"),
                                  std::string("a\0b", 3), std::string("a\0c", 3), std::string("h\xf6he\n")}) {
    ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
    dimension.name = name;
    dimension.type = ScalarType::uint8;
    dimension.byte_count = 1;
    dimension.values.assign(10, 1);
  }
  std::vector<std::string> names;
  for (const StoredColumn& column : stored_columns(cloud)) names.push_back(column.name);
  EXPECT_EQ(names, (std::vector<std::string>{"id",
                                             "red",
                                             "green",
                                             "blue",
                                             "classification",
                                             "return_number",
                                             "number_of_returns",
                                             "gps_time",
                                             "Height",
                                             "X_2",
                                             "Red_2",
                                             "height_2",
                                             "unnamed",
                                             "dist",
                                             at_most,
                                             std::string(61, 'n') + "_2",
                                             "XMax_2",
                                             "a",
                                             "a_2",
                                             "h_he_"}));
  store_cloud(file_, cloud);
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(numbers(database, "SELECT sum(X_2 + dist + unnamed) FROM points"), std::vector<double>{30});
}

TEST_F(StoreCloudTest, number_of_returns_has_its_name_in_tables_of_earlier_versions) {
  PointCloud cloud = site(10);
  ExtraDimension& dimension =
      cloud.extra_dimensions.emplace_back(plain_dimension("Number_of_returns", ScalarType::uint8));
  dimension.values.assign(10, 7);
  store_cloud(file_, cloud);
  {
    const Connection database(file_, Connection::Mode::write);
    run(database.get(), "UPDATE points_column SET name = 'return_count' WHERE name = 'number_of_returns'");
    run(database.get(), "UPDATE points_column SET name = 'Number_of_returns' WHERE name LIKE '%returns_2'");
  }
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(numbers(database, "SELECT sum(number_of_returns) FROM points"), std::vector<double>{30});
  EXPECT_EQ(numbers(database, "SELECT sum(Number_of_returns_2) FROM points"), std::vector<double>{70});
  const CloudPart all = read_cloud_part(file_, std::vector<PointFilter>(1), AttributeSet::all());
  EXPECT_EQ(all.cloud.returns, cloud.returns);
}

TEST_F(StoreCloudTest, attributes_keep_names_that_columns_of_lines_have) {
  PointCloud cloud = site(10);
  for (const char* const name : {"t", "Dist", "dx", "ox", "ray_t"}) {
    ExtraDimension& dimension = cloud.extra_dimensions.emplace_back(plain_dimension(name, ScalarType::uint8));
    dimension.values.assign(10, 3);
  }
  store_cloud(file_, cloud);
  const Connection database(file_, Connection::Mode::read);
  EXPECT_EQ(numbers(database, "SELECT sum(t + dist + dx + ox + ray_t) FROM points WHERE t > 2"),
            std::vector<double>{150});
  const std::string line = "FROM points(690050,5325050,600, 0,0,-1)";
  EXPECT_EQ(numbers(database, "SELECT count(*) " + line + " WHERE ray_dist <= 50"),
            numbers(database,
                    "SELECT count(*) FROM points WHERE dist_ray(690050,5325050,600, 0,0,-1, x,y,z) <= 50"));
  EXPECT_EQ(numbers(database, "SELECT sum(abs(ray_ray_t - (600 - z)) < 1e-6) " + line),
            std::vector<double>{10});
  EXPECT_EQ(numbers(database, "SELECT sum(t) " + line), std::vector<double>{30});
}

}  // namespace
}  // namespace alidade::test
