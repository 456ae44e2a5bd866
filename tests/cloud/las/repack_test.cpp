// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <optional>

#include "base/bytes.h"
#include "cloud/las/las_header.h"
#include "cloud/las/las_records.h"
#include "cloud/las/repack_las.h"
#include "cloud/las/write_las.h"
#include "cloud/laz/laz_points.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::error_of;
using test::k_no_shared_data;
using test::read_bytes;
using test::sample_las;
using test::shared_data;
using test::write_bytes;

namespace fs = std::filesystem;

/// Packs a file, unpacks it, and expects the same bytes; returns the packed file.
fs::path expect_same_after_a_round(const fs::path& las, const fs::path& folder) {
  const fs::path laz = folder / "packed.laz", again = folder / "again.las";
  const RepackedFile packed = repack_las(las, laz, {.overwrite = true});
  const RepackedFile unpacked = repack_las(laz, again, {.overwrite = true});
  EXPECT_EQ(packed.point_count, unpacked.point_count);
  EXPECT_TRUE(read_bytes(las) == read_bytes(again)) << las;
  return laz;
}

class RepackTest : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(, RepackTest, ::testing::Range(0, 11),
                         [](const auto& test) { return "format_" + std::to_string(test.param); });

TEST_P(RepackTest, las_packed_and_unpacked_again_is_the_same_byte_for_byte) {
  const fs::path folder = test::test_folder();
  const int format = GetParam();
  for (int version = test::oldest_las_version(format); version <= 4; ++version) {
    for (const std::size_t count : {0u, 1u, 700u, 50003u}) {
      if (count > 1000 && version < 4) continue;
      write_bytes(folder / "in.las", build_las(sample_las(version, format, count)));
      const fs::path laz = expect_same_after_a_round(folder / "in.las", folder);
      const std::vector<std::byte> packed = read_bytes(laz);
      EXPECT_EQ(load<std::uint8_t>(packed.data() + 25), version);
      EXPECT_EQ(load<std::uint8_t>(packed.data() + 104), format | 0x80);
    }
  }
}

TEST_P(RepackTest, packs_as_many_extra_bytes_as_laz_has_and_rejects_more) {
  const fs::path folder = test::test_folder();
  for (const int extra : {8192, 8193}) {
    test::LasFile file;
    file.version_minor = 4;
    file.point_format = GetParam();
    file.extra_bytes = extra;
    file.points = test::random_las_points(GetParam(), 5, extra, 3);
    write_bytes(folder / "in.las", build_las(file));
    if (extra == 8192) {
      expect_same_after_a_round(folder / "in.las", folder);
      continue;
    }
    const std::string error = error_of([&] { repack_las(folder / "in.las", folder / "more.laz"); });
    EXPECT_NE(error.find("in.las: too many extra bytes per point for LAZ; expected at most 8192, found 8193"),
              std::string::npos)
        << error;
    EXPECT_FALSE(fs::exists(folder / "more.laz"));
  }
}

TEST_P(RepackTest, the_packed_file_is_read_as_the_same_cloud) {
  const fs::path folder = test::test_folder();
  const int format = GetParam();
  write_bytes(folder / "in.las", build_las(sample_las(4, format, 3000)));
  repack_las(folder / "in.las", folder / "out.laz");
  const PointCloud plain = read_cloud(folder / "in.las"), packed = read_cloud(folder / "out.laz");
  EXPECT_EQ(packed.files[0].point_format, format);
  EXPECT_TRUE(test::same_bits(plain.positions, packed.positions));
  EXPECT_TRUE(test::same_bits(plain.gps_times, packed.gps_times));
  EXPECT_TRUE(test::same_bits(plain.colors, packed.colors));
  EXPECT_TRUE(test::same_bits(plain.scan_angles, packed.scan_angles));
  EXPECT_EQ(plain.crs, packed.crs);
  EXPECT_EQ(plain.records, packed.records);
}

TEST(RepackFileTest, bytes_before_and_behind_the_points_stay) {
  const fs::path folder = test::test_folder();
  test::LasFile file = sample_las(4, 6, 50);
  std::vector<std::byte> las = build_las(file);
  // Padding before the points, bytes between points and extended records, and bytes after these.
  const auto points_offset = load<std::uint32_t>(las.data() + 96);
  const auto extended = load<std::uint64_t>(las.data() + 235);
  las.insert(las.begin() + static_cast<std::ptrdiff_t>(extended), 11, std::byte{0x22});
  las.insert(las.begin() + points_offset, 7, std::byte{0x11});
  las.insert(las.end(), 5, std::byte{0x33});
  store(las.data() + 96, points_offset + 7);
  store(las.data() + 235, extended + 18);
  write_bytes(folder / "in.las", las);
  const fs::path laz = expect_same_after_a_round(folder / "in.las", folder);
  const PointCloud cloud = read_cloud(laz);
  EXPECT_EQ(cloud.records.size(), 2u) << "also the extended one, whose offset has changed";
}

