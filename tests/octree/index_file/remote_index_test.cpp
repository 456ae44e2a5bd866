// SPDX-License-Identifier: MIT
// Index files that arrive as they are touched: the same answers, and no answer that is wrong when the network fails.
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>

#include "base/output_file.h"
#include "base/remote_map.h"
#include "octree/index_file/index_file.h"
#include "tests/octree/index_file/damaged_index.h"

namespace alidade {
namespace {

using test::Bytes;
using test::error_of;
using test::put;
using test::seal;
using test::section;
using test::sound_file;

constexpr const char* k_name = "http://test/site.alidade";

/// What the server has, how often it was read, and how often it can be.
Bytes served;
std::atomic<int> reads = 0, most_reads = 0;

class ServedFile final : public RemoteFile {
 public:
  std::uint64_t size() const override { return served.size(); }
  std::string version() const override { return "1"; }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    if (reads++ >= most_reads) throw Error({.file = k_name, .problem = "the network is gone"});
    std::memcpy(into.data(), served.data() + offset, into.size());
  }
};

class RemoteIndex : public ::testing::Test {
 protected:
  void SetUp() override {
    serve(sound_file());
    set_remote_files(
        [](const std::string&) -> std::unique_ptr<RemoteFile> { return std::make_unique<ServedFile>(); });
    if (!RemoteMap::open(k_name)) GTEST_SKIP() << "userfaultfd is not permitted here";
  }
  void TearDown() override {
    set_remote_files(nullptr);
    // Else the next file that a test writes would be rejected.
    try {
      RemoteMap::check_all();
    } catch (const Error&) {
    }
  }
  static void serve(const Bytes& bytes, int most = 1 << 20) {
    served = bytes;
    reads = 0;
    most_reads = most;
  }
  static IndexFile open() { return open_index(k_name); }
};

TEST_F(RemoteIndex, answers_are_those_of_the_file) {
  const IndexFile index = open();
  test::use(index);
  const IndexFile local = test::index_in_memory(sound_file());
  const Ray ray = make_ray({0, 0, 0}, {0, 1, 0});
  const RayQuery query{.measure = Measure::distance, .k = 50};
  EXPECT_EQ(find(index.octree(), ray, query), find(local.octree(), ray, query));
  test::expect_same_columns(index.columns(), local.columns());
  index.verify();
}

TEST_F(RemoteIndex, a_section_that_nobody_reads_is_not_fetched) {
  Bytes bytes = sound_file();
  bytes[section(bytes, IndexSection::first_column).offset] ^= std::byte{1};
  serve(bytes);
  const IndexFile index = open();
  const Octree octree = index.octree();
  EXPECT_TRUE(closest(octree, make_ray({0, 0, 0}, {0, 1, 0}), {.measure = Measure::distance}));
  RemoteMap::check_all();
  EXPECT_NE(error_of([&] { index.verify(); }).find("checksum mismatch in the next"), std::string::npos);
}

TEST_F(RemoteIndex, damage_of_what_a_query_reads_is_an_error) {
  for (const IndexSection kind : {IndexSection::nodes, IndexSection::coordinates, IndexSection::ids,
                                  IndexSection::metadata, IndexSection::checksums}) {
    Bytes bytes = sound_file();
    bytes[section(bytes, kind).offset + 9] ^= std::byte{1};
    serve(bytes);
    EXPECT_NE(error_of([&] { test::use(open()); }).find("corrupt section "), std::string::npos) << name(kind);
  }
}

TEST_F(RemoteIndex, an_id_beyond_the_points_is_an_error) {
  Bytes bytes = sound_file();
  put(bytes, section(bytes, IndexSection::ids).offset + 40, std::uint32_t{1508});
  seal(bytes);
  serve(bytes);
  EXPECT_NE(error_of([&] { test::use(open()); }).find("id out of range; expected less than 1508, found 1508"),
            std::string::npos);
}

TEST_F(RemoteIndex, a_network_that_fails_at_any_time_is_an_error) {
  test::use(open());
  const int all = reads;
  EXPECT_GT(all, 5);
  for (int most = 0; most < all; ++most) {
    serve(sound_file(), most);
    const std::string message = error_of([&] {
      test::use(open());
      RemoteMap::check_all();
    });
    EXPECT_EQ(message, std::string(k_name) + ": the network is gone") << most;
  }
}

TEST_F(RemoteIndex, nothing_is_written_of_a_map_that_failed) {
  const auto path = test::test_folder() / "columns.bin";
  {
    const IndexFile index = open();
    most_reads = 0;
    OutputFile output(path, true);
    output.write(std::as_bytes(index.columns().colors));
    EXPECT_EQ(error_of([&] { output.commit(); }), std::string(k_name) + ": the network is gone");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(RemoteIndex, what_does_not_fit_in_memory_arrives_again) {
  Bytes bytes(64 * 4096 + 100);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i / 4096 + 1);
  serve(bytes);
  const auto map = RemoteMap::open(k_name, 8 * 4096);
  for (int pass = 0; pass < 2; ++pass) {
    const int before = reads;
    for (std::size_t i = 0; i < bytes.size(); i += 50) ASSERT_EQ(map->bytes()[i], bytes[i]) << i;
    EXPECT_GT(reads, before);
  }
  map->fetch(map->bytes());
  RemoteMap::touch(map->bytes());
  EXPECT_EQ(map->bytes().back(), bytes.back());
  RemoteMap::check_all();
}

// The pages of a map that failed are zero.
TEST_F(RemoteIndex, zeros_for_all_but_the_nodes_do_no_harm) {
  Bytes bytes = sound_file();
  for (const test::SectionRow& row : test::section_rows(bytes)) {
    const auto kind = static_cast<IndexSection>(row.kind);
    if (kind == IndexSection::nodes || kind == IndexSection::metadata || kind == IndexSection::checksums)
      continue;
    std::memset(bytes.data() + row.offset, 0, row.bytes);
  }
  seal(bytes);
  test::use(test::index_in_memory(bytes));
}

}  // namespace
}  // namespace alidade
