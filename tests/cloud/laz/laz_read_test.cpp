// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "cloud/las/las_header.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/laz/laz_builder.h"

// Clouds from LAZ against those from the LAS file with the same content.

namespace alidade {
namespace {

using test::build_las;
using test::build_laz;
using test::LazOptions;
using test::read_memory;
using test::sample_las;
using test::TableLocation;

void expect_equal(const PointCloud& found, const PointCloud& expected) {
  EXPECT_EQ(found.lattice, expected.lattice);
  EXPECT_EQ(found.positions, expected.positions);
  EXPECT_EQ(found.attributes().bits, expected.attributes().bits);
  EXPECT_EQ(found.colors, expected.colors);
  EXPECT_EQ(found.near_infrared, expected.near_infrared);
  EXPECT_EQ(found.intensities, expected.intensities);
  EXPECT_EQ(found.classifications, expected.classifications);
  EXPECT_TRUE(test::same_bits(found.returns, expected.returns));
  EXPECT_TRUE(test::same_bits(found.flags, expected.flags));
  EXPECT_EQ(found.scan_angles, expected.scan_angles);
  EXPECT_EQ(found.user_data, expected.user_data);
  EXPECT_EQ(found.point_source_ids, expected.point_source_ids);
  EXPECT_TRUE(test::same_bits(found.gps_times, expected.gps_times));
  ASSERT_EQ(found.extra_dimensions.size(), expected.extra_dimensions.size());
  for (std::size_t i = 0; i < found.extra_dimensions.size(); ++i)
    EXPECT_EQ(found.extra_dimensions[i].values, expected.extra_dimensions[i].values) << i;
  EXPECT_EQ(found.crs, expected.crs);
  EXPECT_EQ(found.records, expected.records);
}

class LazReadTest : public testing::TestWithParam<int> {
 protected:
  test::LasFile sample(std::size_t count = 100) const {
    return sample_las(test::oldest_las_version(GetParam()), GetParam(), count);
  }
};

class LazReadOldFormatsTest : public LazReadTest {};

TEST_P(LazReadTest, gives_the_cloud_of_the_las_file) {
  const PointCloud expected = read_memory(build_las(sample()));
  const PointCloud found = read_memory(build_laz(sample()));
  expect_equal(found, expected);
  EXPECT_EQ(found.files.at(0).format, "LAZ");
  EXPECT_EQ(found.files.at(0).point_format, GetParam());
  EXPECT_EQ(found.files.at(0).point_count, 100u);
}

TEST_P(LazReadTest, reads_chunks_of_any_sizes) {
  const PointCloud expected = read_memory(build_las(sample()));
  for (const std::vector<std::uint32_t>& sizes : {std::vector<std::uint32_t>{1}, {100}, {99}, {50}, {1000}}) {
    expect_equal(read_memory(build_laz(sample(), {.chunk_sizes = sizes})), expected);
  }
  expect_equal(read_memory(build_laz(sample(), {.chunk_sizes = {3, 1, 40, 9}, .variable = true})), expected);
}

TEST_P(LazReadTest, finds_the_table_behind_the_points) {
  expect_equal(read_memory(build_laz(sample(), {.table = TableLocation::at_end})),
               read_memory(build_las(sample())));
}

TEST_P(LazReadTest, without_a_table_reads_one_chunk_after_another_with_a_warning) {
  const PointCloud expected = read_memory(build_las(sample()));
  const PointCloud found = read_memory(build_laz(sample(), {.table = TableLocation::unknown}));
  expect_equal(found, expected);
  EXPECT_TRUE(test::warns(found, "reading the chunks one by one"));
}

TEST_P(LazReadTest, with_chunks_of_different_sizes_a_table_is_needed_by_pointwise_ones) {
  const std::vector<std::byte> bytes =
      build_laz(sample(), {.chunk_sizes = {3, 1, 40, 9}, .variable = true, .table = TableLocation::unknown});
  if (GetParam() >= 6) {
    expect_equal(read_memory(bytes), read_memory(build_las(sample())));
  } else {
    EXPECT_NE(test::error_of([&] { read_memory(bytes); }).find("expected a chunk table"), std::string::npos);
    const PointCloud none = read_memory(bytes, {.partial = true});
    EXPECT_EQ(none.size(), 0u);
    EXPECT_TRUE(test::warns(none, "100 points are lost"));
  }
}

TEST_P(LazReadOldFormatsTest, reads_one_stream_of_all_points) {
  expect_equal(read_memory(build_laz(sample(), {.one_stream = true})), read_memory(build_las(sample())));
}

TEST_P(LazReadTest, reads_files_without_points) {
  const PointCloud expected = read_memory(build_las(sample(0)));
  expect_equal(read_memory(build_laz(sample(0))), expected);
  expect_equal(read_memory(build_laz(sample(0), {.table = TableLocation::at_end})), expected);
  expect_equal(read_memory(build_laz(sample(0), {.table = TableLocation::unknown})), expected);
  if (GetParam() < 6) expect_equal(read_memory(build_laz(sample(0), {.one_stream = true})), expected);
}

TEST_P(LazReadTest, keeps_only_wanted_attributes) {
  const std::vector<std::byte> las = build_las(sample()), laz = build_laz(sample());
  for (const Attribute attribute :
       {Attribute::intensity, Attribute::classification, Attribute::returns, Attribute::flags,
        Attribute::scan_angle, Attribute::user_data, Attribute::point_source_id, Attribute::gps_time,
        Attribute::color, Attribute::near_infrared, Attribute::extra_dimensions}) {
    const ReadOptions options{.attributes = attribute};
    expect_equal(read_memory(laz, options), read_memory(las, options));
  }
  const ReadOptions none{.attributes = AttributeSet()};
  expect_equal(read_memory(laz, none), read_memory(las, none));
}

TEST_P(LazReadTest, gives_the_same_rows_on_any_number_of_threads) {
  const std::vector<std::byte> laz = build_laz(sample(500));
  const PointCloud expected = read_memory(build_las(sample(500)));
  for (const std::size_t threads : {1u, 2u, 5u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    expect_equal(read_memory(laz), expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, LazReadTest, testing::Range(0, k_las_point_formats));
INSTANTIATE_TEST_SUITE_P(Formats, LazReadOldFormatsTest, testing::Range(0, 6));

TEST(LazReadTest, joins_with_las) {
  test::LasFile las = sample_las(4, 7), laz = sample_las(4, 7, 30, 2);
  CloudInputs files;
  const std::vector<std::byte> las_bytes = build_las(las), laz_bytes = build_laz(laz);
  files.inputs.push_back(cloud_in_memory(las_bytes, "a.las"));
  files.inputs.push_back(cloud_in_memory(laz_bytes, "b.laz"));
  const PointCloud both = read_cloud(files);
  const PointCloud first = read_memory(las_bytes), second = read_memory(build_las(laz));
  ASSERT_EQ(both.size(), first.size() + second.size());
  for (std::size_t i = 0; i < second.size(); ++i) {
    EXPECT_EQ(both.positions[first.size() + i], second.positions[i]);
    EXPECT_EQ(both.intensities[first.size() + i], second.intensities[i]);
  }
}

TEST(LazReadTest, progress_is_in_bytes_of_the_file_and_can_stop) {
  const std::vector<std::byte> laz = build_laz(sample_las(4, 7, 2000));
  std::uint64_t last = 0;
  ReadOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_LE(last, done);
    EXPECT_LE(done, total);
    EXPECT_EQ(total, laz.size());
    last = done;
    return true;
  };
  read_memory(laz, options);
  EXPECT_EQ(last, laz.size());
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(read_memory(laz, options), Cancelled);
}

}  // namespace
}  // namespace alidade
