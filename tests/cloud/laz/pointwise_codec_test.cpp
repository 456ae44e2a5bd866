// SPDX-License-Identifier: MIT
#include "cloud/laz/pointwise_codec.h"

#include <gtest/gtest.h>

#include <string>

#include "cloud/las/las_header.h"
#include "cloud/laz/laz_layout.h"
#include "tests/cloud/laz/laz_points.h"
#include "tests/cloud/laz/laz_test_support.h"

namespace alidade {
namespace {

using test::Bytes;
using test::from_hex;
using test::LazPoints;
using test::pointwise_records;
using test::Random;
using test::to_hex;

LazLayout layout_of(int format, std::size_t extra_bytes) {
  return standard_laz_layout(
      format,
      static_cast<std::size_t>(k_las_point_layouts[static_cast<std::size_t>(format)].size) + extra_bytes);
}

Bytes encoded(const LazLayout& layout, std::span<const std::byte> records) {
  return PointwiseEncoder(layout).encode(records);
}

const char* const k_known_records =
    "e8030000 d0070000 2c010000 3200 09 02 00 00 0700"
    "f2030000 c6070000 31010000 3c00 09 02 00 00 0700"
    "fd030000 bc070000 2b010000 3c00 12 05 fd 09 0700";

TEST(PointwiseEncoderTest, a_small_chunk_has_the_known_bytes) {
  const Bytes records = from_hex(k_known_records);
  const Bytes chunk = encoded(layout_of(0, 0), records);
  EXPECT_EQ(to_hex({chunk.begin(), chunk.begin() + 20}), to_hex({records.begin(), records.begin() + 20}));
  EXPECT_EQ(to_hex({chunk.begin() + 20, chunk.end()}),
            "41 a0 b8 69 ac c6 45 a5 0f 16 33 58 7f 8e e1 03 00 00 00");
}

TEST(PointwiseDecoderTest, a_small_chunk_gives_the_known_records) {
  const Bytes records = from_hex(k_known_records);
  Bytes chunk(records.begin(), records.begin() + 20);
  for (const std::byte byte : from_hex("41 a0 b8 69 ac c6 45 a5 0f 16 33 58 7f 8e e1 03 00 00 00"))
    chunk.push_back(byte);
  PointwiseDecoder decoder(layout_of(0, 0));
  Bytes found(records.size());
  decoder.start(chunk);
  decoder.decode(found);
  EXPECT_EQ(to_hex(found), to_hex(records));
  EXPECT_EQ(decoder.consumed(), chunk.size());
}

TEST(PointwiseEncoderTest, a_chunk_of_one_point_is_its_record_and_an_empty_stream) {
  const Bytes records = from_hex(k_known_records);
  const Bytes chunk = encoded(layout_of(0, 0), std::span(records).first(20));
  ASSERT_EQ(chunk.size(), 24u);
  EXPECT_EQ(to_hex({chunk.begin() + 20, chunk.end()}), "01 00 00 00");
}

struct Case {
  int format;
  std::size_t extra_bytes;
  int version;
};

class PointwiseCodecTest : public ::testing::TestWithParam<Case> {
 protected:
  // Wave packets have one version only.
  PointwiseCodecTest() : layout_(layout_of(GetParam().format, GetParam().extra_bytes)) {
    for (LazItem& item : layout_.items)
      if (item.kind != LazItemKind::wave_packet13)
        item.version = static_cast<std::uint16_t>(GetParam().version);
  }

