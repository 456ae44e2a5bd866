// SPDX-License-Identifier: MIT
// Layered chunks that no encoder writes are rejected, and no bytes do harm.
#include <gtest/gtest.h>

#include <string>

#include "cloud/laz/layered_codec.h"
#include "cloud/laz/laz_layout.h"
#include "tests/cloud/laz/layered_records.h"

namespace alidade {
namespace {

using test::Bytes;
using test::Random;
using test::random_records;
using test::RecordKind;

class LayeredMalformed : public ::testing::Test {
 protected:
  static constexpr std::size_t k_points = 12;
  enum Layer : std::size_t {
    k_positions,
    k_z,
    k_classification,
    k_flags,
    k_intensity,
    k_scan_angle,
    k_user_data,
    k_point_source,
    k_gps_time
  };

  std::size_t head_at(std::size_t layer) const { return layout_.record_size() + 4 + 4 * layer; }
  std::uint32_t layer_size(std::size_t layer) const {
    return load<std::uint32_t>(chunk_.data() + head_at(layer));
  }

  /// The chunk without the bytes of a layer.
  Bytes without(std::size_t layer) const {
    Bytes chunk = chunk_;
    LayeredChunkHead head(layout_);
    head.read(chunk);
    std::size_t at = head.size();
    for (std::size_t i = 0; i < layer; ++i) at += head.layer_sizes()[i];
    const auto begin = chunk.begin() + static_cast<std::ptrdiff_t>(at);
    chunk.erase(begin, begin + static_cast<std::ptrdiff_t>(head.layer_sizes()[layer]));
    store(chunk.data() + head_at(layer), std::uint32_t{0});
    return chunk;
  }

  /// Empty if the chunk is decoded.
  std::string problem(const Bytes& chunk, std::size_t points = k_points, const LazLayers& wanted = {}) const {
    Bytes records(points * layout_.record_size());
    try {
      LayeredDecoder(layout_, wanted).decode(chunk, records);
    } catch (const CorruptChunk& corrupt) {
      return corrupt.what();
    }
    return "";
  }

