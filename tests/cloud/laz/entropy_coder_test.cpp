// SPDX-License-Identifier: MIT
// Expected bytes are vectors that independent decoders of LAZ agreed on.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/shared_models.h"
#include "tests/cloud/laz/laz_test_support.h"

namespace alidade {
namespace {

using test::Bytes;
using test::from_hex;
using test::to_hex;

constexpr std::int32_t k_lowest = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t k_highest = std::numeric_limits<std::int32_t>::max();

TEST(SymbolModelTest, probabilities_follow_the_counts_from_time_to_time) {
  SymbolModel model(4);
  const auto cumulative = [&] {
    return std::vector<std::uint32_t>{model.cumulative(0), model.cumulative(1), model.cumulative(2),
                                      model.cumulative(3)};
  };
  EXPECT_EQ(cumulative(), (std::vector<std::uint32_t>{0, 8192, 16384, 24576}));
  EXPECT_EQ(model.left(), 5u);
  for (const unsigned symbol : {2u, 0u, 3u, 3u}) model.count(symbol);
  EXPECT_EQ(cumulative(), (std::vector<std::uint32_t>{0, 8192, 16384, 24576}));
  model.count(1);
  EXPECT_EQ(cumulative(), (std::vector<std::uint32_t>{0, 7281, 14563, 21845}));
  EXPECT_EQ(model.left(), 6u);
  model.reset();
  EXPECT_EQ(cumulative(), (std::vector<std::uint32_t>{0, 8192, 16384, 24576}));
  EXPECT_EQ(model.left(), 5u);
}

TEST(SymbolModelTest, find_is_the_largest_symbol_that_does_not_begin_above_the_value_whatever_the_guess) {
  std::mt19937 random(1);
  for (const int symbols : {2, 3, 5, 16, 17, 33, 64, 128, 256, 516, 2048}) {
    SymbolModel model(symbols);
    // Skewed, and long enough for counts to be halved.
    for (int round = 0; round < 40; ++round) {
      for (int i = 0; i < 2000; ++i)
        model.count(std::min(random(), random()) % static_cast<unsigned>(symbols) / (1 + i % 3));
      if (round % 10 != 9) continue;
      unsigned expected = 0;
      // The last symbol's part extends above 2^15.
      const std::uint32_t unit = 1 + random() % 100000;
      for (std::uint32_t quotient = 0; quotient < (1 << 15) + 64; ++quotient) {
        while (expected < model.last_symbol() && model.cumulative(expected + 1) <= quotient) ++expected;
        const std::uint32_t value = quotient * unit + random() % unit;
        for (const std::uint32_t guess : {quotient, quotient - quotient / 64, quotient / 2}) {
          const auto found = model.find(std::min(guess, (1u << 15) - 1), unit, value);
          ASSERT_EQ(found.symbol, expected) << symbols << " symbols, quotient " << quotient;
          ASSERT_EQ(found.begin, model.cumulative(expected) * unit);
          ASSERT_GT(found.end, value);
        }
      }
    }
  }
}

TEST(SymbolModelSetTest, models_are_kept_apart_and_all_fresh_behind_a_reset) {
  SymbolModelSet models(256, 4);
  for (int i = 0; i < 5; ++i) models[7].count(3);
  EXPECT_LT(models[7].cumulative(3), 24576u);
  EXPECT_EQ(models[8].cumulative(3), 24576u);
  const SymbolModel* const before = &models[7];
  models.reset();
  EXPECT_EQ(models[7].cumulative(3), 24576u);
  EXPECT_EQ(models[7].left(), 5u);
  EXPECT_EQ(&models[7], before);
}

TEST(ArithmeticCoderTest, symbols_have_the_known_bytes) {
  const std::vector<unsigned> symbols = {2, 0, 3, 3, 1, 3, 3, 3};
  SymbolModel model(4);
  ArithmeticEncoder encoder;
  for (const unsigned symbol : symbols) encoder.symbol(model, symbol);
  const Bytes bytes = encoder.finish();
  EXPECT_EQ(to_hex(bytes), "8f 7e 00 00 00");
  model.reset();
  ArithmeticDecoder decoder(bytes);
  for (const unsigned symbol : symbols) EXPECT_EQ(decoder.symbol(model), symbol);
  EXPECT_FALSE(decoder.failed());
  EXPECT_EQ(decoder.consumed(), bytes.size());
}

TEST(ArithmeticCoderTest, bits_have_the_known_bytes) {
  const std::vector<unsigned> bits = {1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 1, 1};
  BitModel model;
  ArithmeticEncoder encoder;
  for (const unsigned bit : bits) encoder.bit(model, bit);
  const Bytes bytes = encoder.finish();
  EXPECT_EQ(to_hex(bytes), "da db 00 00 00");
  for (const bool decoded : {false, true}) {
    EXPECT_EQ(model.zeros, 3u);
    EXPECT_EQ(model.total, 11u);
    EXPECT_EQ(model.probability, 2234u);
    EXPECT_EQ(model.cycle, 6u);
    EXPECT_EQ(model.left, 3u);
    if (decoded) break;
    model.reset();
    ArithmeticDecoder decoder(bytes);
    for (const unsigned bit : bits) EXPECT_EQ(decoder.bit(model), bit);
    EXPECT_FALSE(decoder.failed());
    EXPECT_EQ(decoder.consumed(), bytes.size());
  }
}

TEST(ArithmeticCoderTest, raw_values_have_the_known_bytes) {
  ArithmeticEncoder encoder;
  encoder.raw(1, 1);
  encoder.raw(7, 0x55);
  encoder.raw(19, 0x70001);
  encoder.raw(20, 0xABCDE);
  encoder.raw(32, 0xDEADBEEF);
  const Bytes bytes = encoder.finish();
  EXPECT_EQ(to_hex(bytes), "d5 df f8 e1 9a 18 9e 80 cd 7b d3 00 00");
  ArithmeticDecoder decoder(bytes);
  EXPECT_EQ(decoder.raw(1), 1u);
  EXPECT_EQ(decoder.raw(7), 0x55u);
  EXPECT_EQ(decoder.raw(19), 0x70001u);
  EXPECT_EQ(decoder.raw(20), 0xABCDEu);
  EXPECT_EQ(decoder.raw(32), 0xDEADBEEFu);
  EXPECT_FALSE(decoder.failed());
  EXPECT_EQ(decoder.consumed(), bytes.size());
}

TEST(ArithmeticCoderTest, raw_values_of_every_width_come_back) {
  std::mt19937_64 random(2);
  ArithmeticEncoder encoder;
  std::vector<std::uint64_t> values;
  for (int round = 0; round < 100; ++round) {
    for (int width = 1; width <= 32; ++width) {
      values.push_back(random() >> (64 - width));
      encoder.raw(width, static_cast<std::uint32_t>(values.back()));
    }
    values.push_back(random());
    encoder.raw64(values.back());
  }
  const Bytes bytes = encoder.finish();
  ArithmeticDecoder decoder(bytes);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int width = static_cast<int>(i % 33) + 1;
    ASSERT_EQ(width <= 32 ? decoder.raw(width) : decoder.raw64(), values[i]) << i;
  }
  EXPECT_FALSE(decoder.failed());
  EXPECT_EQ(decoder.consumed(), bytes.size());
}

TEST(ArithmeticCoderTest, a_stream_of_nothing_has_four_bytes_and_the_encoder_is_new_behind_each) {
  ArithmeticEncoder encoder;
  EXPECT_EQ(to_hex(encoder.finish()), "01 00 00 00");
  encoder.raw(16, 12345);
  const Bytes first = encoder.finish();
  encoder.raw(16, 12345);
  EXPECT_EQ(encoder.finish(), first);
  const Bytes nothing = from_hex("01 00 00 00");
  const ArithmeticDecoder decoder(nothing);
  EXPECT_FALSE(decoder.failed());
  EXPECT_EQ(decoder.consumed(), 4u);
}

/// Bits of probability a half that keep one number, 2^31, within the interval, so that the encoder cannot
/// know whether the bytes are 7f ff ff ... or 80 00 00 ... before the last bit, which decides for the latter.
std::vector<std::uint32_t> bits_around_a_border(int count) {
  std::uint64_t length = UINT32_MAX;
  std::uint64_t border = std::uint64_t{1} << 31;  // above the begin of the interval
  std::vector<std::uint32_t> bits;
  for (int i = 0; i < count || border > length >> 1; ++i) {
    length >>= 1;
    bits.push_back(border < length ? 0 : 1);
    if (bits.back() != 0) border -= length;
    for (; length < ArithmeticDecoder::k_least_length; length <<= 8) border <<= 8;
  }
  bits.push_back(1);
  return bits;
}

TEST(ArithmeticCoderTest, a_carry_runs_back_through_any_number_of_bytes) {
  const std::vector<std::uint32_t> bits = bits_around_a_border(40000);
  ArithmeticEncoder encoder;
  for (const std::uint32_t bit : bits) encoder.raw(1, bit);
  const Bytes bytes = encoder.finish();
  ASSERT_GT(bytes.size(), 4900u);
  EXPECT_EQ(bytes[0], std::byte{0x80});
  EXPECT_EQ(std::count(bytes.begin() + 1, bytes.begin() + 4900, std::byte{0}), 4899);
  ArithmeticDecoder decoder(bytes);
  for (std::size_t i = 0; i < bits.size(); ++i) ASSERT_EQ(decoder.raw(1), bits[i]) << i;
  EXPECT_FALSE(decoder.failed());
  EXPECT_EQ(decoder.consumed(), bytes.size());
}

struct Coded {
  std::int32_t prediction, value;
  int k;
};

void expect_integers(int bits, const std::vector<Coded>& integers, const char* hex) {
  IntegerCompressor compressor(bits, 1);
  ArithmeticEncoder encoder;
  for (const Coded& coded : integers) {
    compressor.encode(encoder, coded.prediction, coded.value);
    EXPECT_EQ(compressor.last_k(), coded.k);
  }
  const Bytes bytes = encoder.finish();
  EXPECT_EQ(to_hex(bytes), hex);
  compressor.reset();
  ArithmeticDecoder decoder(bytes);
  for (const Coded& coded : integers) {
    EXPECT_EQ(compressor.decode(decoder, coded.prediction), coded.value);
    EXPECT_EQ(compressor.last_k(), coded.k);
  }
  EXPECT_FALSE(decoder.failed());
  EXPECT_EQ(decoder.consumed(), bytes.size());
}

TEST(IntegerCompressorTest, integers_of_32_bits_have_the_known_bytes) {
  expect_integers(32,
                  {{0, 0, 0},
                   {0, 1, 0},
                   {0, -1, 1},
                   {0, 2, 1},
                   {10, 5, 3},
                   {0, -300, 9},
                   {0, 70000, 17},
                   {0, k_lowest, 32},
                   {k_highest, k_lowest, 0}},
                  "00 0f 79 1a e1 76 34 d7 2d 4e 38 00 00");
}

TEST(IntegerCompressorTest, integers_of_16_bits_wrap_and_have_the_known_bytes) {
  expect_integers(16, {{0, 65535, 1}, {65535, 0, 0}, {100, 300, 8}, {0, 32768, 16}, {0, 32767, 15}},
                  "0f 63 eb 24 c3 ad 0c 00 00 00 00");
}

TEST(IntegerCompressorTest, every_length_of_difference_comes_back_in_every_context) {
  std::mt19937 random(4);
  for (const int bits : {8, 16, 32}) {
    IntegerCompressor compressor(bits, 3);
    const std::uint32_t mask = UINT32_MAX >> (32 - bits);
    std::vector<Coded> integers;
    ArithmeticEncoder encoder;
    for (int i = 0; i < 5000; ++i) {
      const std::int32_t prediction = static_cast<std::int32_t>(random() & mask);
      const std::uint32_t edge = std::uint32_t{1} << i % bits;
      const std::uint32_t difference = (random() % 2 == 0 ? edge : 0 - edge) + random() % 5 - 2;
      const std::int32_t value =
          static_cast<std::int32_t>((static_cast<std::uint32_t>(prediction) + difference) & mask);
      compressor.encode(encoder, prediction, value, i % 3);
      integers.push_back({prediction, value, compressor.last_k()});
    }
    const Bytes bytes = encoder.finish();
    compressor.reset();
    ArithmeticDecoder decoder(bytes);
    for (std::size_t i = 0; i < integers.size(); ++i) {
      ASSERT_EQ(compressor.decode(decoder, integers[i].prediction, static_cast<int>(i % 3)),
                integers[i].value);
      ASSERT_EQ(compressor.last_k(), integers[i].k);
    }
    EXPECT_FALSE(decoder.failed());
    EXPECT_EQ(decoder.consumed(), bytes.size());
  }
}

TEST(IntegerCompressorTest, reset_makes_all_models_fresh) {
  IntegerCompressor used(32, 2), fresh(32, 2);
  std::mt19937 random(5);
  ArithmeticEncoder encoder;
  for (int i = 0; i < 3000; ++i)
    used.encode(encoder, 0, static_cast<std::int32_t>(random() >> random() % 32), i % 2);
  encoder.finish();
  used.reset();
  ArithmeticEncoder by_used, by_fresh;
  for (int i = 0; i < 3000; ++i) {
    const std::int32_t value = static_cast<std::int32_t>(random() >> random() % 32);
    used.encode(by_used, 0, value, i % 2);
    fresh.encode(by_fresh, 0, value, i % 2);
  }
  EXPECT_EQ(by_used.finish(), by_fresh.finish());
}

/// Reads much of everything, whatever it is, and checks ranges.
void read_all(ArithmeticDecoder decoder) {
  BitModel bit;
  SymbolModel few(3), many(516);
  IntegerCompressor narrow(16, 2), wide(32, 2);
  for (int i = 0; i < 300; ++i) {
    ASSERT_LE(decoder.bit(bit), 1u);
    ASSERT_LT(decoder.symbol(few), 3u);
    ASSERT_LT(decoder.symbol(many), 516u);
    ASSERT_LT(decoder.raw(7), 128u);
    ASSERT_LT(decoder.raw(25), 1u << 25);
    ASSERT_LT(narrow.decode(decoder, -7, i % 2), 1 << 16);
    wide.decode(decoder, k_lowest, i % 2);
  }
  EXPECT_TRUE(decoder.failed());
}

TEST(ArithmeticDecoderTest, any_bytes_give_values_in_range_and_the_end_is_remembered) {
  std::mt19937 random(6);
  for (int trial = 0; trial < 300; ++trial) {
    Bytes bytes(random() % 50);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(trial % 3 == 0 ? 0xff : random());
    read_all(ArithmeticDecoder(bytes));
  }
}

TEST(ArithmeticDecoderTest, fewer_than_four_bytes_and_a_value_as_large_as_the_interval_have_failed) {
  EXPECT_TRUE(ArithmeticDecoder().failed());
  EXPECT_TRUE(ArithmeticDecoder(from_hex("01 00 00")).failed());
  const Bytes largest = from_hex("ff ff ff fe");
  EXPECT_FALSE(ArithmeticDecoder(largest).failed());
  const Bytes too_large = from_hex("ff ff ff ff");
  EXPECT_TRUE(ArithmeticDecoder(too_large).failed());
}

TEST(ArithmeticDecoderTest, a_raw_value_of_more_bits_than_requested_has_failed) {
  // The unit of 19 bits is (2^32 - 1) >> 19 = 8191; 2^32 - 2 is 2^19 + 64 units.
  const Bytes bytes = from_hex("ff ff ff fe 00 00 00 00");
  ArithmeticDecoder decoder(bytes);
  EXPECT_LT(decoder.raw(19), 1u << 19);
  EXPECT_TRUE(decoder.failed());
}

}  // namespace
}  // namespace alidade