  LazLayout layout_;
};

TEST_P(PointwiseCodecTest, records_come_back_from_chunks_of_all_sizes_with_coders_used_again) {
  PointwiseEncoder encoder(layout_);
  PointwiseDecoder decoder(layout_);
  Random random("round trip");
  for (const LazPoints points : {LazPoints::near, LazPoints::wild}) {
    for (const std::size_t count : {1, 2, 256, 3000}) {
      const Bytes records = pointwise_records(random, layout_, count, points);
      const Bytes chunk = encoder.encode(records);
      EXPECT_EQ(encoded(layout_, records), chunk) << "an encoder that was used before gives other bytes";
      Bytes found(records.size());
      decoder.start(chunk);
      decoder.decode(found);
      ASSERT_TRUE(found == records) << count << " points";
      EXPECT_EQ(decoder.consumed(), chunk.size());
      if (points == LazPoints::near && count > 256) {
        EXPECT_LT(chunk.size(), records.size());
      }
    }
  }
}

TEST_P(PointwiseCodecTest, records_can_be_asked_for_in_parts) {
  Random random("parts");
  const Bytes records = pointwise_records(random, layout_, 100, LazPoints::near);
  const Bytes chunk = encoded(layout_, records);
  const std::size_t size = layout_.record_size();
  PointwiseDecoder decoder(layout_);
  decoder.start(chunk);
  EXPECT_EQ(decoder.consumed(), 0u);
  Bytes found;
  for (const std::size_t count : {0, 1, 0, 2, 17, 80}) {
    Bytes part(count * size);
    decoder.decode(part);
    found.insert(found.end(), part.begin(), part.end());
  }
  EXPECT_TRUE(found == records);
  EXPECT_EQ(decoder.consumed(), chunk.size());
}

TEST_P(PointwiseCodecTest, bytes_behind_the_chunk_do_not_matter) {
  Random random("behind");
  const Bytes records = pointwise_records(random, layout_, 50, LazPoints::near);
  Bytes chunk = encoded(layout_, records);
  const std::size_t size = chunk.size();
  chunk.resize(size + 10, std::byte{0xaa});
  Bytes found(records.size());
  PointwiseDecoder decoder(layout_);
  decoder.start(chunk);
  decoder.decode(found);
  EXPECT_TRUE(found == records);
  EXPECT_EQ(decoder.consumed(), size);
}

/// Whether the chunk was rejected.
bool is_rejected(PointwiseDecoder& decoder, std::span<const std::byte> chunk, Bytes& records) {
  try {
    decoder.start(chunk);
    decoder.decode(records);
    return false;
  } catch (const CorruptChunk& corrupt) {
    EXPECT_NE(std::string(corrupt.what()).find("expected"), std::string::npos) << corrupt.what();
    return true;
  }
}

TEST_P(PointwiseCodecTest, chunks_cut_anywhere_are_rejected) {
  Random random("cut");
  const Bytes records = pointwise_records(random, layout_, 20, LazPoints::near);
  const Bytes chunk = encoded(layout_, records);
  Bytes found(records.size());
  PointwiseDecoder decoder(layout_);
  for (std::size_t size = 0; size < chunk.size(); ++size) {
    // A copy of its own, so that sanitizers see reading behind its end.
    const Bytes cut(chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_TRUE(is_rejected(decoder, cut, found)) << "cut to " << size << " of " << chunk.size() << " bytes";
  }
  EXPECT_FALSE(is_rejected(decoder, chunk, found));
  EXPECT_TRUE(found == records);
}

TEST_P(PointwiseCodecTest, damaged_bytes_anywhere_are_rejected_or_give_other_points) {
  Random random("damage");
  const Bytes records = pointwise_records(random, layout_, 20, LazPoints::near);
  const Bytes chunk = encoded(layout_, records);
  Bytes found(records.size());
  PointwiseDecoder decoder(layout_);
  for (std::size_t at = 0; at < chunk.size(); ++at) {
    for (const unsigned flipped : {0x01u, 0x80u, static_cast<unsigned>(random.below(255)) + 1}) {
      Bytes damaged = chunk;
      damaged[at] ^= static_cast<std::byte>(flipped);
      // The last bytes of a stream only mark its end.
      const bool harmless = !is_rejected(decoder, damaged, found) && found == records;
      EXPECT_TRUE(!harmless || at + 4 >= chunk.size()) << "byte " << at;
    }
  }
}

TEST_P(PointwiseCodecTest, any_bytes_are_rejected_or_decoded) {
  Random random("any");
  PointwiseDecoder decoder(layout_);
  int decoded = 0;
  for (int trial = 0; trial < 60; ++trial) {
    Bytes chunk(random.below(2000));
    const bool few_kinds = trial % 2 == 0;
    for (std::byte& byte : chunk)
      byte = static_cast<std::byte>(few_kinds ? random.below(2) * 0xff : random.bits());
    // Few records that the bytes hold, or more than these.
    Bytes found((trial % 3 == 0 ? 400 : 1 + trial % 20) * layout_.record_size()), again(found.size());
    PointwiseDecoder other(layout_);
    const bool rejected = is_rejected(decoder, chunk, found);
    // A decoder that has seen other chunks, and even given one up, is as a fresh one.
    EXPECT_EQ(is_rejected(other, chunk, again), rejected);
    if (rejected) continue;
    ++decoded;
    EXPECT_EQ(found, again);
    EXPECT_LE(decoder.consumed(), chunk.size());
  }
  EXPECT_GT(decoded, 0);
  EXPECT_LT(decoded, 60);
}

INSTANTIATE_TEST_SUITE_P(, PointwiseCodecTest,
                         ::testing::Values(Case{0, 0, 2}, Case{1, 3, 2}, Case{2, 0, 2}, Case{3, 1, 2},
                                           Case{4, 0, 2}, Case{5, 20, 2}, Case{0, 5, 1}, Case{1, 0, 1},
                                           Case{3, 2, 1}, Case{5, 1, 1}),
                         [](const auto& test) {
                           return "format_" + std::to_string(test.param.format) + "_version_" +
                                  std::to_string(test.param.version);
                         });

TEST(PointwiseDecoderTest, rejections_name_the_point_and_what_was_expected) {
  const LazLayout layout = layout_of(0, 0);
  Random random;
  const Bytes records = pointwise_records(random, layout, 100, LazPoints::wild);
  Bytes chunk = encoded(layout, records);
  chunk.resize(chunk.size() / 2);
  PointwiseDecoder decoder(layout);
  Bytes found(records.size());
  decoder.start(chunk);
  try {
    decoder.decode(found);
    FAIL() << "half a chunk was decoded";
  } catch (const CorruptChunk& corrupt) {
    ASSERT_TRUE(corrupt.point.has_value());
    EXPECT_GT(*corrupt.point, 30u);
    EXPECT_LT(*corrupt.point, 70u);
    EXPECT_EQ(std::string(corrupt.what()), "the points do not end with the chunk; expected all within " +
                                               std::to_string(chunk.size()) + " bytes, found more");
  }
}

TEST(PointwiseDecoderTest, items_that_pointwise_streams_do_not_have_are_rejected) {
  for (const LazItem& item :
       {LazItem{LazItemKind::point14, 30, 3}, LazItem{LazItemKind::point10, 20, 3},
        LazItem{LazItemKind::point10, 20, 0}, LazItem{LazItemKind::point10, 21, 2},
        LazItem{LazItemKind::gps_time11, 6, 2}, LazItem{LazItemKind::rgb12, 8, 2},
        LazItem{LazItemKind::wave_packet13, 29, 2}, LazItem{LazItemKind::wave_packet13, 28, 1},
        LazItem{LazItemKind::byte, 0, 2}, LazItem{static_cast<LazItemKind>(3), 8, 2}}) {
    LazLayout layout;
    layout.items = {item};
    EXPECT_THROW(PointwiseDecoder{layout}, CorruptChunk);
    EXPECT_THROW(PointwiseEncoder{layout}, CorruptChunk);
  }
}

}  // namespace
}  // namespace alidade
