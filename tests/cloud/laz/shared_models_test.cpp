// SPDX-License-Identifier: MIT
// What the pointwise and the layered codec share. Bytes of other writers are compared in the tests of the
// codecs.
#include "cloud/laz/shared_models.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <random>

#include "tests/cloud/laz/laz_test_support.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

using test::Bytes;
using test::to_hex;
using Color = std::array<std::byte, 6>;
using WavePacket = std::array<std::byte, WavePacketModels::k_size>;

Color color_of(unsigned red, unsigned green, unsigned blue) {
  Color color;
  const std::array<unsigned, 3> channels = {red, green, blue};
  for (std::size_t i = 0; i < 6; ++i) color[i] = static_cast<std::byte>(channels[i / 2] >> i % 2 * 8);
  return color;
}

void expect_colors_come_back(const std::vector<Color>& colors) {
  ColorModels models;
  for (const bool again : {false, true}) {
    if (again) models.reset();
    ArithmeticEncoder encoder;
    for (std::size_t i = 1; i < colors.size(); ++i) {
      Color last = colors[i - 1];
      models.code(encoder, last.data(), colors[i].data());
      ASSERT_EQ(last, colors[i]) << i;
    }
    const Bytes bytes = encoder.finish();
    models.reset();
    ArithmeticDecoder decoder(bytes);
    const Color unread{};
    Color color = colors[0];
    for (std::size_t i = 1; i < colors.size(); ++i) {
      models.code(decoder, color.data(), unread.data());
      ASSERT_EQ(color, colors[i]) << i;
    }
    EXPECT_FALSE(decoder.failed());
    EXPECT_EQ(decoder.consumed(), bytes.size());
  }
}

TEST(ColorModelsTest, wild_near_and_grey_colors_come_back) {
  std::mt19937 random(1);
  std::vector<Color> colors = {color_of(1, 2, 3)};
  unsigned shade = 30000;
  for (int i = 0; i < 6000; ++i) {
    const unsigned step = random() % 700 - 350;
    shade += step;
    switch (random() % 5) {
      case 0:
        colors.push_back(color_of(random(), random(), random()));
        break;
      case 1:
        colors.push_back(color_of(shade, shade, shade));
        break;
      case 2:
        colors.push_back(colors.back());
        break;
      default:
        colors.push_back(color_of(shade, shade + random() % 9, shade + step));
    }
  }
  expect_colors_come_back(colors);
}

TEST(ColorModelsTest, only_repeated_greys_can_be_left_out) {
  ColorModels models;
  ArithmeticEncoder encoder;
  const Color grey = color_of(7, 7, 7), other_grey = color_of(8, 8, 8), color = color_of(8, 8, 9);
  Color last = grey;
  EXPECT_FALSE(models.code(encoder, last.data(), grey.data()));
  EXPECT_TRUE(models.code(encoder, last.data(), other_grey.data()));
  EXPECT_TRUE(models.code(encoder, last.data(), color.data()));
  EXPECT_TRUE(models.code(encoder, last.data(), color.data()));
}

TEST(WavePacketModelsTest, offsets_that_stay_follow_move_and_jump_come_back) {
  std::mt19937_64 random(3);
  std::vector<WavePacket> packets(1);
  std::uint64_t offset = 60;
  std::uint32_t size = 0;
  for (int i = 0; i < 8000; ++i) {
    WavePacket packet = packets.back();
    const auto put = [&](std::size_t at, auto value) {
      std::memcpy(packet.data() + at, &value, sizeof(value));
    };
    switch (random() % 6) {
      case 0:
        break;
      case 1:
        offset = random();
        break;
      case 2:
        offset -= random() % 5000;
        break;
      default:
        offset += size;
    }
    // Sizes from 2^31 on are no differences.
    if (random() % 3 == 0) size = static_cast<std::uint32_t>(random() % 3 == 0 ? random() : 256);
    put(0, static_cast<std::uint8_t>(random() % 3));
    put(1, offset);
    put(9, size);
    if (random() % 2 == 0) put(13, static_cast<float>(i) / 7);
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (random() % 2 == 0) put(17 + 4 * axis, static_cast<std::uint32_t>(random()));
    packets.push_back(packet);
  }
  WavePacketModels models;
  for (int round = 0; round < 2; ++round) {
    models.reset();
    ArithmeticEncoder encoder;
    for (std::size_t i = 1; i < packets.size(); ++i) {
      WavePacket last = packets[i - 1];
      models.code(encoder, last.data(), packets[i].data());
      ASSERT_EQ(last, packets[i]) << i;
    }
    const Bytes bytes = encoder.finish();
    models.reset();
    ArithmeticDecoder decoder(bytes);
    const WavePacket unread{};
    WavePacket packet = packets[0];
    for (std::size_t i = 1; i < packets.size(); ++i) {
      models.code(decoder, packet.data(), unread.data());
      ASSERT_EQ(packet, packets[i]) << i;
    }
    EXPECT_FALSE(decoder.failed());
    EXPECT_EQ(decoder.consumed(), bytes.size());
  }
}

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

TEST(MedianPredictorTest, new_values_replace_the_largest_or_the_smallest_by_turns) {
  struct Step {
    std::int32_t inserted;
    std::array<std::int32_t, 5> values;
    bool replaces_largest;
  };
  MedianPredictor predictor;
  EXPECT_EQ(predictor.median(), 0);
  EXPECT_TRUE(predictor.replaces_largest());
  for (const Step& step :
       {Step{5, {0, 0, 0, 0, 5}, false}, Step{3, {0, 0, 0, 3, 5}, false}, Step{8, {0, 0, 3, 5, 8}, false},
        Step{-2, {-2, 0, 3, 5, 8}, true}, Step{7, {-2, 0, 3, 5, 7}, false}, Step{7, {0, 3, 5, 7, 7}, false},
        Step{1, {1, 3, 5, 7, 7}, true}}) {
    predictor.insert(step.inserted);
    EXPECT_EQ(predictor.values(), step.values);
    EXPECT_EQ(predictor.replaces_largest(), step.replaces_largest);
    EXPECT_EQ(predictor.median(), step.values[2]);
  }
}

TEST(MedianPredictorTest, values_beyond_all_five_are_inserted_too) {
  MedianPredictor predictor;
  predictor.insert(INT32_MAX);
  predictor.insert(INT32_MIN);
  EXPECT_EQ(predictor.values(), (std::array<std::int32_t, 5>{INT32_MIN, 0, 0, 0, INT32_MAX}));
  EXPECT_TRUE(predictor.replaces_largest());
}

}  // namespace
}  // namespace alidade
