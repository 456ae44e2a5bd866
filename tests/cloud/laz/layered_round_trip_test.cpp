// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <string>

#include "cloud/laz/layered_codec.h"
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

TEST_P(LayeredRoundTripTest, layers_that_are_left_out_stand_for_the_value_of_the_first_point) {
  using namespace point14;
  Random random("left out " + std::to_string(GetParam()));
  const RecordKind kind{.point_format = GetParam(), .extra = 2, .channels = 3};
  const LazLayout layout = kind.layout();
  const std::size_t size = layout.record_size();
  Bytes records = random_records(random, kind, 700);
  // All but x, y, returns and the scanner channel are those of the first point.
  for (std::size_t at = size; at < records.size(); at += size) {
    std::byte* const record = records.data() + at;
    const unsigned number = channel(record);
    std::copy_n(records.data() + k_z, 6, record + k_z);  // and the intensity
    std::copy_n(records.data() + k_flags, size - k_flags, record + k_flags);
    put_channel(record, number);
  }
  const Bytes chunk = LayeredEncoder(layout).encode(records);
  LayeredChunkHead head(layout);
  head.read(chunk);
  // Other writers leave out neither z nor colours; readers take both.
  constexpr std::size_t k_z_layer = 1, k_color_layer = 9;
  EXPECT_GT(head.layer_sizes()[k_z_layer], 0u);
  std::size_t end = head.size() + head.layer_sizes()[0];
  for (std::size_t layer = 1; layer < head.layer_sizes().size(); ++layer) {
    const std::uint32_t bytes = head.layer_sizes()[layer];
    const bool has_color = GetParam() == 7 || GetParam() == 8 || GetParam() == 10;
    EXPECT_EQ(bytes > 0, layer == k_z_layer || (has_color && layer == k_color_layer)) << "layer " << layer;
    if (bytes == 0) continue;
    Bytes without = chunk;
    const auto begin = without.begin() + static_cast<std::ptrdiff_t>(end);
    without.erase(begin, begin + bytes);
    store(without.data() + size + 4 + 4 * layer, std::uint32_t{0});
    Bytes again(records.size());
    LayeredDecoder(layout).decode(without, again);
    EXPECT_TRUE(again == records) << "without layer " << layer;
    end += bytes;
  }
  expect_round_trip(kind, records);
}

INSTANTIATE_TEST_SUITE_P(, LayeredRoundTripTest, ::testing::Values(6, 7, 8, 9, 10),
                         [](const auto& format) { return "format_" + std::to_string(format.param); });

}  // namespace
}  // namespace alidade
