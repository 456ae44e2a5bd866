// SPDX-License-Identifier: MIT
#include "cloud/laz/pointwise_codec.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "cloud/las/las_header.h"
#include "cloud/laz/laz_layout.h"
#include "tests/cloud/laz/laz_test_support.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

using test::Bytes;
using test::from_hex;
using test::Random;
using test::to_hex;

/// How points of a test follow each other.
enum class Sequence {
  wild,  ///< every byte is random
  near   ///< like scans: most attributes stay, coordinates move little, clocks tick, colours are alike
};

/// Puts a value into a record.
template <class T>
void put(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof(T));
}

/// Times of up to six clocks: steps of all multiples of a unit that GPS time codes know, jumps, and special
/// values.
class LazClocks {
 public:
  explicit LazClocks(Random& random) : random_(random) {
    for (std::uint64_t& time : times_) time = random_.bits();
  }

  std::uint64_t next() {
    constexpr std::array<double, 5> k_special = {0.0, -0.0, std::numeric_limits<double>::quiet_NaN(), -1e300,
                                                 1e-320};
    constexpr std::array<int, 14> k_factors = {0, 1, 1, 1, 1, 2, 9, 10, 499, 500, 800, -1, -9, -12};
    if (random_.below(300) == 0) return std::bit_cast<std::uint64_t>(k_special[random_.below(5)]);
    if (random_.below(40) == 0) clock_ = random_.below(times_.size());
    std::uint64_t& time = times_[clock_];
    if (random_.below(400) == 0) time = random_.bits();
    const std::uint64_t unit = 1000 + 100000 * clock_ + random_.below(3);
    time += unit * static_cast<std::uint64_t>(k_factors[random_.below(k_factors.size())]);
    if (random_.below(200) == 0) time += random_.below(2) == 0 ? 0x7fffffff : std::uint64_t{0} - 0x80000000;
    return time;
  }

 private:
  Random& random_;
  std::array<std::uint64_t, 6> times_{};
  std::size_t clock_ = 0;
};

/// Changes a record of formats 0 to 5 into one that could follow it in a scan.
void follow(Random& random, LazClocks& clocks, const LazLayout& layout, std::byte* record) {
  const auto now_and_then = [&](std::size_t at, std::uint64_t one_in) {
    if (random.below(one_in) == 0) record[at] = static_cast<std::byte>(random.bits());
  };
  for (const LazItem& item : layout.items) {
    switch (item.kind) {
      case LazItemKind::point10:
        for (std::size_t axis = 0; axis < 3; ++axis) {
          std::int32_t value;
          std::memcpy(&value, record + 4 * axis, 4);
          const std::uint64_t range = std::uint64_t{1} << random.below(12 + axis);
          put(record + 4 * axis, static_cast<std::int32_t>(static_cast<std::uint32_t>(value) +
                                                           static_cast<std::uint32_t>(random.below(range))));
        }
        for (std::size_t at = 12; at < 20; ++at) now_and_then(at, at < 15 ? 3 : 50);
        break;
      case LazItemKind::gps_time11:
        put(record, clocks.next());
        break;
      case LazItemKind::wave_packet13: {
        std::uint64_t offset;
        std::uint32_t size;
        std::memcpy(&offset, record + 1, 8);
        std::memcpy(&size, record + 9, 4);
        if (random.below(3) != 0) put(record + 1, random.below(9) == 0 ? random.bits() : offset + size);
        if (random.below(9) == 0) put(record + 1, offset - random.below(5000));
        for (std::size_t at = 9; at < item.size; ++at) now_and_then(at, 5);
        break;
      }
      case LazItemKind::rgb12: {
        const unsigned shift = static_cast<unsigned>(random.below(300));
        const bool grey = random.below(4) == 0;
        for (std::size_t at = 0; at < 6; at += 2) {
          std::uint16_t value;
          std::memcpy(&value, record + (grey ? 0 : at), 2);
          put(record + at, static_cast<std::uint16_t>(value + (grey && at > 0 ? 0 : shift)));
        }
        break;
      }
      default:
        for (std::size_t at = 0; at < item.size; ++at) now_and_then(at, 4);
    }
    record += item.size;
  }
}

/// Point data records of formats 0 to 5, one after the other.
std::vector<std::byte> pointwise_records(Random& random, const LazLayout& layout, std::size_t count,
                                         Sequence sequence) {
  const std::size_t size = layout.record_size();
  std::vector<std::byte> records(count * size);
  LazClocks clocks(random);
  for (std::size_t i = 0; i < count; ++i) {
    std::byte* const record = records.data() + i * size;
    if (i == 0 || sequence == Sequence::wild) {
      for (std::size_t at = 0; at < size; ++at) record[at] = static_cast<std::byte>(random.bits());
    } else {
      std::memcpy(record, record - size, size);
      follow(random, clocks, layout, record);
    }
  }
  return records;
}

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
  for (const Sequence points : {Sequence::near, Sequence::wild}) {
    for (const std::size_t count : {1, 2, 256, 3000}) {
      const Bytes records = pointwise_records(random, layout_, count, points);
      const Bytes chunk = encoder.encode(records);
      EXPECT_EQ(encoded(layout_, records), chunk) << "an encoder that was used before gives other bytes";
      Bytes found(records.size());
      decoder.start(chunk);
      decoder.decode(found);
      ASSERT_TRUE(found == records) << count << " points";
      EXPECT_EQ(decoder.consumed(), chunk.size());
      if (points == Sequence::near && count > 256) {
        EXPECT_LT(chunk.size(), records.size());
      }
    }
  }
}

TEST_P(PointwiseCodecTest, records_can_be_asked_for_in_parts) {
  Random random("parts");
  const Bytes records = pointwise_records(random, layout_, 100, Sequence::near);
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
  const Bytes records = pointwise_records(random, layout_, 50, Sequence::near);
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
  const Bytes records = pointwise_records(random, layout_, 20, Sequence::near);
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
  const Bytes records = pointwise_records(random, layout_, 20, Sequence::near);
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
  const Bytes records = pointwise_records(random, layout, 100, Sequence::wild);
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
