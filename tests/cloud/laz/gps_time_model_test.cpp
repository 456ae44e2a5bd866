// SPDX-License-Identifier: MIT
#include "cloud/laz/shared_models.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "tests/cloud/laz/laz_test_support.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

using test::Bytes;

Bytes encoded(GpsTimeModel& model, const std::vector<std::int64_t>& times) {
  ArithmeticEncoder stream;
  model.start(times[0]);
  for (std::size_t i = 1; i < times.size(); ++i) model.code(stream, times[i]);
  return stream.finish();
}

std::vector<std::int64_t> decoded(GpsTimeModel& model, const Bytes& bytes, std::int64_t first,
                                  std::size_t count) {
  ArithmeticDecoder stream(bytes);
  std::vector<std::int64_t> times{first};
  model.start(first);
  while (times.size() < count) times.push_back(model.code(stream, 0));
  EXPECT_FALSE(stream.failed());
  EXPECT_EQ(stream.consumed(), bytes.size());
  return times;
}

class GpsTimeModelTest : public ::testing::TestWithParam<GpsTimeModel::Unchanged> {
 protected:
  void expect_round_trip(const std::vector<std::int64_t>& times) {
    GpsTimeModel model(GetParam());
    const Bytes bytes = encoded(model, times);
    EXPECT_EQ(decoded(model, bytes, times[0], times.size()), times);
  }
};

TEST_P(GpsTimeModelTest, multiples_of_the_difference_of_all_sizes) {
  std::vector<std::int64_t> times{1'000'000'000'000};
  for (const std::int64_t difference : {7, -7, 1000, 3'000'000}) {
    for (std::int64_t multiple = -20; multiple <= 520; ++multiple) {
      times.push_back(times.back() + difference);
      times.push_back(times.back() + multiple * difference);
      times.push_back(times.back() + multiple * difference + difference / 3);
    }
    for (int extreme = 0; extreme < 6; ++extreme) times.push_back(times.back() + 900 * difference);
  }
  expect_round_trip(times);
}

TEST_P(GpsTimeModelTest, times_that_jump_between_sequences_and_forget_the_oldest) {
  std::vector<std::int64_t> times;
  test::Random random("jumps");
  std::vector<std::int64_t> sequences(6, 0);
  for (std::size_t i = 0; i < sequences.size(); ++i) sequences[i] = static_cast<std::int64_t>(i + 1) << 40;
  for (int i = 0; i < 20000; ++i) {
    std::int64_t& time = sequences[random.below(i < 10000 ? 4 : 6)];
    time += static_cast<std::int64_t>(random.below(3)) * 250;
    times.push_back(time);
  }
  expect_round_trip(times);
}

TEST_P(GpsTimeModelTest, bits_of_any_kind) {
  constexpr std::int64_t k_lowest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t k_highest = std::numeric_limits<std::int64_t>::max();
  std::vector<std::int64_t> times{0, k_lowest, k_highest, -1, 0, std::bit_cast<std::int64_t>(-0.0)};
  times.push_back(std::bit_cast<std::int64_t>(std::numeric_limits<double>::quiet_NaN()));
  times.push_back(std::bit_cast<std::int64_t>(std::numeric_limits<double>::signaling_NaN()));
  for (const std::int64_t step : {std::int64_t{INT32_MAX}, std::int64_t{INT32_MIN}, std::int64_t{INT32_MIN},
                                  std::int64_t{1}, std::int64_t{INT32_MIN}, std::int64_t{INT32_MAX}})
    times.push_back(times.back() + step);
  test::Random random("any kind");
  for (int i = 0; i < 5000; ++i)
    times.push_back(static_cast<std::int64_t>(random.bits() >> random.below(64)));
  expect_round_trip(times);
}

TEST_P(GpsTimeModelTest, more_than_three_changes_of_sequence_make_the_stream_fail) {
  const unsigned next_sequence = 2 + static_cast<unsigned>(GetParam());
  for (const int changes : {3, 4}) {
    ArithmeticEncoder stream;
    SymbolModel model(5 + static_cast<int>(GetParam()));
    for (int i = 0; i < changes; ++i) stream.symbol(model, next_sequence);
    // The difference 1.
    stream.symbol(model, static_cast<unsigned>(GetParam()));
    IntegerCompressor integers(32, 9);
    integers.encode(stream, 0, 1);
    const Bytes bytes = stream.finish();
    ArithmeticDecoder decoder(bytes);
    GpsTimeModel times(GetParam());
    times.start(5);
    const std::int64_t time = times.code(decoder, 0);
    EXPECT_EQ(decoder.failed(), changes > 3);
    if (changes == 3) {
      EXPECT_EQ(time, 1);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, GpsTimeModelTest,
                         ::testing::Values(GpsTimeModel::Unchanged::never_coded,
                                           GpsTimeModel::Unchanged::has_code),
                         [](const auto& codec) {
                           return codec.param == GpsTimeModel::Unchanged::has_code ? "pointwise" : "layered";
                         });

}  // namespace
}  // namespace alidade
