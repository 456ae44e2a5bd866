// SPDX-License-Identifier: MIT
// Chunks that other programs wrote, and what selective decoding promises.
#include "cloud/laz/layered_codec.h"

#include <gtest/gtest.h>

#include <string>

#include "cloud/laz/laz_layout.h"
#include "tests/cloud/laz/layered_records.h"
#include "tests/cloud/laz/sample_chunks.h"
#include "tests/support/memory_taken.h"

namespace alidade {
namespace {

using test::Bytes;
using test::from_hex;
using test::k_no_shared_data;
using test::Random;
using test::RecordKind;
using test::shared_data;
using test::to_hex;

Bytes decoded(LayeredDecoder& decoder, const LazLayout& layout, std::span<const std::byte> chunk,
              std::size_t points) {
  Bytes records(points * layout.record_size());
  decoder.decode(chunk, records);
  return records;
}

Bytes decoded(const LazLayout& layout, std::span<const std::byte> chunk, std::size_t points,
              const LazLayers& wanted = {}) {
  LayeredDecoder decoder(layout, wanted);
  return decoded(decoder, layout, chunk, points);
}

// Three points of format 7 that independent decoders and encoders of LAZ agreed on.
const Bytes k_records = from_hex(
    "e8030000 d0070000 2c010000 3200 11 00 02 00 9cff 0700 0000000000002440 0001 0002 0003"
    "f2030000 c6070000 31010000 3c00 21 40 02 00 9cff 0700 0000000000002540 0401 0002 bc02"
    "f2030000 c7070000 22010000 1400 22 40 05 00 9cff 0700 0000000000002540 0401 0002 bc02");
const Bytes k_chunk = from_hex(
    "e8030000 d0070000 2c010000 3200 11 00 02 00 9cff 0700 0000000000002440 0001 0002 0003"
    "03000000 0a000000 06000000 06000000 05000000 06000000 00000000 00000000 00000000 0a000000 08000000"
    "2844494f27b7e2000000 1b4522000000 0204ff000000 4100000000 44fac1000000 4d920c34790000800000"
    "e20902a181000000");

TEST(LayeredCodec, known_chunk_of_three_points) {
  const LazLayout layout = RecordKind{.point_format = 7}.layout();
  EXPECT_EQ(to_hex(decoded(layout, k_chunk, 3)), to_hex(k_records));
  EXPECT_EQ(to_hex(LayeredEncoder(layout).encode(k_records)), to_hex(k_chunk));
}

TEST(LayeredCodec, known_chunk_of_one_point) {
  const LazLayout layout = RecordKind{.point_format = 7}.layout();
  const Bytes record(k_records.begin(), k_records.begin() + 36);
  Bytes chunk = record;
  const Bytes rest = from_hex(
      "01000000 04000000 04000000 00000000 00000000 00000000 00000000 00000000 00000000 00000000 00000000"
      "01000000 01000000");
  chunk.insert(chunk.end(), rest.begin(), rest.end());
  EXPECT_EQ(to_hex(LayeredEncoder(layout).encode(record)), to_hex(chunk));
  EXPECT_EQ(to_hex(decoded(layout, chunk, 1)), to_hex(record));
}

TEST(LayeredCodec, version_2_is_decoded_as_version_3) {
  EXPECT_EQ(to_hex(decoded(RecordKind{.point_format = 7, .version = 2}.layout(), k_chunk, 3)),
            to_hex(k_records));
}

TEST(LayeredChunkHead, says_points_layers_and_bytes) {
  LayeredChunkHead head(RecordKind{.point_format = 7}.layout());
  EXPECT_EQ(head.size(), 36u + 4 + 10 * 4);
  head.read(std::span(k_chunk).first(head.size()));
  EXPECT_EQ(head.point_count(), 3u);
  EXPECT_EQ(std::vector(head.layer_sizes().begin(), head.layer_sizes().end()),
            (std::vector<std::uint32_t>{10, 6, 6, 5, 6, 0, 0, 0, 10, 8}));
  EXPECT_EQ(head.chunk_size(), k_chunk.size());
  EXPECT_EQ(LayeredChunkHead(RecordKind{.point_format = 10, .extra = 3}.layout()).layer_sizes().size(),
            9u + 2 + 1 + 3);
}

class LayeredSampleTest : public ::testing::TestWithParam<const char*> {};

TEST_P(LayeredSampleTest, decoded_and_encoded_again_its_chunks_are_the_same_bytes) {
  const std::filesystem::path path = shared_data(GetParam());
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const test::SampleChunks sample = test::sample_chunks(path);
  ASSERT_FALSE(sample.chunks.empty());
  LayeredDecoder decoder(sample.layout);
  LayeredEncoder encoder(sample.layout);
  for (const auto& chunk : sample.chunks) {
    const Bytes records = decoded(decoder, sample.layout, chunk.bytes, chunk.point_count);
    const Bytes again = encoder.encode(records);
    EXPECT_TRUE(std::equal(again.begin(), again.end(), chunk.bytes.begin(), chunk.bytes.end()));
  }
}

INSTANTIATE_TEST_SUITE_P(, LayeredSampleTest,
                         ::testing::Values("laz_vectors/micro1.laz", "laz_vectors/micro7.laz",
                                           "laz_vectors/microz.laz",
                                           "lidar_rgb/Semis_2022_0906_6665_LA93_IGN69_ok.laz",
                                           "lidar_rgb/sample_lareunion_epsg2975.laz",
                                           "lidar_rgb/lion_takanawa.copc.laz"),
                         [](const auto& sample) {
                           std::string name = std::filesystem::path(sample.param).stem();
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

// ---- selective decoding

struct LayerField {
  bool LazLayers::*layer;
  std::size_t at, size;
};

constexpr std::size_t k_extra = 2;
// Of format 10. The byte of flags is shared with the scanner channel.
constexpr std::array<LayerField, 12> k_fields = {{{&LazLayers::z, point14::k_z, 4},
                                                  {&LazLayers::classification, point14::k_classification, 1},
                                                  {&LazLayers::flags, point14::k_flags, 1},
                                                  {&LazLayers::intensity, point14::k_intensity, 2},
                                                  {&LazLayers::scan_angle, point14::k_scan_angle, 2},
                                                  {&LazLayers::user_data, point14::k_user_data, 1},
                                                  {&LazLayers::point_source, point14::k_point_source, 2},
                                                  {&LazLayers::gps_time, point14::k_gps_time, 8},
                                                  {&LazLayers::color, 30, 6},
                                                  {&LazLayers::near_infrared, 36, 2},
                                                  {&LazLayers::wave_packet, 38, 29},
                                                  {&LazLayers::extra_bytes, 67, k_extra}}};

TEST(LayeredDecoder, attributes_not_wanted_are_those_of_the_first_record_for_every_subset) {
  Random random;
  const RecordKind kind{.point_format = 10, .extra = k_extra, .channels = 2, .wild = true};
  const LazLayout layout = kind.layout();
  const std::size_t size = layout.record_size(), points = 20;
  const Bytes records = random_records(random, kind, points);
  const Bytes chunk = LayeredEncoder(layout).encode(records);
  for (unsigned subset = 0; subset < 1u << k_fields.size(); ++subset) {
    LazLayers wanted;
    Bytes expected = records;
    for (std::size_t field = 0; field < k_fields.size(); ++field) {
      wanted.*k_fields[field].layer = (subset >> field & 1) != 0;
      if ((subset >> field & 1) != 0) continue;
      for (std::size_t i = 1; i < points; ++i) {
        std::byte* const record = expected.data() + i * size;
        const unsigned channel = point14::channel(record);
        std::copy_n(records.begin() + static_cast<std::ptrdiff_t>(k_fields[field].at), k_fields[field].size,
                    record + k_fields[field].at);
        point14::put_channel(record, channel);
      }
    }
    ASSERT_EQ(to_hex(decoded(layout, chunk, points, wanted)), to_hex(expected)) << "subset " << subset;
  }
}

TEST(LayeredDecoder, layers_that_are_not_wanted_are_not_looked_at) {
  Random random;
  const RecordKind kind{.point_format = 7};
  const LazLayout layout = kind.layout();
  const std::size_t points = 300;
  const Bytes records = random_records(random, kind, points);
  Bytes chunk = LayeredEncoder(layout).encode(records);
  LayeredChunkHead head(layout);
  head.read(chunk);
  for (std::size_t i = chunk.size() - head.layer_sizes().back(); i < chunk.size(); ++i)
    chunk[i] = std::byte{0xff};
  EXPECT_THROW(decoded(layout, chunk, points), CorruptChunk);
  LazLayers wanted;
  wanted.color = false;
  EXPECT_NO_THROW(decoded(layout, chunk, points, wanted));
}

TEST(LayeredDecoder, is_for_any_number_of_chunks_and_takes_memory_for_the_first_only) {
  Random random;
  const RecordKind kind{.point_format = 10, .extra = 3, .channels = 4, .wild = true};
  const LazLayout layout = kind.layout();
  LayeredEncoder encoder(layout);
  LayeredDecoder decoder(layout);
  std::vector<Bytes> chunks, expected;
  for (const std::size_t points : {2000, 3000, 1, 700, 2}) {
    expected.push_back(random_records(random, kind, points));
    chunks.push_back(encoder.encode(expected.back()));
  }
  EXPECT_EQ(chunks[3], LayeredEncoder(layout).encode(expected[3]));
  // Wild records use all models there are.
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      Bytes records(expected[i].size());
      const std::size_t before = test::memory_taken();
      decoder.decode(chunks[i], records);
      if (round > 0) {
        EXPECT_EQ(test::memory_taken(), before);
      }
      EXPECT_EQ(records, expected[i]);
    }
  }
}

TEST(LayeredDecoder, is_as_good_as_new_behind_a_corrupt_chunk) {
  const LazLayout layout = RecordKind{.point_format = 7}.layout();
  LayeredDecoder decoder(layout);
  Bytes corrupt = k_chunk;
  std::fill(corrupt.begin() + 80, corrupt.end(), std::byte{0x5a});
  EXPECT_THROW(decoded(decoder, layout, corrupt, 3), CorruptChunk);
  EXPECT_EQ(to_hex(decoded(decoder, layout, k_chunk, 3)), to_hex(k_records));
}

}  // namespace
}  // namespace alidade
