// SPDX-License-Identifier: MIT
// Files that others wrote against checksums of what another decoder made of them.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <bit>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/laz/laz_records.h"

namespace alidade {
namespace {

using test::k_no_shared_data;
using test::read_laz;
using test::ReadLaz;
using test::shared_data;

/// SHA-256 of some bytes as 64 digits: the checksum that lists of reference data give. Source: FIPS 180-4.
/// The constants there are the first 32 bits of the fractions of roots of primes: square roots for the state,
/// cube roots for the rounds; they are computed in whole numbers here.
std::string sha256(std::span<const std::byte> bytes) {
  // The first 32 bits behind the point of the power-th root of a prime.
  const auto root_bits = [](unsigned prime, int power) {
    using Wide = unsigned __int128;
    // The largest r with r^power <= prime * 2^(32 * power), whose lower 32 bits are wanted.
    std::uint64_t root = 0;
    for (int bit = 36; bit >= 0; --bit) {
      const std::uint64_t tried = root | std::uint64_t{1} << bit;
      const Wide square = Wide{tried} * tried;
      const bool fits = power == 2 ? square <= Wide{prime} << 64 : square <= (Wide{prime} << 96) / tried;
      if (fits) root = tried;
    }
    return static_cast<std::uint32_t>(root);
  };
  std::vector<unsigned> primes;
  for (unsigned number = 2; primes.size() < 64; ++number) {
    bool is_prime = true;
    for (const unsigned prime : primes) is_prime = is_prime && number % prime != 0;
    if (is_prime) primes.push_back(number);
  }
  std::array<std::uint32_t, 64> round_constants{};
  for (std::size_t i = 0; i < 64; ++i) round_constants[i] = root_bits(primes[i], 3);
  std::array<std::uint32_t, 8> state{};
  for (std::size_t i = 0; i < 8; ++i) state[i] = root_bits(primes[i], 2);

  const auto add_block = [&](const std::byte* block) {
    std::array<std::uint32_t, 64> words{};
    for (std::size_t i = 0; i < 64; ++i)
      words[i / 4] = words[i / 4] << 8 | std::to_integer<std::uint32_t>(block[i]);
    for (std::size_t i = 16; i < 64; ++i) {
      const std::uint32_t a = words[i - 15], b = words[i - 2];
      words[i] = words[i - 16] + words[i - 7] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ a >> 3) +
                 (std::rotr(b, 17) ^ std::rotr(b, 19) ^ b >> 10);
    }
    auto [a, b, c, d, e, f, g, h] = state;
    for (std::size_t i = 0; i < 64; ++i) {
      const std::uint32_t sum = h + (std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)) +
                                ((e & f) ^ (~e & g)) + round_constants[i] + words[i];
      const std::uint32_t other =
          (std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
      h = g, g = f, f = e, e = d + sum, d = c, c = b, b = a, a = sum + other;
    }
    const std::array<std::uint32_t, 8> added = {a, b, c, d, e, f, g, h};
    for (std::size_t i = 0; i < 8; ++i) state[i] += added[i];
  };
  std::size_t offset = 0;
  for (; offset + 64 <= bytes.size(); offset += 64) add_block(bytes.data() + offset);
  std::vector<std::byte> end(bytes.begin() + static_cast<std::ptrdiff_t>(offset), bytes.end());
  end.push_back(std::byte{0x80});
  while (end.size() % 64 != 56) end.push_back(std::byte{0});
  for (int shift = 56; shift >= 0; shift -= 8)
    end.push_back(static_cast<std::byte>(std::uint64_t{bytes.size()} * 8 >> shift));
  for (offset = 0; offset < end.size(); offset += 64) add_block(end.data() + offset);

  std::string text;
  for (const std::uint32_t word : state) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", word);
    text += digits;
  }
  return text;
}

struct Reference {
  std::string file, checksum;
  std::uint64_t points = 0;
};

