// SPDX-License-Identifier: MIT
#include "extensions/scratch/scratch_cloud.h"

#include "cloud/las/write_las.h"
#include "cloud/rows.h"
#include "cloud/select_points.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

constexpr std::size_t k_points = 120'000;

/// With colours of 8 bits, which is known once all are read.
PointCloud colored_cloud() {
  test::Random random;
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(0.01);
  for (std::size_t i = 0; i < k_points; ++i) {
    const std::uint64_t bits = random.bits();
    const auto byte = [&](int shift) { return static_cast<std::uint16_t>(bits >> shift & 255); };
    cloud.positions.emplace_back(static_cast<int>(i), byte(0), byte(8));
    cloud.intensities.push_back(byte(16));
    cloud.colors.emplace_back(byte(24), byte(32), byte(40));
  }
  return cloud;
}

class ScratchCloudTest : public ::testing::Test {
 protected:
  ScratchCloud read(const std::filesystem::path& file, ScratchCheckpoint* checkpoint,
                    const Progress& progress = {}) {
    return {resolve_clouds(std::span(&file, 1)),
            {.progress = progress},
            {folder_, std::uint64_t{1} << 20},
            checkpoint};
  }
  ScratchCheckpoint checkpoint() const {
    return {{.file = folder_ / "state", .interval = 1e-6, .resume = true}, {{"test", "1"}}};
  }

  static void expect_equal(ScratchCloud& a, ScratchCloud& b) {
    ASSERT_EQ(a.size(), b.size());
    const PointCloud some = a.rows(0, a.size()), others = b.rows(0, b.size());
    EXPECT_TRUE(some.positions == others.positions);
    EXPECT_TRUE(some.intensities == others.intensities);
    EXPECT_TRUE(some.colors == others.colors);
    EXPECT_EQ(a.facts().warnings, b.facts().warnings);
  }

  std::filesystem::path folder_ = test::test_folder();
};

TEST_F(ScratchCloudTest, kept_rows_are_not_read_from_the_file_again) {
  const PointCloud cloud = colored_cloud();
  for (const char* const name : {"a.las", "a.laz"}) {
    const std::filesystem::path file = folder_ / name;
    write_las(file, cloud);
    ScratchCloud whole = read(file, nullptr);
    EXPECT_EQ(whole.columns().colors[7].x, 257 * cloud.colors[7].x);
    {
      ScratchCheckpoint state = checkpoint();
      read(file, &state);
      EXPECT_EQ(state.rows(), k_points);
    }
    std::vector<std::byte> bytes = test::read_bytes(file);
    std::fill(bytes.begin() + 2000, bytes.begin() + 200'000, std::byte{255});
    test::write_bytes(file, bytes);
    ScratchCheckpoint state = checkpoint();
    EXPECT_EQ(state.rows(), k_points);
    ScratchCloud resumed = read(file, &state);
    expect_equal(resumed, whole);
    state.remove();
  }
}

TEST_F(ScratchCloudTest, goes_on_behind_the_rows_of_a_run_that_was_stopped) {
  const std::filesystem::path file = folder_ / "a.las";
  write_las(file, colored_cloud());
  ScratchCloud whole = read(file, nullptr);
  {
    ScratchCheckpoint state = checkpoint();
    const auto half = [](std::uint64_t done, std::uint64_t total) { return done < total / 2; };
    EXPECT_THROW(read(file, &state, half), Cancelled);
    EXPECT_GT(state.rows(), 0u);
    EXPECT_LT(state.rows(), k_points);
    EXPECT_NE(test::error_of([&] { checkpoint(); }).find("another run is using this checkpoint"),
              std::string::npos);
  }
  ScratchCheckpoint state = checkpoint();
  ScratchCloud resumed = read(file, &state);
  EXPECT_EQ(state.rows(), k_points);
  expect_equal(resumed, whole);
}

TEST_F(ScratchCloudTest, bytes_that_do_not_fit_the_number_of_rows_are_an_error) {
  const std::filesystem::path file = folder_ / "a.las";
  write_las(file, colored_cloud());
  for (const std::uint64_t bytes : {11, 24}) {
    {
      ScratchCheckpoint state = checkpoint();
      KeptFile positions = state.file("positions");
      positions.append_zeros(bytes);
      state.keep(1, std::vector<ScratchCheckpoint::Kept>{{"positions", &positions, bytes}});
    }
    ScratchCheckpoint state = checkpoint();
    EXPECT_NE(test::error_of([&] {
                read(file, &state);
              }).find("wrong number of bytes of positions; expected those of 1 points"),
              std::string::npos);
    state.remove();
  }
}

TEST_F(ScratchCloudTest, more_kept_rows_than_the_input_has_are_an_error) {
  PointCloud cloud = colored_cloud();
  write_las(folder_ / "a.las", cloud);
  {
    ScratchCheckpoint state = checkpoint();
    read(folder_ / "a.las", &state);
  }
  cloud.resize(10);
  write_las(folder_ / "b.las", cloud);
  ScratchCheckpoint state = checkpoint();
  EXPECT_NE(test::error_of([&] { read(folder_ / "b.las", &state); }).find("more points than the input has"),
            std::string::npos);
  EXPECT_TRUE(state.is_corrupt());
}

TEST_F(ScratchCloudTest, chosen_rows_are_those_of_a_cloud_in_memory) {
  PointCloud cloud = colored_cloud();
  cloud.extra_dimensions.push_back({.name = "three", .type = ScalarType::bytes, .byte_count = 3});
  cloud.near_infrared.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.near_infrared[i] = cloud.colors[i].x;
    for (int byte = 0; byte < 3; ++byte)
      cloud.extra_dimensions[0].values.push_back(static_cast<std::uint8_t>(cloud.colors[i][byte]));
  }
  write_las(folder_ / "a.las", cloud);
  PointCloud whole = read_cloud(folder_ / "a.las");
  ScratchCloud parts = read(folder_ / "a.las", nullptr);
  const auto expect_same = [&] {
    ASSERT_EQ(parts.size(), whole.size());
    const PointCloud rows = parts.rows(0, parts.size());
    EXPECT_TRUE(rows.positions == whole.positions);
    EXPECT_TRUE(rows.intensities == whole.intensities);
    EXPECT_TRUE(rows.colors == whole.colors);
    EXPECT_TRUE(rows.near_infrared == whole.near_infrared);
    EXPECT_TRUE(rows.extra_dimensions.at(0).values == whole.extra_dimensions.at(0).values);
    EXPECT_EQ(rows.attributes().bits, whole.attributes().bits);
    EXPECT_EQ(parts.facts().files.front().point_count, whole.files.front().point_count);
  };
  keep_every(whole, 3);
  parts.keep_every(3, {});
  expect_same();
  const double edge = 1.0;  // cubes with several points
  thin(whole, edge);
  parts.thin(edge, {});
  EXPECT_LT(whole.size(), k_points / 6);
  expect_same();
  parts.add_normals();
  whole.normals.resize(whole.size());
  expect_same();
  parts.add_normals().back() = {0, 0, 1};
  EXPECT_EQ(parts.rows(parts.size() - 1, 1).normals.front().z, 1.0f);
  EXPECT_THROW(parts.keep_every(2, [](std::uint64_t, std::uint64_t) { return false; }), Cancelled);
  parts = read(folder_ / "a.las", nullptr);
  parts.add_normals();
  parts.keep_every(UINT64_MAX, {});
  EXPECT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts.columns().normals.size(), 1u);
}

}  // namespace
}  // namespace alidade