  const RecordKind kind_{.point_format = 10, .extra = 2, .channels = 2, .wild = true};
  const LazLayout layout_ = kind_.layout();
  Random random_{"malformed"};
  const Bytes records_ = random_records(random_, kind_, k_points);
  const Bytes chunk_ = LayeredEncoder(layout_).encode(records_);
};

TEST_F(LayeredMalformed, nothing_is_wrong_with_the_chunk_itself) {
  EXPECT_EQ(problem(chunk_), "");
}

TEST_F(LayeredMalformed, another_number_of_points) {
  EXPECT_EQ(problem(chunk_, 11), "wrong number of points in the chunk; expected 11, found 12");
  Bytes none = chunk_;
  store(none.data() + layout_.record_size(), std::uint32_t{0});
  EXPECT_EQ(problem(none), "the chunk has no points");
  Bytes many = chunk_;
  store(many.data() + layout_.record_size(), UINT32_MAX);
  EXPECT_EQ(problem(many), "wrong number of points in the chunk; expected 12, found 4294967295");
}

TEST_F(LayeredMalformed, layers_that_do_not_fill_the_chunk) {
  Bytes longer = chunk_;
  longer.push_back({});
  EXPECT_EQ(problem(longer), "the layers do not fill the chunk; expected " + std::to_string(longer.size()) +
                                 " bytes, found " + std::to_string(chunk_.size()));
  // The sum of all sizes would be that of the chunk again in 32 bits.
  Bytes wrapped = chunk_;
  store(wrapped.data() + head_at(k_z), layer_size(k_z) + 0x80000000u);
  store(wrapped.data() + head_at(k_flags), layer_size(k_flags) + 0x80000000u);
  EXPECT_EQ(problem(wrapped), "the layers do not fill the chunk; expected " + std::to_string(chunk_.size()) +
                                  " bytes, found " + std::to_string(chunk_.size() + 0x100000000u));
}

TEST_F(LayeredMalformed, layers_too_small_for_any_stream) {
  Bytes chunk = chunk_;
  store(chunk.data() + head_at(k_positions), std::uint32_t{0});
  EXPECT_EQ(problem(chunk), "layer 0 is too small; expected at least 4 bytes, found 0");
  chunk = chunk_;
  store(chunk.data() + head_at(k_intensity), std::uint32_t{3});
  EXPECT_EQ(problem(chunk), "layer 4 is too small; expected 0, or at least 4 bytes, found 3");
}

TEST_F(LayeredMalformed, one_point_may_lack_the_first_layer) {
  Bytes chunk(chunk_.begin(), chunk_.begin() + static_cast<std::ptrdiff_t>(layout_.record_size()));
  chunk.resize(head_at(0));
  store(chunk.data() + layout_.record_size(), std::uint32_t{1});
  const std::size_t layers = 9 + 2 + 1 + 2;
  chunk.resize(chunk.size() + 4 * layers);
  EXPECT_EQ(problem(chunk, 1), "");
  // And what it has must be the stream of nothing.
  store(chunk.data() + head_at(k_positions), std::uint32_t{5});
  for (const int byte : {1, 0, 0, 0, 0}) chunk.push_back(static_cast<std::byte>(byte));
  EXPECT_EQ(
      problem(chunk, 1),
      "extra bytes after the last point in the layer of returns and positions; expected 4 bytes, found 5");
}

TEST_F(LayeredMalformed, a_layer_with_bytes_behind_the_last_point) {
  for (const std::size_t layer : {k_positions, k_classification, k_gps_time}) {
    Bytes chunk = chunk_;
    LayeredChunkHead head(layout_);
    head.read(chunk);
    std::size_t end = head.size();
    for (std::size_t i = 0; i <= layer; ++i) end += head.layer_sizes()[i];
    chunk.insert(chunk.begin() + static_cast<std::ptrdiff_t>(end), std::byte{0});
    store(chunk.data() + head_at(layer), layer_size(layer) + 1);
    EXPECT_NE(problem(chunk).find("expected " + std::to_string(layer_size(layer)) + " bytes, found " +
                                  std::to_string(layer_size(layer) + 1)),
              std::string::npos)
        << problem(chunk);
  }
}

TEST_F(LayeredMalformed, a_layer_that_ends_early) {
  // One byte less for the classification, one more for what follows.
  Bytes chunk = chunk_;
  store(chunk.data() + head_at(k_classification), layer_size(k_classification) - 1);
  store(chunk.data() + head_at(k_flags), layer_size(k_flags) + 1);
  EXPECT_EQ(problem(chunk),
            "truncated layer of classification: it ends before the last point; expected all within " +
                std::to_string(layer_size(k_classification) - 1) + " bytes, found more");
}

TEST_F(LayeredMalformed, rejections_name_the_first_point_that_cannot_be_had) {
  // Long enough for several blocks; a layer is that of the first points only, and later one of noise.
  constexpr std::size_t k_many = 1500;
  const std::size_t size = layout_.record_size();
  Random random("first point");
  const Bytes records = random_records(random, kind_, k_many);
  for (const std::size_t layer : {k_positions, k_intensity, k_user_data}) {
    for (const std::size_t sound : {600u, 1020u, 1450u}) {
      const Bytes whole = LayeredEncoder(layout_).encode(records);
      const Bytes part = LayeredEncoder(layout_).encode(std::span(records).first(sound * size));
      LayeredChunkHead whole_head(layout_), part_head(layout_);
      whole_head.read(whole);
      part_head.read(part);
      std::size_t in_whole = whole_head.size(), in_part = part_head.size();
      for (std::size_t i = 0; i < layer; ++i) {
        in_whole += whole_head.layer_sizes()[i];
        in_part += part_head.layer_sizes()[i];
      }
      const auto at = [](const Bytes& bytes, std::size_t offset) {
        return bytes.begin() + static_cast<std::ptrdiff_t>(offset);
      };
      Bytes chunk(whole.begin(), at(whole, in_whole));
      chunk.insert(chunk.end(), at(part, in_part), at(part, in_part + part_head.layer_sizes()[layer]));
      chunk.insert(chunk.end(), at(whole, in_whole + whole_head.layer_sizes()[layer]), whole.end());
      store(chunk.data() + head_at(layer), part_head.layer_sizes()[layer]);
      Bytes found(records.size());
      try {
        LayeredDecoder(layout_).decode(chunk, found);
        ADD_FAILURE() << "decoded without all of layer " << layer;
      } catch (const CorruptChunk& corrupt) {
        EXPECT_NE(std::string(corrupt.what()).find("expected"), std::string::npos) << corrupt.what();
        ASSERT_TRUE(corrupt.point.has_value());
        // A coder looks some bytes ahead, which the last of the sound points leave behind them.
        EXPECT_GE(*corrupt.point, sound) << corrupt.what();
        EXPECT_LT(*corrupt.point, sound + 12) << corrupt.what();
      }
    }
  }
}

TEST_F(LayeredMalformed, items_that_layered_chunks_do_not_have) {
  const LazItem point{LazItemKind::point14, 30, 3};
  for (const std::vector<LazItem>& items :
       std::vector<std::vector<LazItem>>{{},
                                         {{LazItemKind::point10, 20, 2}},
                                         {{LazItemKind::point14, 30, 1}},
                                         {{LazItemKind::point14, 30, 5}},
                                         {{LazItemKind::point14, 31, 3}},
                                         {{LazItemKind::rgb14, 6, 3}},
                                         {{LazItemKind::rgb14, 6, 3}, point},
                                         {point, point},
                                         {point, {LazItemKind::rgb12, 6, 2}},
                                         {point, {LazItemKind::rgb14, 8, 3}},
                                         {point, {LazItemKind::rgb_nir14, 6, 3}},
                                         {point, {LazItemKind::wave_packet14, 28, 3}},
                                         {point, {LazItemKind::byte14, 0, 3}},
                                         {point, {static_cast<LazItemKind>(3), 8, 3}}}) {
    LazLayout layout;
    layout.compressor = LazCompressor::layered;
    layout.items = items;
    EXPECT_THROW(LayeredDecoder{layout}, CorruptChunk);
    EXPECT_THROW(LayeredEncoder{layout}, CorruptChunk);
    EXPECT_THROW(LayeredChunkHead{layout}, CorruptChunk);
  }
}

TEST_F(LayeredMalformed, attributes_that_change_without_a_layer) {
  const auto empty = [](const char* name) {
    return std::string("the ") + name +
           " changes, but its layer is empty; expected at least 4 bytes, found 0";
  };
  EXPECT_EQ(problem(without(k_scan_angle)), empty("scan angle"));
  EXPECT_EQ(problem(without(k_point_source)), empty("point source"));
  EXPECT_EQ(problem(without(k_gps_time)), empty("GPS time"));
  EXPECT_EQ(problem(without(k_gps_time), k_points, LazLayers::positions()), empty("GPS time"));
  // Other attributes are constant without a layer.
  EXPECT_EQ(problem(without(k_intensity)), "");
}

TEST_F(LayeredMalformed, truncated_anywhere) {
  for (std::size_t size = 0; size < chunk_.size(); ++size)
    ASSERT_NE(problem(Bytes(chunk_.begin(), chunk_.begin() + static_cast<std::ptrdiff_t>(size))), "") << size;
}

TEST_F(LayeredMalformed, every_byte_changed) {
  std::size_t rejected = 0, tried = 0;
  const std::size_t head_end = head_at(0) + 4 * (9 + 2 + 1 + 2);
  for (std::size_t at = layout_.record_size(); at < chunk_.size(); ++at)
    for (const unsigned flip : {1u, 0x10u, 0x80u, 0xffu}) {
      Bytes chunk = chunk_;
      chunk[at] ^= static_cast<std::byte>(flip);
      const bool found = !problem(chunk).empty();
      if (at < head_end) {
        ASSERT_TRUE(found) << at;
      }
      rejected += found;
      ++tried;
    }
  EXPECT_GT(rejected, tried / 2);
}

TEST_F(LayeredMalformed, noise_in_all_layers) {
  Bytes chunk = chunk_;
  const std::size_t head_end = head_at(0) + 4 * (9 + 2 + 1 + 2);
  std::size_t rejected = 0;
  for (int round = 0; round < 300; ++round) {
    for (std::size_t at = head_end; at < chunk.size(); ++at)
      chunk[at] = static_cast<std::byte>(random_.bits());
    rejected += !problem(chunk).empty();
  }
  EXPECT_EQ(rejected, 300u);
}

}  // namespace
}  // namespace alidade