/// The files of laz_reference.json that have a checksum. Only what is needed of JSON: the file is known.
std::vector<Reference> references() {
  std::ifstream stream(shared_data("laz_reference.json"));
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  std::vector<Reference> found;
  for (std::size_t at = text.find("\"file\":"); at != std::string::npos;
       at = text.find("\"file\":", at + 1)) {
    const std::size_t end = std::min(text.find("\"file\":", at + 1), text.size());
    const std::string_view entry(text.data() + at, end - at);
    const auto value = [&](const std::string& key) {
      const std::size_t offset = entry.find("\"" + key + "\":");
      if (offset == std::string_view::npos) return std::string();
      std::size_t first = offset + key.size() + 3;
      while (std::isspace(static_cast<unsigned char>(entry[first])) != 0 || entry[first] == '"') ++first;
      return std::string(entry.substr(first, entry.find_first_of("\",\n}", first) - first));
    };
    if (value("sha256_records").empty()) continue;
    found.push_back({value("file"), value("sha256_records"), std::stoull(value("points"))});
  }
  return found;
}

TEST(LazSharedDataTest, records_have_the_checksums_of_the_reference_on_any_number_of_threads) {
  if (shared_data("laz_reference.json").empty())
    GTEST_SKIP() << test::absent("../shared/data/laz_reference.json", 6);
  const std::vector<Reference> all = references();
  ASSERT_EQ(all.size(), 6u);
  for (const Reference& reference : all) {
    for (const std::size_t threads : {1u, 4u}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const ReadLaz read = read_laz(InputFile(shared_data(reference.file)));
      EXPECT_EQ(read.header.point_count, reference.points) << reference.file;
      EXPECT_EQ(sha256(read.records), reference.checksum) << reference.file;
    }
  }
}

TEST(LazSharedDataTest, chunks_are_found_without_a_table) {
  if (shared_data("laz_reference.json").empty())
    GTEST_SKIP() << test::absent("../shared/data/laz_reference.json", 6);
  for (const Reference& reference : references()) {
    std::vector<std::byte> bytes = test::read_bytes(shared_data(reference.file));
    InputFile file(bytes, "memory");
    std::vector<std::string> warnings;
    const LasHeader header = read_las_header(file, warnings);
    const std::int64_t nowhere = 0;
    std::memcpy(bytes.data() + header.points_offset, &nowhere, sizeof nowhere);
    EXPECT_EQ(sha256(read_laz(bytes).records), reference.checksum) << reference.file;
  }
}

TEST(LazSharedDataTest, only_wanted_layers_are_unpacked_and_nothing_else_changes) {
  const std::filesystem::path path = shared_data("lidar_rgb/sample_lareunion_epsg2975.laz");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud all = read_cloud(path, {.color_depth = ColorDepth::bits_16});
  for (const Attribute attribute : {Attribute::color, Attribute::classification, Attribute::gps_time}) {
    const PointCloud some = read_cloud(path, {.attributes = attribute, .color_depth = ColorDepth::bits_16});
    EXPECT_EQ(some.positions, all.positions);
    if (attribute == Attribute::color) {
      EXPECT_EQ(some.colors, all.colors);
    } else if (attribute == Attribute::classification) {
      EXPECT_EQ(some.classifications, all.classifications);
    } else {
      EXPECT_EQ(some.gps_times, all.gps_times);
    }
  }
}

TEST(LazSharedDataTest, copc_is_detected_and_its_records_are_left_out) {
  const std::filesystem::path path = shared_data("lidar_rgb/lion_takanawa.copc.laz");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  EXPECT_EQ(cloud.files.at(0).format, "COPC");
  EXPECT_EQ(cloud.size(), 341989u);
  for (const VariableLengthRecord& record : cloud.records) {
    EXPECT_NE(record.user_id, "copc");
    EXPECT_NE(record.user_id, "laszip encoded");
  }
}

TEST(LazSharedDataTest, damaged_and_odd_files_are_errors_or_clean_reads) {
  if (shared_data("malformed").empty()) GTEST_SKIP() << test::absent("../shared/data/malformed", 3);
  const auto contains = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  const auto error = [](const char* name) {
    return test::error_of([&] { read_cloud(shared_data(std::string("malformed/") + name)); });
  };
  EXPECT_TRUE(contains(error("lone-star-invalid-tile_2-2-2-2.laz"), "unsupported LAS version"));
  EXPECT_EQ(read_cloud(shared_data("malformed/laszip-generated_with2bytespadding.laz")).size(), 1065u);
  const PointCloud old = read_cloud(shared_data("malformed/simple-laszip-compressor-version-1.2r0.laz"));
  EXPECT_EQ(old.size(), 1065u);
  EXPECT_EQ(old.files.at(0).point_format, 3);
}

}  // namespace
}  // namespace alidade
