// SPDX-License-Identifier: MIT
// Index files on servers: header and metadata are read from there, points only after the file was fetched.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>

#include "octree/index_file/index_file.h"
#include "tests/octree/index_file/damaged_index.h"

namespace alidade {
namespace {

using test::Bytes;
using test::error_of;
using test::section;
using test::sound_file;

constexpr const char* k_name = "http://test/site.alidade";

/// What the server has, how often and how much of it was read, how often it can be read, and how often it was
/// fetched whole.
struct Server {
  Bytes bytes;
  std::string version = "1";
  std::uint64_t bytes_read = 0;
  int reads = 0, most_reads = 1 << 20, maps = 0;
};
Server server;

class ServedFile final : public RemoteFile {
 public:
  std::uint64_t size() const override { return server.bytes.size(); }
  std::string version() const override { return server.version; }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    if (server.reads++ >= server.most_reads) throw Error({.file = k_name, .problem = "the network is gone"});
    std::memcpy(into.data(), server.bytes.data() + offset, into.size());
    server.bytes_read += into.size();
  }
  MappedBytes map(const Progress& progress) override {
    ++server.maps;
    Bytes all(server.bytes.size());
    read(0, all);
    report(progress, all.size(), all.size());
    return InputFile(all, "copy").map();
  }
};

class RemoteIndex : public ::testing::Test {
 protected:
  void SetUp() override {
    server = {.bytes = sound_file()};
    set_remote_files(
        [](const std::string&) -> std::unique_ptr<RemoteFile> { return std::make_unique<ServedFile>(); });
  }
  void TearDown() override { set_remote_files(nullptr); }
};

TEST_F(RemoteIndex, answers_are_those_of_the_file) {
  const IndexFile index = open_index(k_name);
  test::use(index);
  const IndexFile local = test::index_in_memory(sound_file());
  const Ray ray = make_ray({0, 0, 0}, {0, 1, 0});
  const RayQuery query{.measure = Measure::distance, .k = 50};
  EXPECT_EQ(find(index.octree(), ray, query), find(local.octree(), ray, query));
  test::expect_same_columns(index.columns(), local.columns());
  index.verify();
  EXPECT_EQ(server.maps, 1);
}

TEST_F(RemoteIndex, what_it_says_about_itself_is_read_without_fetching_it) {
  const IndexFile index = open_index(k_name), local = test::index_in_memory(sound_file());
  EXPECT_EQ(index.header().tree.point_count, local.header().tree.point_count);
  EXPECT_EQ(index.attributes().bits, local.attributes().bits);
  EXPECT_EQ(index.description().crs.wkt, local.description().crs.wkt);
  const std::uint64_t records = section(server.bytes, IndexSection::record_data).bytes;
  EXPECT_LT(server.bytes_read + records, server.bytes.size() / 2);
  ASSERT_EQ(index.records().size(), local.records().size());
  for (std::size_t i = 0; i < local.records().size(); ++i)
    EXPECT_EQ(index.records()[i].data, local.records()[i].data);
  EXPECT_EQ(server.maps, 0);
}

TEST_F(RemoteIndex, progress_of_fetching_can_stop_it) {
  const IndexFile index = open_index(k_name);
  std::uint64_t told = 0;
  const Progress stop = [&](std::uint64_t, std::uint64_t total) {
    told = total;
    return false;
  };
  EXPECT_THROW(index.tree(stop), Cancelled);
  EXPECT_EQ(told, server.bytes.size());
  // The next one tries again.
  test::use(index);
  EXPECT_EQ(server.maps, 2);
}

TEST_F(RemoteIndex, damage_is_an_error) {
  for (const IndexSection kind :
       {IndexSection::nodes, IndexSection::ids, IndexSection::metadata, IndexSection::record_data}) {
    server.bytes = sound_file();
    server.bytes[section(server.bytes, kind).offset + 9] ^= std::byte{1};
    const std::string message = error_of([] {
      const IndexFile index = open_index(k_name);
      index.records();
      test::use(index);
    });
    EXPECT_NE(message.find("corrupt section "), std::string::npos) << name(kind);
  }
}

TEST_F(RemoteIndex, a_network_that_fails_at_any_time_is_an_error) {
  test::use(open_index(k_name));
  const int all = server.reads;
  EXPECT_GT(all, 3);
  for (int most = 0; most < all; ++most) {
    server.reads = 0;
    server.most_reads = most;
    EXPECT_EQ(error_of([&] { test::use(open_index(k_name)); }), std::string(k_name) + ": the network is gone")
        << most;
  }
}

TEST_F(RemoteIndex, a_file_that_changed_since_it_was_opened_is_an_error) {
  const IndexFile index = open_index(k_name);
  server.version = "2";
  EXPECT_NE(error_of([&] { index.tree(); }).find("the file changed while it was read"), std::string::npos);
}

}  // namespace
}  // namespace alidade
