// SPDX-License-Identifier: MIT
// Files that others wrote against checksums of what another decoder made of them.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cctype>
#include <fstream>
#include <iterator>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/laz/laz_records.h"
#include "tests/cloud/sha256.h"

namespace alidade {
namespace {

using test::k_no_shared_data;
using test::read_laz;
using test::ReadLaz;
using test::shared_data;

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
      EXPECT_EQ(test::sha256(read.records), reference.checksum) << reference.file;
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
    EXPECT_EQ(test::sha256(read_laz(bytes).records), reference.checksum) << reference.file;
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
