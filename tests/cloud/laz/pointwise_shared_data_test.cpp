// SPDX-License-Identifier: MIT
// LAZ files of old point formats that other programs wrote. First and last points were decoded by another
// library.
#include <gtest/gtest.h>

#include <array>

#include "cloud/laz/pointwise_codec.h"
#include "cloud/laz/pointwise_rules.h"
#include "tests/cloud/laz/sample_chunks.h"

namespace alidade {
namespace {

using test::k_no_shared_data;
using test::sample_chunks;
using test::SampleChunks;
using test::shared_data;
using Bytes = std::vector<std::byte>;

Bytes decoded(const SampleChunks& sample) {
  PointwiseDecoder decoder(sample.layout);
  Bytes records;
  for (const SampleChunks::Chunk& chunk : sample.chunks) {
    Bytes some(chunk.point_count * sample.layout.record_size());
    decoder.start(chunk.bytes);
    decoder.decode(some);
    EXPECT_EQ(decoder.consumed(), chunk.bytes.size());
    records.insert(records.end(), some.begin(), some.end());
  }
  return records;
}

struct Expected {
  const char* name;
  std::size_t point_count;
  std::array<std::int32_t, 3> first, last;
};

class PointwiseSharedDataTest : public ::testing::TestWithParam<Expected> {};

std::array<std::int32_t, 3> position(const std::byte* record) {
  const Point10 point = load<Point10>(record);
  return {point.x, point.y, point.z};
}

TEST_P(PointwiseSharedDataTest, all_chunks_end_exactly_and_first_and_last_points_are_right) {
  const std::filesystem::path path = shared_data(GetParam().name);
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const SampleChunks sample = sample_chunks(path);
  const Bytes records = decoded(sample);
  const std::size_t size = sample.layout.record_size();
  ASSERT_EQ(records.size(), GetParam().point_count * size);
  EXPECT_EQ(position(records.data()), GetParam().first);
  EXPECT_EQ(position(records.data() + records.size() - size), GetParam().last);
}

TEST_P(PointwiseSharedDataTest, encoded_again_the_chunks_are_the_same_bytes) {
  const std::filesystem::path path = shared_data(GetParam().name);
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const SampleChunks sample = sample_chunks(path);
  const Bytes records = decoded(sample);
  PointwiseEncoder encoder(sample.layout);
  std::size_t at = 0;
  for (const SampleChunks::Chunk& chunk : sample.chunks) {
    const std::size_t size = chunk.point_count * sample.layout.record_size();
    const Bytes bytes = encoder.encode(std::span(records).subspan(at, size));
    ASSERT_TRUE(std::equal(bytes.begin(), bytes.end(), chunk.bytes.begin(), chunk.bytes.end()))
        << "chunk at byte " << chunk.bytes.data() - sample.file.data();
    at += size;
  }
}

INSTANTIATE_TEST_SUITE_P(
    , PointwiseSharedDataTest,
    ::testing::Values(Expected{"laz_vectors/micro0.laz", 3, {1000, 2000, 300}, {1021, 1980, 299}},
                      Expected{"lidar/lone-star.laz", 518862, {592, 1203, -618}, {-44190, 60571, 4109}},
                      Expected{"lidar_rgb/autzen_trim.laz",
                               110000,
                               {63717798, 84939395, 41119},
                               {63603788, 84933694, 42320}},
                      Expected{"malformed/laszip-generated_with2bytespadding.laz",
                               1065,
                               {63701224, 84902831, 43166},
                               {63734285, 85324032, 42392}},
                      Expected{"malformed/simple-laszip-compressor-version-1.2r0.laz",
                               1065,
                               {63701224, 84902831, 43166},
                               {63734285, 85324032, 42392}}));

TEST(PointwiseVersionsTest, streams_of_version_1_and_2_hold_the_same_records) {
  const std::filesystem::path old_path = shared_data("malformed/simple-laszip-compressor-version-1.2r0.laz");
  const std::filesystem::path new_path = shared_data("malformed/laszip-generated_with2bytespadding.laz");
  if (old_path.empty() || new_path.empty()) GTEST_SKIP() << k_no_shared_data;
  const SampleChunks old_sample = sample_chunks(old_path), new_sample = sample_chunks(new_path);
  ASSERT_EQ(old_sample.layout.items[0].version, 1);
  ASSERT_EQ(new_sample.layout.items[0].version, 2);
  EXPECT_EQ(decoded(old_sample), decoded(new_sample));
}

}  // namespace
}  // namespace alidade
