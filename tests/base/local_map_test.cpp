// SPDX-License-Identifier: MIT
#include "base/local_map.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "base/input_file.h"
#include "base/output_file.h"
#include "base/remote_map.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade {
namespace {

using test::error_of;

constexpr std::size_t k_page = 4096;

class LocalMapTest : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = test::test_folder() / "index";
    test::write_text(path_, std::string(8 * k_page, 'x'));
  }
  void TearDown() override {
    RemoteMap::check_all();  // no failure outlives its map
  }
  std::shared_ptr<const LocalMap> open() const { return LocalMap::open(path_.string(), "the index"); }
  static char read(const LocalMap& map, std::size_t at) {
    return static_cast<char>(*static_cast<const volatile std::byte*>(map.bytes().data() + at));
  }
  std::filesystem::path path_;
};

TEST_F(LocalMapTest, has_the_bytes_of_its_file) {
  const auto map = open();
  ASSERT_EQ(map->bytes().size(), 8 * k_page);
  EXPECT_EQ(read(*map, 8 * k_page - 1), 'x');
  RemoteMap::check(map->bytes().data());
  std::filesystem::resize_file(path_, 0);
  EXPECT_TRUE(open()->bytes().empty());
}

TEST_F(LocalMapTest, of_a_file_that_was_cut_gives_zeros_and_an_error) {
  const std::filesystem::path sound_path = path_.parent_path() / "sound";
  test::write_text(sound_path, "sound");
  const auto sound = LocalMap::open(sound_path.string(), "sound");
  auto map = open();
  std::filesystem::resize_file(path_, 2 * k_page);
  RemoteMap::check(map->bytes().data());  // no page that is missing was read
  std::vector<std::thread> threads;
  std::atomic<int> zeros = 0;
  for (std::size_t i = 0; i < 4; ++i)
    threads.emplace_back([&, i] { zeros += read(*map, (7 - i) * k_page + 17) == '\0' ? 1 : 0; });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(zeros, 4);
  EXPECT_EQ(read(*map, k_page), 'x');
  const std::string expected =
      "the index: the file changed or its disk failed while it was read; read it again; expected 32768 "
      "bytes, found "
      "8192 bytes";
  EXPECT_EQ(error_of([&] { RemoteMap::check(map->bytes().data() + k_page); }), expected);
  EXPECT_EQ(error_of([] { RemoteMap::check_all(); }), expected);
  RemoteMap::check(sound->bytes().data());
  const std::filesystem::path output = path_.parent_path() / "output";
  EXPECT_EQ(error_of([&] {
              OutputFile file(output, false);
              file.commit();
            }),
            expected);
  EXPECT_FALSE(std::filesystem::exists(output));
  map.reset();
  OutputFile(output, false).commit();
  // Another map at the address of the first has not failed.
  map = open();
  RemoteMap::check(map->bytes().data());
}

TEST_F(LocalMapTest, of_a_file_that_was_written_over_is_an_error_before_results_count) {
  const auto map = open();
  RemoteMap::check_all();
  std::filesystem::last_write_time(path_, std::filesystem::last_write_time(path_) + std::chrono::seconds(3));
  EXPECT_NE(error_of([] { RemoteMap::check_all(); }).find("the index: the file changed"), std::string::npos);
}

TEST_F(LocalMapTest, of_a_file_that_was_replaced_stays_as_it_was) {
  const auto map = open();
  OutputFile file(path_, true);
  file.commit();
  EXPECT_EQ(read(*map, 7 * k_page), 'x');
  RemoteMap::check_all();
}

/// What the handler of a caller makes of a signal.
void exit_with_17(int) {
  std::_Exit(17);
}

TEST_F(LocalMapTest, leaves_other_signals_to_who_had_them_before) {
  // The test runs in a process of its own, which has no handler yet.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto touch_both = [&](void (*handler)(int)) {
    ::signal(SIGBUS, handler);
    const auto map = open();
    const std::filesystem::path foreign = path_.parent_path() / "foreign";
    test::write_text(foreign, "something else");
    const FileDescriptor file(foreign.string(), O_RDONLY);
    const auto* const other =
        static_cast<const volatile char*>(::mmap(nullptr, k_page, PROT_READ, MAP_SHARED, file.number(), 0));
    std::filesystem::resize_file(path_, 0);
    if (read(*map, 0) != '\0') std::_Exit(1);
    std::filesystem::resize_file(foreign, 0);
    std::_Exit(*other == 's' ? 2 : 3);
  };
  EXPECT_EXIT(touch_both(&exit_with_17), ::testing::ExitedWithCode(17), "");
  EXPECT_EXIT(touch_both(SIG_DFL), ::testing::KilledBySignal(SIGBUS), "");
}

}  // namespace
}  // namespace alidade
