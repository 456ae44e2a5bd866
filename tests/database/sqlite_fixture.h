// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "database/sqlite/connection.h"
#include "database/sqlite/store_cloud.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace database;

/// A folder with the database site.db, gone with the test.
class SqliteTest : public ::testing::Test {
 protected:
  SqliteTest()
      : folder_(std::filesystem::temp_directory_path() /
                fmt::format("sqlite_{}_{}", ::testing::UnitTest::GetInstance()->current_test_info()->name(),
                            ::getpid())),
        file_(folder_ / "site.db") {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~SqliteTest() override { std::filesystem::remove_all(folder_); }

  /// Points with UTM-like coordinates, half of them near a sheet; with attributes of several kinds.
  static PointCloud site(std::size_t count) {
    Random random("sqlite site");
    PointCloud cloud;
    cloud.lattice = {glm::dvec3(0.001), glm::dvec3(690000, 5325000, 400)};
    for (std::size_t i = 0; i < count; ++i) {
      const bool on_sheet = i % 2 == 0;
      cloud.positions.push_back(LatticePosition(random.below(100'000), random.below(100'000),
                                                on_sheet ? random.below(500) : random.below(30'000)));
      cloud.colors.push_back(Color16(i % 65536, 2 * i % 65536, 7));
      cloud.classifications.push_back(static_cast<std::uint8_t>(i % 19));
      cloud.returns.push_back({static_cast<std::uint8_t>(1 + i % 3), 3});
      cloud.gps_times.push_back(1e9 + 0.25 * static_cast<double>(i));
    }
    ExtraDimension height;
    height.name = "Height";
    height.type = ScalarType::int16;
    height.byte_count = 2;
    height.scale = 0.01;
    height.has_scale = true;
    height.no_data.emplace();
    height.no_data->fill(0);
    for (std::size_t i = 0; i < count; ++i) {
      height.values.push_back(static_cast<std::uint8_t>(i % 200));
      height.values.push_back(0);
    }
    cloud.extra_dimensions.push_back(height);
    return cloud;
  }

  /// Stores cloud files, with so many bytes of memory for points.
  static StoredFiles store_files(const std::filesystem::path& database, const CloudInputs& inputs,
                                 const ReadOptions& reading = {}, const StoreOptions& options = {},
                                 std::uint64_t memory = std::uint64_t{1} << 30) {
    check_store(database, options);
    OrderedCloud cloud(database.parent_path(), inputs, reading, memory);
    store_cloud(database, cloud, options);
    return std::move(cloud).stored();
  }

  /// The first column of all rows as text.
  static std::vector<std::string> rows(const Connection& connection, const std::string& sql) {
    Statement statement(connection.get(), sql);
    std::vector<std::string> found;
    while (statement.step()) found.push_back(statement.text(0));
    return found;
  }

  /// The first column of all rows as numbers.
  static std::vector<double> numbers(const Connection& connection, const std::string& sql) {
    Statement statement(connection.get(), sql);
    std::vector<double> found;
    while (statement.step()) found.push_back(statement.number(0));
    return found;
  }

  /// What running the statement says; empty if it is no error.
  static std::string error_of(const Connection& connection, const std::string& sql) {
    try {
      Statement statement(connection.get(), sql);
      while (statement.step()) {
      }
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

  std::filesystem::path folder_, file_;
};

}  // namespace alidade::test
