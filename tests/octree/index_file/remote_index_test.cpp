// SPDX-License-Identifier: MIT
// Index files that arrive as they are touched: answers equal those of local files, and are never wrong when
// the network fails.
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

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
std::uint64_t served_size = 0;

class ServedFile final : public RemoteFile {
 public:
  std::uint64_t size() const override { return served_size; }
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
    RemoteMap::check_all();  // no failure outlives its map
  }
  static void serve(const Bytes& bytes, int most = 1 << 20) {
    served = bytes;
    served_size = bytes.size();
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
    output.write(std::as_bytes(index.columns().normals));
    EXPECT_EQ(error_of([&] { output.commit(); }), std::string(k_name) + ": the network is gone");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(RemoteIndex, a_failure_stays_for_as_long_as_its_map) {
  const std::string gone = std::string(k_name) + ": the network is gone";
  {
    const IndexFile index = open();
    const IndexFile sound = open();
    sound.octree();
    most_reads = 0;
    RemoteMap::touch(std::as_bytes(index.columns().normals));
    const auto* const failed = index.columns().normals.data();
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(error_of([] { RemoteMap::check_all(); }), gone);
      EXPECT_EQ(error_of([&] { RemoteMap::check(failed); }), gone);
    }
    RemoteMap::check(sound.columns().normals.data());
  }
  RemoteMap::check_all();
}

Bytes numbered_pages(std::size_t pages) {
  Bytes bytes(pages * 4096 + 100);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i / 4096 + 1);
  return bytes;
}

TEST_F(RemoteIndex, what_has_arrived_stays) {
  serve(numbered_pages(64));
  const auto map = RemoteMap::open(k_name, 65 * 4096);
  map->fetch(map->bytes());
  most_reads = 0;
  EXPECT_TRUE(std::ranges::equal(map->bytes(), served));
  RemoteMap::check_all();
}

TEST_F(RemoteIndex, what_all_maps_hold_together_is_limited) {
  serve(numbered_pages(64));
  {
    const auto first = RemoteMap::open(k_name, 70 * 4096), second = RemoteMap::open(k_name, 70 * 4096);
    RemoteMap::touch(first->bytes());
    RemoteMap::check_all();
    RemoteMap::touch(second->bytes());
    EXPECT_NE(error_of([&] { RemoteMap::check(second->bytes().data()); }).find("copy it to this machine"),
              std::string::npos);
    RemoteMap::check(first->bytes().data());
  }
  const auto map = RemoteMap::open(k_name, 70 * 4096);
  RemoteMap::touch(map->bytes());
  RemoteMap::check_all();
}

TEST_F(RemoteIndex, of_many_threads_each_gets_the_bytes_or_learns_that_the_network_failed) {
  constexpr std::size_t k_pages = 1000, k_threads = 8, k_step = 37;
  for (const int most : {1 << 20, 300}) {
    serve(numbered_pages(k_pages), most);
    std::atomic<int> with_wrong_bytes = 0, failed = 0;
    {
      const auto map = RemoteMap::open(k_name);
      std::vector<std::jthread> threads;
      for (std::size_t thread = 0; thread < k_threads; ++thread)
        threads.emplace_back([&, thread] {
          bool is_right = true;
          for (std::size_t i = 0; i < k_pages; ++i) {
            const std::size_t at = (i * k_step + thread * (k_pages / k_threads)) % k_pages * 4096;
            is_right &= map->bytes()[at] == served[at];
          }
          bool has_failed = false;
          try {
            RemoteMap::check(map->bytes().data());
          } catch (const Error&) {
            has_failed = true;
          }
          failed += has_failed ? 1 : 0;
          with_wrong_bytes += is_right || has_failed ? 0 : 1;
        });
    }
    EXPECT_EQ(with_wrong_bytes, 0);
    EXPECT_EQ(failed, most == 300 ? static_cast<int>(k_threads) : 0);
  }
}

TEST_F(RemoteIndex, a_size_that_the_server_makes_up_takes_no_memory) {
  served_size = std::uint64_t{1} << 46;
  EXPECT_NE(error_of([] { RemoteMap::open(k_name); }).find("a size that no index file has"),
            std::string::npos);
  EXPECT_NE(error_of([] { open(); }).find("the file is too long"), std::string::npos);
  const auto resident = [] {
    std::uint64_t all = 0, pages = 0;
    std::ifstream("/proc/self/statm") >> all >> pages;
    return pages * 4096;
  };
  const std::uint64_t before = resident();
  served_size = std::uint64_t{1} << 43;
  const auto map = RemoteMap::open(k_name);
  ASSERT_TRUE(map);
  EXPECT_EQ(map->bytes()[10], served[10]);
  EXPECT_LT(resident() - std::min(before, resident()), std::uint64_t{64} << 20);
}

TEST_F(RemoteIndex, where_userfaultfd_is_not_permitted_the_file_is_copied) {
  ::rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
  const ::rlimit none{0, limit.rlim_max};  // no more files: userfaultfd(2) fails
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const auto restore = [&](int*) { ::setrlimit(RLIMIT_NOFILE, &limit); };
  int guarded = 0;
  const std::unique_ptr<int, decltype(restore)> guard(&guarded, restore);
  EXPECT_FALSE(RemoteMap::open(k_name));
  const IndexFile index = open();
  EXPECT_FALSE(RemoteMap::find(index.columns().normals.data()));
  test::expect_same_columns(index.columns(), test::index_in_memory(sound_file()).columns());
  served[section(served, IndexSection::nodes).offset + 9] ^= std::byte{1};
  EXPECT_NE(error_of([] { test::use(open()); }).find("corrupt section nodes"), std::string::npos);
}

TEST_F(RemoteIndex, in_a_process_that_forked_has_failed) {
  serve(numbered_pages(64));
  auto map = RemoteMap::open(k_name);
  RemoteMap::touch(map->bytes().first(4096));
  const ::pid_t child = ::fork();
  if (child == 0) {
    ::alarm(20);
    const bool is_known =
        error_of([&] { RemoteMap::check(map->bytes().data()); }).find("forked") != std::string::npos;
    map->fetch(map->bytes());
    RemoteMap::touch(map->bytes());
    map.reset();
    RemoteMap::check_all();  // what it throws ends the process
    ::_exit(is_known ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  RemoteMap::touch(map->bytes());
  EXPECT_TRUE(std::ranges::equal(map->bytes(), served));
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
  const IndexFile index = test::index_in_memory(bytes);
  test::use(index);
  // Every point is the one of id 0, somewhere in its leaf.
  const Octree octree = index.octree();
  EXPECT_EQ(octree.size(), test::cloud_with_everything().size());
  Bounds everywhere;
  everywhere.grow(glm::dvec3(-1e9));
  everywhere.grow(glm::dvec3(1e9));
  const std::vector<PointHit> hits = find(octree, everywhere, {});
  EXPECT_EQ(hits.size(), octree.size());
  for (const PointHit& hit : hits) EXPECT_EQ(hit.point_id, 0u);
  for (const Color16& color : index.columns().colors) EXPECT_EQ(color, Color16(0));
}

}  // namespace
}  // namespace alidade
