// SPDX-License-Identifier: MIT
// The names of shards, the rows as COPY takes them, and the scripts that servers get of a cloud: no name ends
// its quotes.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <filesystem>

#include <bit>
#include <cstring>
#include <fstream>
#include <set>

#include "base/error.h"
#include "cloud/ply/write_ply.h"
#include "extensions/postgres/copy_format.h"
#include "extensions/postgres/shard_plan.h"

namespace alidade::test {

using namespace database;

namespace {

template <class Work>
std::string error_of(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

std::filesystem::path parent_path() {
  return std::filesystem::temp_directory_path() / fmt::format("shard_plan_{}", ::getpid());
}

TEST(Shard, is_named_by_host_port_and_database) {
  EXPECT_EQ(parse_shard("db1/site"), (Shard{"db1", 5432, "site"}));
  EXPECT_EQ(parse_shard("10.0.0.7:5433/Site's"), (Shard{"10.0.0.7", 5433, "Site's"}));
  EXPECT_EQ(parse_shard("[::1]:5434/site"), (Shard{"::1", 5434, "site"}));
  EXPECT_EQ(parse_shard("[::1]/site"), (Shard{"::1", 5432, "site"}));
  for (const char* const wrong : {"", "/", "db1", "db1/", "/site", "db1:/site", "db1:0/site",
                                  "db1:65536/site", "db1:5432x/site", "[::1/site", "[::1]x/site", "a/b/c",
                                  "db1/si te", "-h/site", "db1/-c", "db1/password=secret", "db1/\x1b[2J"})
    EXPECT_NE(error_of([&] { parse_shard(wrong); }), "") << wrong;
}

TEST(Shard, passwords_are_rejected_and_not_repeated) {
  for (const char* const wrong : {"me:secret@db1/site", "postgresql://me:secret@db1/site"}) {
    const std::string error = error_of([&] { parse_shard(wrong); });
    EXPECT_NE(error.find("password"), std::string::npos);
    EXPECT_EQ(error.find("secret"), std::string::npos) << error;
  }
}

/// Two points with all kinds of columns.
PointCloud two_points() {
  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.001), glm::dvec3(690000, 5325000, 400)};
  cloud.positions = {LatticePosition(1, 2, 3), LatticePosition(-1, -2, -3)};
  cloud.intensities = {65535, 0};
  cloud.scan_angles = {-1.5f, 2.0f};
  const auto add = [&](const char* name, ScalarType type, auto first, auto second) {
    ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
    dimension.name = name;
    dimension.type = type;
    dimension.byte_count = sizeof first;
    dimension.values.resize(2 * sizeof first);
    std::memcpy(dimension.values.data(), &first, sizeof first);
    std::memcpy(dimension.values.data() + sizeof first, &second, sizeof first);
    return &dimension;
  };
  add("large", ScalarType::uint64, std::uint64_t{18446744073709551615u}, std::uint64_t{50000});
  ExtraDimension* const height = add("height", ScalarType::int16, std::int16_t{-200}, std::int16_t{7});
  height->scale = 0.01;
  height->has_scale = true;
  height->no_data.emplace();
  height->no_data->fill(0);
  height->no_data->front() = 7;
  add("raw", ScalarType::bytes, std::uint32_t{0x04030201}, std::uint32_t{0});
  return cloud;
}

/// Reads fields as PostgreSQL does.
class Fields {
 public:
  explicit Fields(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class Number>
  Number number() {
    std::array<std::byte, sizeof(Number)> field;
    for (std::size_t i = 0; i < sizeof(Number); ++i) field[sizeof(Number) - 1 - i] = bytes_[i];
    bytes_ = bytes_.subspan(sizeof(Number));
    return std::bit_cast<Number>(field);
  }
  template <class Number>
  Number field() {
    EXPECT_EQ(number<std::int32_t>(), static_cast<std::int32_t>(sizeof(Number)));
    return number<Number>();
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

TEST(CopyRows, fields_are_those_of_the_points) {
  const PointCloud cloud = two_points();
  const CopyRows rows(stored_columns(cloud), cloud.lattice);
  EXPECT_EQ(server_columns(rows.columns()),
            "id bigint NOT NULL, x double precision NOT NULL, y double precision NOT NULL, "
            "z double precision NOT NULL, \"intensity\" integer, \"scan_angle\" real, \"large\" numeric(20), "
            "\"height\" double precision, \"raw\" bytea");
  std::vector<std::byte> bytes;
  PointStream stream(parent_path());
  stream.finish(cloud);
  const EncodedChunks points = encode({.lattice = cloud.lattice, .blobs = stream.blobs()}, stream.next(2));
  // Along the Morton curve, the second one comes first.
  rows.append(points, 1, bytes);
  rows.append(points, 0, bytes);
  Fields fields(bytes);
  for (std::int64_t row = 0; row < 2; ++row) {
    EXPECT_EQ(fields.number<std::int16_t>(), 9);
    EXPECT_EQ(fields.field<std::int64_t>(), row);
    const glm::dvec3 position = cloud.world(static_cast<std::size_t>(row));
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(fields.field<double>(), position[axis]);
    EXPECT_EQ(fields.field<std::int32_t>(), row == 0 ? 65535 : 0);
    EXPECT_EQ(fields.field<float>(), row == 0 ? -1.5f : 2.0f);
    // 1844 6744 0737 0955 1615, and 5 0000, whose zeros are left out.
    const std::vector<int> digits = row == 0 ? std::vector{1844, 6744, 737, 955, 1615} : std::vector{5};
    EXPECT_EQ(fields.number<std::int32_t>(), static_cast<std::int32_t>(8 + 2 * digits.size()));
    EXPECT_EQ(fields.number<std::int16_t>(), static_cast<std::int16_t>(digits.size()));
    EXPECT_EQ(fields.number<std::int16_t>(), row == 0 ? 4 : 1);
    EXPECT_EQ(fields.number<std::int16_t>(), 0);
    EXPECT_EQ(fields.number<std::int16_t>(), 0);
    for (const int digit : digits) EXPECT_EQ(fields.number<std::int16_t>(), digit);
    if (row == 0)
      EXPECT_EQ(fields.field<double>(), 0.01 * -200);
    else
      EXPECT_EQ(fields.number<std::int32_t>(), -1);
    EXPECT_EQ(fields.field<std::uint32_t>(), row == 0 ? 0x01020304u : 0u);
  }
  EXPECT_TRUE(fields.at_end());
}

class ShardPlanTest : public ::testing::Test {
 protected:
  ShardPlanTest() {
    std::filesystem::remove_all(parent_);
    std::filesystem::create_directories(parent_);
  }
  ~ShardPlanTest() override { std::filesystem::remove_all(parent_); }

  static std::string text_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  }

  /// A cloud file of so many points in a line.
  std::filesystem::path line(int count) const {
    PointCloud cloud;
    for (int i = 0; i < count; ++i) cloud.positions.emplace_back(i, 0, 0);
    const std::filesystem::path path = parent_ / fmt::format("line_{}.ply", count);
    write_ply(path, cloud, {.overwrite = true});
    return path;
  }

  static void plan(const std::filesystem::path& folder, const std::filesystem::path& file,
                   const ShardPlanOptions& options = {}, std::uint64_t memory = std::uint64_t{1} << 30) {
    OrderedCloud cloud(file.parent_path(), resolve_clouds({&file, 1}), {}, memory);
    write_shard_plan(folder, cloud, k_shards, options);
  }

  static inline const std::vector<Shard> k_shards = {
      {"db1", 5432, "site"}, {"db2", 5433, "it's"}, {"db3", 5432, "site"}};
  const std::filesystem::path parent_ = parent_path();
  const std::filesystem::path folder_ = parent_ / "plan";
};

TEST_F(ShardPlanTest, parts_are_equally_large_and_hold_each_point_once) {
  // Little memory: pieces are merged.
  plan(folder_, line(100), {}, 1000);
  std::multiset<std::int64_t> ids;
  constexpr std::size_t k_head = 19, k_tail = 2, k_row = 2 + 4 * 12;
  for (int shard = 1; shard <= 3; ++shard) {
    const std::string bytes = text_of(folder_ / fmt::format("shard_{}.copy", shard));
    const std::size_t rows = (bytes.size() - k_head - k_tail) / k_row;
    EXPECT_EQ(bytes.size(), k_head + k_tail + rows * k_row);
    EXPECT_EQ(rows, shard == 1 ? 34u : 33u);
    EXPECT_EQ(bytes.substr(0, 11), std::string("PGCOPY\n\377\r\n\0", 11));
    EXPECT_EQ(bytes.substr(bytes.size() - k_tail), "\377\377");
    const std::span all = std::as_bytes(std::span(bytes));
    for (std::size_t row = 0; row < rows; ++row) {
      Fields fields(all.subspan(k_head + row * k_row + 2, 12));
      ids.insert(fields.field<std::int64_t>());
    }
  }
  EXPECT_EQ(ids.size(), 100u);
  EXPECT_EQ(std::set(ids.begin(), ids.end()).size(), 100u);
}

TEST_F(ShardPlanTest, names_cannot_leave_their_quotes_in_a_script) {
  plan(folder_, line(10), {.table = "a\"b'; DROP TABLE c; --"});
  EXPECT_NE(text_of(folder_ / "shard_1.sql").find("CREATE TABLE \"a\"\"b'; DROP TABLE c; --\"("),
            std::string::npos);
  const std::string coordinator = text_of(folder_ / "coordinator.sql");
  EXPECT_NE(coordinator.find("(host 'db2', port '5433', dbname 'it''s',"), std::string::npos) << coordinator;
  EXPECT_NE(coordinator.find("OPTIONS (table_name 'a\"b''; DROP TABLE c; --')"), std::string::npos);
  EXPECT_NE(text_of(folder_ / "README.txt").find("psql -h db2 -p 5433 -d 'it'\\''s' -f shard_2.sql"),
            std::string::npos);
  for (const std::string& table :
       {std::string(), std::string("a\nb"), std::string("\xff"), std::string(41, 'n')})
    EXPECT_NE(error_of([&] { plan(parent_ / "more", line(10), {.table = table}); }), "");
}

TEST_F(ShardPlanTest, a_folder_appears_completely_or_not_at_all) {
  const ShardPlanOptions stopped{.progress = [](std::uint64_t done, std::uint64_t) { return done < 60; }};
  EXPECT_THROW(plan(folder_, line(100), stopped), Cancelled);
  EXPECT_NE(error_of([&] { plan(folder_, line(2)); }).find("2 points"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_));
  for (const auto& entry : std::filesystem::directory_iterator(parent_))
    EXPECT_TRUE(entry.path().extension() == ".ply") << entry.path();
  plan(folder_ / "", line(100));
  EXPECT_NE(error_of([&] { plan(folder_, line(100)); }).find("the folder exists"), std::string::npos);
  EXPECT_NE(error_of([&] { plan(parent_ / "no" / "plan", line(100)); }).find("cannot create the folder"),
            std::string::npos);
}

}  // namespace
}  // namespace alidade::test
