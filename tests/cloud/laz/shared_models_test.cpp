// SPDX-License-Identifier: MIT
// What the pointwise and the layered codec share: colours and wave packets. Bytes of other writers
// are compared in the tests of the codecs.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <random>

#include "cloud/laz/shared_models.h"
#include "tests/cloud/laz/laz_test_support.h"

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

}  // namespace
}  // namespace alidade
