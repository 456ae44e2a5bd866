// SPDX-License-Identifier: MIT
// The paper's database: points per second that go into SQLite, and the paper's ray query, with chunks left
// unread and without.
//   database_bench --benchmark_repetitions=5
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <string>

#include "cloud/las/write_las.h"
#include "database/sqlite/connection.h"
#include "database/sqlite/prepare.h"
#include "database/sqlite/store_cloud.h"
#include "tests/bench/timing.h"

namespace alidade::bench {

using namespace database;

namespace {

constexpr std::size_t k_points = 10'000'000;
constexpr const char* k_ray = "0,100,1.5, 1,0.2,0";

/// 200 by 200 m: half of the points on undulating ground, half on the faces of 60 boxes, in the order of a
/// scan that goes round about: at random.
PointCloud site() {
  std::mt19937_64 random(1);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  struct Box {
    glm::dvec3 corner, size;
  };
  std::vector<Box> boxes;
  for (int i = 0; i < 60; ++i)
    boxes.push_back({{190 * unit(), 190 * unit(), 0}, {5 + 10 * unit(), 5 + 10 * unit(), 3 + 9 * unit()}});
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(0.001);
  cloud.positions.reserve(k_points);
  while (cloud.positions.size() < k_points) {
    glm::dvec3 position;
    if (cloud.positions.size() % 2 == 0) {
      position = {200 * unit(), 200 * unit(), 0};
      position.z = 3 * std::sin(position.x / 12) * std::cos(position.y / 17) - 2.5 + 0.02 * unit();
    } else {
      const Box& box = boxes[random() % boxes.size()];
      glm::dvec3 part(unit(), unit(), unit());
      const std::uint64_t face = random() % 6;
      part[static_cast<int>(face % 3)] = face < 3 ? 0.0 : 1.0;
      position = box.corner + part * box.size;
    }
    cloud.positions.push_back(*to_lattice(cloud.lattice, position));
  }
  return cloud;
}

/// The folder of the files, gone with the program.
class Files {
 public:
  Files() : folder_(std::filesystem::temp_directory_path() / fmt::format("database_bench_{}", ::getpid())) {
    std::filesystem::create_directories(folder_);
  }
  ~Files() {
    std::error_code error;
    std::filesystem::remove_all(folder_, error);
  }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  /// The site with times, intensities and classes, as LAS; written by the first call.
  std::filesystem::path las() const {
    const std::filesystem::path file = folder_ / "site.las";
    if (std::filesystem::exists(file)) return file;
    PointCloud cloud = site();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud.gps_times.push_back(1e-6 * static_cast<double>(i));
      cloud.intensities.push_back(static_cast<std::uint16_t>(i % 4096));
      cloud.classifications.push_back(i % 2 == 0 ? 2 : 6);
    }
    write_las(file, cloud);
    return file;
  }

  /// Positions alone, as the figures in the paper's manner want it.
  std::filesystem::path database() const {
    const std::filesystem::path file = folder_ / "site.db";
    if (!std::filesystem::exists(file)) store_cloud(file, site());
    return file;
  }

  std::filesystem::path other_database() const { return folder_ / "other.db"; }

 private:
  std::filesystem::path folder_;
};

void load(benchmark::State& state, const Files& files, std::uint64_t memory) {
  const std::filesystem::path las = files.las();
  for (auto _ : state) {
    on_threads(2, [&] {
      OrderedCloud cloud(las.parent_path(), resolve_clouds({&las, 1}), {}, memory);
      store_cloud(files.other_database(), cloud);
    });
  }
  std::filesystem::remove(files.other_database());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_points));
}

std::uint64_t count_rows(sqlite3_stmt* statement) {
  std::uint64_t rows = 0;
  while (sqlite3_step(statement) == SQLITE_ROW) {
    for (int column = 0; column < sqlite3_column_count(statement); ++column)
      benchmark::DoNotOptimize(sqlite3_column_double(statement, column));
    ++rows;
  }
  return rows;
}

void time_statement(benchmark::State& state, const Files& files, const std::string& sql, bool is_pruned) {
  const Connection connection(files.database(), Connection::Mode::read);
  // Run once before it is timed, so that caches are filled.
  count_rows(prepare(connection.get(), sql).statement.get());
  const ScanReads before = connection.reads();
  std::uint64_t rows = 0;
  for (auto _ : state) {
    const StatementHandle statement = [&] {
      if (is_pruned) return prepare(connection.get(), sql).statement;
      sqlite3_stmt* plain = nullptr;
      sqlite3_prepare_v2(connection.get(), sql.c_str(), -1, &plain, nullptr);
      return StatementHandle(plain);
    }();
    rows += count_rows(statement.get());
  }
  const auto passes = static_cast<double>(state.iterations());
  state.counters["rows"] = static_cast<double>(rows) / passes;
  state.counters["chunks_read"] =
      static_cast<double>(connection.reads().chunks_read - before.chunks_read) / passes;
  state.counters["chunks"] = static_cast<double>(connection.reads().chunks - before.chunks) / passes;
}

}  // namespace
}  // namespace alidade::bench

int main(int argc, char** argv) {
  using namespace alidade::bench;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const Files files;
  add_benchmark(2, {"sql", "load"},
                [&](benchmark::State& state) { load(state, files, std::uint64_t{1} << 30); });
  add_benchmark(2, {"sql", "load_128M"},
                [&](benchmark::State& state) { load(state, files, std::uint64_t{128} << 20); });
  const std::string statement = fmt::format("SELECT * FROM points WHERE dist_ray({}, x,y,z) <= ", k_ray);
  for (const char* const radius : {"1", "0.1"}) {
    for (const bool is_pruned : {true, false}) {
      add_benchmark(1, {"sql", "ray", radius, is_pruned ? "pruned" : "plain"},
                    [&files, sql = statement + radius, is_pruned](benchmark::State& state) {
                      time_statement(state, files, sql, is_pruned);
                    });
    }
  }
  const std::string form = fmt::format("points({}) ", k_ray);
  add_benchmark(1, {"sql", "ray_form", "1"}, [&, form](benchmark::State& state) {
    time_statement(state, files, "SELECT *, dist, t FROM " + form + "WHERE dist <= 1", false);
  });
  add_benchmark(1, {"sql", "first_hit", "1"}, [&, form](benchmark::State& state) {
    time_statement(state, files,
                   "SELECT id, t FROM " + form + "WHERE dist <= 1 AND t >= 0 ORDER BY t LIMIT 1", false);
  });
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
