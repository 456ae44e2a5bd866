// SPDX-License-Identifier: MIT
#include "base/local_map.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "base/output_file.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade {
namespace {

constexpr std::size_t k_page = 4096;
constexpr const char* k_message = "alidade: error: .*index: the file became shorter, or its disk failed";

class LocalMapTest : public ::testing::Test {
 protected:
  void SetUp() override {
    // What ends a process is tested in one of its own, which has no handler yet.
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    path_ = test::test_folder() / "index";
    test::write_text(path_, std::string(8 * k_page, 'x'));
  }
  MappedBytes open() const { return InputFile(path_).map(); }
  static char read(const MappedBytes& map, std::size_t at) {
    return static_cast<char>(*static_cast<const volatile std::byte*>(map.bytes.data() + at));
  }
  std::filesystem::path path_;
};

TEST_F(LocalMapTest, has_the_bytes_of_its_file) {
  const MappedBytes map = open();
  ASSERT_EQ(map.bytes.size(), 8 * k_page);
  EXPECT_EQ(read(map, 8 * k_page - 1), 'x');
  std::filesystem::resize_file(path_, 0);
  EXPECT_TRUE(open().bytes.empty());
}

TEST_F(LocalMapTest, of_a_file_that_was_cut_ends_the_process_at_the_first_missing_page) {
  const auto read_all = [&] {
    const MappedBytes map = open();
    std::filesystem::resize_file(path_, 2 * k_page);
    if (read(map, k_page) != 'x') std::_Exit(1);
    std::vector<std::thread> threads;
    std::atomic<int> read_on = 0;
    for (std::size_t i = 0; i < 4; ++i)
      threads.emplace_back([&, i] {
        read(map, (7 - i) * k_page + 17);
        ++read_on;
      });
    for (std::thread& thread : threads) thread.join();
    std::_Exit(10 + read_on);
  };
  EXPECT_EXIT(read_all(), ::testing::ExitedWithCode(2), k_message);
}

TEST_F(LocalMapTest, nothing_is_written_of_a_file_that_was_cut) {
  const std::filesystem::path output = path_.parent_path() / "output";
  const auto write_all = [&] {
    const MappedBytes map = open();
    std::filesystem::resize_file(path_, 0);
    OutputFile file(output, true);
    // More than its buffer holds: the system reads the bytes.
    for (int i = 0; i < 100; ++i) file.write(map.bytes);
    file.commit();
    std::_Exit(0);
  };
  EXPECT_EXIT(write_all(), ::testing::ExitedWithCode(2), k_message);
  EXPECT_FALSE(std::filesystem::exists(output));
  // The next run removes what the first one left.
  OutputFile(output, true).commit();
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path_.parent_path())) ++files;
  EXPECT_EQ(files, 2u);
}

TEST_F(LocalMapTest, of_a_file_that_was_replaced_stays_as_it_was) {
  const MappedBytes map = open();
  OutputFile file(path_, true);
  file.commit();
  EXPECT_EQ(read(map, 7 * k_page), 'x');
}

TEST_F(LocalMapTest, a_map_that_is_gone_does_not_answer_for_its_addresses) {
  const auto read_another = [&] {
    ::signal(SIGBUS, SIG_DFL);  // sanitizers have a handler of their own
    const std::byte* const address = open().bytes.data();
    const FileDescriptor file(path_.string(), O_RDONLY);
    const void* const other =
        ::mmap(const_cast<std::byte*>(address), k_page, PROT_READ, MAP_SHARED | MAP_FIXED, file.number(), 0);
    std::filesystem::resize_file(path_, 0);
    std::_Exit(*static_cast<const volatile char*>(other));
  };
  EXPECT_EXIT(read_another(), ::testing::KilledBySignal(SIGBUS), "");
}

/// What the handler of a caller makes of a signal.
void exit_with_17(int) {
  std::_Exit(17);
}

TEST_F(LocalMapTest, leaves_other_signals_to_who_had_them_before) {
  const auto read_foreign = [&](void (*handler)(int)) {
    ::signal(SIGBUS, handler);
    const MappedBytes map = open();
    const std::filesystem::path foreign = path_.parent_path() / "foreign";
    test::write_text(foreign, "something else");
    const FileDescriptor file(foreign.string(), O_RDONLY);
    const auto* const other =
        static_cast<const volatile char*>(::mmap(nullptr, k_page, PROT_READ, MAP_SHARED, file.number(), 0));
    std::filesystem::resize_file(foreign, 0);
    std::_Exit(*other == 's' ? 2 : 3);
  };
  EXPECT_EXIT(read_foreign(&exit_with_17), ::testing::ExitedWithCode(17), "");
  EXPECT_EXIT(read_foreign(SIG_DFL), ::testing::KilledBySignal(SIGBUS), "");
}

}  // namespace
}  // namespace alidade
