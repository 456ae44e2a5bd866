// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <string>

#include "octree/cloud/laz/layered_codec.h"
#include "tests/cloud/laz/layered_records.h"

namespace alidade {
namespace {

using test::Bytes;
using test::Random;
using test::random_records;
using test::RecordKind;

void expect_round_trip(const RecordKind& kind, std::span<const std::byte> records) {
  const LazLayout layout = kind.layout();
  const Bytes chunk = LayeredEncoder(layout).encode(records);
  Bytes again(records.size());
  LayeredDecoder(layout).decode(chunk, again);
  EXPECT_TRUE(std::equal(again.begin(), again.end(), records.begin(), records.end()))
      << "format " << kind.point_format << " extra " << kind.extra << " channels " << kind.channels
      << " wild " << kind.wild << " version " << kind.version << " bytes " << records.size();
}

class LayeredRoundTripTest : public ::testing::TestWithParam<int> {};

TEST_P(LayeredRoundTripTest, chunks_of_all_sizes_with_wild_and_modest_values) {
  Random random("round trip " + std::to_string(GetParam()));
  for (const std::size_t points : {1, 2, 3, 256, 513, 514, 1300})
    for (const std::size_t extra : {0, 1, 5})
      for (const unsigned channels : {1u, 2u, 4u})
        for (const bool wild : {false, true})
          for (const std::uint16_t version : {3, 4}) {
            const RecordKind kind{.point_format = GetParam(),
                                  .extra = extra,
                                  .channels = channels,
                                  .wild = wild,
                                  .version = version};
            expect_round_trip(kind, random_records(random, kind, points));
          }
}

TEST_P(LayeredRoundTripTest, one_attribute_that_changes_among_constant_ones) {
  Random random("one attribute " + std::to_string(GetParam()));
  const RecordKind kind{.point_format = GetParam(), .extra = 2};
  const std::size_t size = kind.layout().record_size();
  for (std::size_t byte = 0; byte < size; ++byte) {
    Bytes records;
    const Bytes first = random_records(random, kind, 1);
    for (int i = 0; i < 50; ++i) records.insert(records.end(), first.begin(), first.end());
    records[37 * size + byte] ^= std::byte{1};
    records[49 * size + byte] ^= std::byte{0x80};
    expect_round_trip(kind, records);
  }
}

TEST_P(LayeredRoundTripTest, records_of_noise) {
  Random random("noise " + std::to_string(GetParam()));
  const RecordKind kind{.point_format = GetParam(), .extra = 1};
  Bytes records(kind.layout().record_size() * 3000);
  for (std::byte& byte : records) byte = static_cast<std::byte>(random.bits());
  expect_round_trip(kind, records);
}

TEST_P(LayeredRoundTripTest, constant_records_of_a_scanner_channel_other_than_0) {
  for (const std::uint16_t version : {3, 4}) {
    const RecordKind kind{.point_format = GetParam(), .extra = 1, .version = version};
    const std::size_t size = kind.layout().record_size();
    Bytes records(size * 600);
    for (std::size_t i = 0; i < 600; ++i) {
      point14::put_channel(records.data() + i * size, 2);
      store(records.data() + (i + 1) * size - 1, static_cast<std::uint8_t>(i % 7));
    }
    expect_round_trip(kind, records);
  }
}

INSTANTIATE_TEST_SUITE_P(, LayeredRoundTripTest, ::testing::Values(6, 7, 8, 9, 10),
                         [](const auto& format) { return "format_" + std::to_string(format.param); });

}  // namespace
}  // namespace alidade