TEST(RepackFileTest, the_offset_of_wave_packets_moves_with_them) {
  const fs::path folder = test::test_folder();
  std::vector<std::byte> las = build_las(sample_las(3, 4, 50));
  store<std::uint64_t>(las.data() + 227, las.size());
  las.insert(las.end(), 100, std::byte{0x44});
  write_bytes(folder / "in.las", las);
  const std::vector<std::byte> packed = read_bytes(expect_same_after_a_round(folder / "in.las", folder));
  EXPECT_EQ(load<std::uint64_t>(packed.data() + 227), packed.size() - 100);
}

TEST(RepackFileTest, laz_packed_again_comes_out_as_it_is_packed_here) {
  const fs::path folder = test::test_folder();
  write_bytes(folder / "in.las", build_las(sample_las(2, 3, 5000)));
  const fs::path laz = expect_same_after_a_round(folder / "in.las", folder);
  repack_las(laz, folder / "again.laz");
  EXPECT_EQ(read_bytes(laz), read_bytes(folder / "again.laz"));
  repack_las(folder / "in.las", folder / "copy.las");
  EXPECT_EQ(read_bytes(folder / "in.las"), read_bytes(folder / "copy.las"));
}

TEST(RepackFileTest, the_bytes_do_not_depend_on_the_number_of_threads) {
  const fs::path folder = test::test_folder();
  write_bytes(folder / "in.las", build_las(sample_las(2, 3, 120000)));
  repack_las(folder / "in.las", folder / "many.laz");
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  repack_las(folder / "in.las", folder / "one.laz");
  EXPECT_EQ(read_bytes(folder / "many.laz"), read_bytes(folder / "one.laz"));
}

TEST(RepackFileTest, progress_ends_with_all_bytes_and_can_stop_it_without_a_trace) {
  const fs::path folder = test::test_folder(), data = folder / "out";
  fs::create_directory(data);
  write_bytes(folder / "in.las", build_las(sample_las(2, 3, 5000)));
  std::uint64_t last = 0;
  RepackOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_EQ(total, fs::file_size(folder / "in.las"));
    last = done;
    return true;
  };
  repack_las(folder / "in.las", folder / "whole.laz", options);
  EXPECT_EQ(last, fs::file_size(folder / "in.las"));
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(repack_las(folder / "in.las", data / "out.laz", options), Cancelled);
  EXPECT_TRUE(fs::is_empty(data));
}

TEST(RepackFileTest, damaged_files_are_errors_and_leave_no_output) {
  const fs::path folder = test::test_folder(), data = folder / "out";
  fs::create_directory(data);
  write_bytes(folder / "in.las", build_las(sample_las(2, 3, 500)));
  repack_las(folder / "in.las", folder / "packed.laz");
  for (const char* const name : {"in.las", "packed.laz"}) {
    std::vector<std::byte> bytes = read_bytes(folder / name);
    bytes.resize(bytes.size() - 2000);
    write_bytes(folder / "short", bytes);
    EXPECT_NE(error_of([&] { repack_las(folder / "short", data / "out.las"); }).find("short"),
              std::string::npos);
    EXPECT_TRUE(fs::is_empty(data));
  }
  EXPECT_NE(error_of([&] {
              repack_las(folder / "in.las", folder / "packed.laz");
            }).find("the file exists; expected another name, or --overwrite"),
            std::string::npos);
}

/// Takes points without keeping them.
class LargestPiece final : public LazSink {
 public:
  void make_room(std::uint64_t count) override {
    most_ = std::max(most_, count);
    all_ += count;
  }
  void take(const std::byte*, std::size_t, std::uint64_t) override {}
  std::uint64_t most() const { return most_; }
  std::uint64_t all() const { return all_; }

 private:
  std::uint64_t most_ = 0, all_ = 0;
};

TEST(RepackFileTest, points_are_unpacked_in_pieces_of_64_mb_however_well_they_were_packed) {
  const fs::path laz = test::test_folder() / "equal.laz";
  constexpr std::uint64_t k_pieces = 40, k_points = 100000, k_record = 30, k_most_bytes = 64 << 20;
  static_assert(k_pieces * k_points * k_record > k_most_bytes);
  PointCloud piece;
  piece.resize(k_points);
  LasWriter writer(laz, {}, {});
  for (std::uint64_t i = 0; i < k_pieces; ++i) writer.write(piece);
  writer.finish();
  InputFile file(laz);
  std::vector<std::string> warnings;
  LasHeader header = read_las_header(file, warnings);
  const LasRecords records = read_las_records(file, header, warnings);
  const std::optional<LazLayout> layout = read_packing(file, header, records);
  ASSERT_TRUE(layout);
  LargestPiece sink;
  LazPoints(file, header, *layout, Damage::reject).read(LazLayers{}, sink, {});
  EXPECT_EQ(sink.all(), k_pieces * k_points);
  EXPECT_LE(sink.most() * k_record, k_most_bytes);
  EXPECT_GT(sink.most(), k_points);
}

TEST(CanRepackTest, las_and_laz_but_neither_copc_nor_anything_else) {
  const fs::path folder = test::test_folder();
  write_bytes(folder / "in.las", build_las(sample_las(2, 3, 10)));
  write_bytes(folder / "small.las", build_las(sample_las(0, 0, 0)));
  test::write_text(folder / "points.xyz", "1 2 3\n");
  test::write_text(folder / "short", "LAS");
  EXPECT_TRUE(can_repack(folder / "in.las"));
  EXPECT_TRUE(can_repack(folder / "small.las"));
  EXPECT_FALSE(can_repack(folder / "points.xyz"));
  EXPECT_FALSE(can_repack(folder / "short"));
  EXPECT_FALSE(can_repack(folder / "absent"));
  EXPECT_FALSE(can_repack(folder));
  const fs::path copc = shared_data("lidar_rgb/lion_takanawa.copc.laz");
  if (copc.empty()) GTEST_SKIP() << k_no_shared_data;
  EXPECT_FALSE(can_repack(copc));
  EXPECT_NE(error_of([&] { repack_las(copc, folder / "out.las"); }).find("COPC cannot be repacked"),
            std::string::npos);
}

TEST(RepackSharedDataTest, every_las_file_is_the_same_after_packing_and_unpacking) {
  if (shared_data("lidar").empty()) GTEST_SKIP() << test::absent("../shared/data/lidar", 12);
  const fs::path folder = test::test_folder();
  int count = 0;
  for (const char* const part : {"lidar", "lidar_rgb"}) {
    for (const auto& entry : fs::directory_iterator(shared_data(part))) {
      if (entry.path().extension() != ".las") continue;
      expect_same_after_a_round(entry.path(), folder);
      EXPECT_LT(fs::file_size(folder / "packed.laz"), fs::file_size(entry.path()));
      ++count;
    }
  }
  EXPECT_GE(count, 12);
}

TEST(RepackSharedDataTest, laz_files_of_other_writers_keep_their_records) {
  if (shared_data("lidar").empty()) GTEST_SKIP() << test::absent("../shared/data/lidar", 5);
  const fs::path folder = test::test_folder();
  for (const char* const name :
       {"lidar/lone-star.laz", "lidar_rgb/autzen_trim.laz", "lidar_rgb/sample_lareunion_epsg2975.laz",
        "lidar_rgb/Semis_2022_0906_6665_LA93_IGN69_ok.laz",
        "malformed/laszip-generated_with2bytespadding.laz"}) {
    const fs::path laz = shared_data(name);
    repack_las(laz, folder / "plain.las", {.overwrite = true});
    repack_las(folder / "plain.las", folder / "again.laz", {.overwrite = true});
    const PointCloud before = read_cloud(laz);
    for (const char* const copy : {"plain.las", "again.laz"}) {
      const PointCloud after = read_cloud(folder / copy);
      EXPECT_TRUE(test::same_bits(before.positions, after.positions)) << name;
      EXPECT_TRUE(test::same_bits(before.colors, after.colors)) << name;
      EXPECT_TRUE(test::same_bits(before.gps_times, after.gps_times)) << name;
      EXPECT_TRUE(test::same_bits(before.intensities, after.intensities)) << name;
      EXPECT_EQ(before.crs, after.crs) << name;
      EXPECT_EQ(before.records, after.records) << name;
    }
  }
}

}  // namespace
}  // namespace alidade
