// SPDX-License-Identifier: MIT
#include "base/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>

#include "base/input_file.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade {
namespace {

using test::error_of;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

std::string content(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = test::read_bytes(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(OutputFileTest, appears_whole_at_commit_and_leaves_nothing_else) {
  const std::filesystem::path folder = test::test_folder(), path = folder / "out.txt";
  OutputFile file(path, false);
  file.write(bytes_of("hello "));
  file.write(bytes_of("world"));
  EXPECT_EQ(file.size(), 11u);
  EXPECT_FALSE(std::filesystem::exists(path));
  file.commit();
  EXPECT_EQ(content(path), "hello world");
  EXPECT_EQ(files_in(folder), 1u);
}

TEST(OutputFileTest, write_text_file_writes_a_text_as_an_output_file) {
  const std::filesystem::path folder = test::test_folder(), path = folder / "out.txt";
  write_text_file(path, "earlier", false);
  EXPECT_NE(error_of([&] { write_text_file(path, "later", false); }).find("the file exists"),
            std::string::npos);
  EXPECT_EQ(content(path), "earlier");
  write_text_file(path, "later", true);
  EXPECT_EQ(content(path), "later");
  EXPECT_EQ(files_in(folder), 1u);
}

TEST(OutputFileTest, without_commit_nothing_is_left_and_an_earlier_file_stays) {
  const std::filesystem::path folder = test::test_folder(), path = folder / "out.txt";
  test::write_text(path, "earlier");
  {
    OutputFile file(path, true);
    file.write(bytes_of("later"));
  }
  EXPECT_EQ(content(path), "earlier");
  EXPECT_EQ(files_in(folder), 1u);
}

TEST(OutputFileTest, replaces_a_file_only_if_requested) {
  const std::filesystem::path path = test::test_folder() / "out.txt";
  test::write_text(path, "earlier");
  EXPECT_NE(error_of([&] {
              OutputFile(path, false);
            }).find("the file exists; expected another name, or --overwrite"),
            std::string::npos);
  EXPECT_NE(error_of([&] {
              check_output(path, false);
            }).find("the file exists; expected another name, or --overwrite"),
            std::string::npos);
  check_output(path, true);
  OutputFile file(path, true);
  file.write(bytes_of("later"));
  file.commit();
  EXPECT_EQ(content(path), "later");
}

TEST(OutputFileTest, a_file_that_appeared_in_the_meantime_is_not_replaced) {
  const std::filesystem::path path = test::test_folder() / "out.txt";
  OutputFile file(path, false);
  test::write_text(path, "somebody else's");
  EXPECT_NE(error_of([&] { file.commit(); }).find("the file exists; expected another name, or --overwrite"),
            std::string::npos);
  EXPECT_EQ(content(path), "somebody else's");
}

TEST(OutputFileTest, a_missing_folder_and_a_folder_as_file_are_errors) {
  const std::filesystem::path folder = test::test_folder();
  EXPECT_NE(error_of([&] { OutputFile(folder / "none" / "out.txt", false); }).find("no such folder"),
            std::string::npos);
  EXPECT_NE(error_of([&] { OutputFile(folder, true); }).find("cannot replace the file: not a regular file"),
            std::string::npos);
  EXPECT_NE(
      error_of([&] { OutputFile("/dev/null", true); }).find("cannot replace the file: not a regular file"),
      std::string::npos);
}

TEST(OutputFileTest, write_at_completes_bytes_already_written) {
  const std::filesystem::path path = test::test_folder() / "out.txt";
  OutputFile file(path, false);
  const std::string large(1000000, 'x');
  file.write(bytes_of("head"));
  file.write(bytes_of(large));
  file.write_at(1, bytes_of("EA"));
  file.write(bytes_of("tail"));
  file.write_at(1000002, bytes_of("XX"));
  file.commit();
  std::string expected = "head" + large + "tail";
  expected.replace(1, 2, "EA");
  expected.replace(1000002, 2, "XX");
  EXPECT_EQ(content(path), expected);
}

TEST(OutputFileTest, a_symbolic_link_keeps_leading_to_the_file) {
  const std::filesystem::path folder = test::test_folder();
  test::write_text(folder / "target.txt", "earlier");
  std::filesystem::create_symlink("target.txt", folder / "link.txt");
  OutputFile file(folder / "link.txt", true);
  file.write(bytes_of("later"));
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.txt"));
  EXPECT_EQ(content(folder / "target.txt"), "later");
}

TEST(OutputFileTest, names_may_be_as_long_as_file_systems_take) {
  const std::filesystem::path folder = test::test_folder();
  for (const std::string& extension :
       {std::string(".las"), std::string("." + std::string(100, 'e')), std::string()}) {
    const std::filesystem::path path = folder / (std::string(255 - extension.size(), 'x') + extension);
    OutputFile file(path, false);
    file.write(bytes_of("long"));
    file.commit();
    EXPECT_EQ(content(path), "long");
    EXPECT_LE(temporary_beside(path, 3).filename().string().size() + 8, 255u);
  }
  EXPECT_EQ(files_in(folder), 3u);
}

TEST(OutputFileTest, a_link_that_leads_nowhere_gets_its_target) {
  const std::filesystem::path folder = test::test_folder();
  std::filesystem::create_directories(folder / "data");
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
  std::filesystem::create_symlink("data/real.txt", folder / "link.txt");
  std::filesystem::create_symlink("link.txt", folder / "chain.txt");
  for (const bool overwrite : {false, true}) {
    OutputFile file(folder / "chain.txt", overwrite);
    file.write(bytes_of(overwrite ? "again" : "once"));
    file.commit();
    EXPECT_EQ(content(folder / "data" / "real.txt"), overwrite ? "again" : "once");
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.txt"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "chain.txt"));
  }
  std::filesystem::create_symlink("loop.txt", folder / "loop.txt");
  EXPECT_NE(error_of([&] { OutputFile(folder / "loop.txt", true); }), "");
}

TEST(OutputFileTest, a_link_in_a_folder_that_others_can_write_requires_overwrite) {
  namespace fs = std::filesystem;
  const fs::path folder = test::test_folder(), shared = folder / "shared";
  for (const char* const name : {"shared", "own"}) {
    fs::create_directories(folder / name);
    fs::permissions(folder / name, fs::perms::owner_all);
  }
  test::write_text(folder / "own" / "kept.txt", "kept");
  fs::create_symlink(folder / "own" / "kept.txt", shared / "link.txt");
  fs::create_symlink(folder / "own" / "new.txt", shared / "dangling.txt");
  fs::create_symlink(shared / "dangling.txt", folder / "own" / "chain.txt");
  const std::string problem = "the output is a symbolic link in a folder that others can write";
  for (const fs::perms others : {fs::perms::others_write, fs::perms::group_write}) {
    fs::permissions(shared, fs::perms::owner_all | others);
    for (const fs::path& link :
         {shared / "link.txt", shared / "dangling.txt", folder / "own" / "chain.txt"}) {
      EXPECT_TRUE(error_of([&] { OutputFile(link, false); }).starts_with(link.string() + ": " + problem))
          << link;
      EXPECT_NE(error_of([&] { check_output(link, false); }).find("--overwrite"), std::string::npos) << link;
      EXPECT_NE(error_of([&] { check_links(link); }).find(problem), std::string::npos) << link;
    }
    check_links(shared / "plain.txt");
    OutputFile(shared / "plain.txt", false).commit();
    fs::remove(shared / "plain.txt");
  }
  EXPECT_FALSE(fs::exists(folder / "own" / "new.txt"));
  EXPECT_EQ(content(folder / "own" / "kept.txt"), "kept");
  OutputFile(shared / "dangling.txt", true).commit();
  EXPECT_TRUE(fs::exists(folder / "own" / "new.txt"));
  fs::remove(folder / "own" / "new.txt");
  // Of a folder that only its owner can write, links are the owner's wish.
  fs::permissions(shared, fs::perms::owner_all);
  check_links(folder / "own" / "chain.txt");
  OutputFile(folder / "own" / "chain.txt", false).commit();
  EXPECT_TRUE(fs::exists(folder / "own" / "new.txt"));
}

TEST(OutputFileTest, what_a_dead_process_left_of_the_same_output_is_removed) {
  const std::filesystem::path folder = test::test_folder(), path = folder / "out.txt";
  // More than any process has, and one that another process has by now: this.
  const std::string dead = ".out.part-99999999-0.txt",
                    reused = ".out.part-" + std::to_string(::getpid()) + "-7.txt",
                    live = ".out.part-" + std::to_string(::getppid()) + "-0.txt";
  for (const std::string& name :
       {dead, reused, live, std::string(".other.part-99999999-0.txt"),
        std::string(".out.part-99999999-0x.txt"), std::string(".out.part-me-0.txt")})
    test::write_text(folder / name, "unfinished");
  const FileDescriptor writer((folder / live).string(), O_RDWR);
  ASSERT_EQ(::flock(writer.number(), LOCK_EX), 0);
  OutputFile file(path, false);
  EXPECT_FALSE(std::filesystem::exists(folder / dead));
  EXPECT_FALSE(std::filesystem::exists(folder / reused));
  EXPECT_TRUE(std::filesystem::exists(folder / live));
  EXPECT_EQ(files_in(folder), 5u);
}

TEST(OutputFileTest, a_temporary_file_is_locked_until_it_has_its_name) {
  const std::filesystem::path folder = test::test_folder(), output = folder / "out.txt";
  const auto is_locked = [&](const std::filesystem::path& path) {
    const FileDescriptor other(path.string(), O_RDWR);
    return ::flock(other.number(), LOCK_EX | LOCK_NB) != 0;
  };
  std::filesystem::path temporary, next_temporary;
  {
    const FileDescriptor file(create_temporary(output, "out", temporary));
    EXPECT_TRUE(is_locked(temporary));
    EXPECT_TRUE(sync_temporary(file.number()));
    EXPECT_TRUE(is_locked(temporary));
    // Another one of this process leaves it alone.
    const FileDescriptor next(create_temporary(output, "out", next_temporary));
    EXPECT_NE(next_temporary, temporary);
    EXPECT_EQ(files_in(folder), 2u);
  }
  EXPECT_FALSE(is_locked(temporary));
}

TEST(OutputFileTest, so_it_is_beside_an_output_without_a_folder) {
  const std::filesystem::path folder = test::test_folder(), before = std::filesystem::current_path();
  test::write_text(folder / ".out.part-99999999-0.txt", "unfinished");
  std::filesystem::current_path(folder);
  { const OutputFile file("out.txt", false); }
  std::filesystem::current_path(before);
  EXPECT_EQ(files_in(folder), 0u);
}

}  // namespace
}  // namespace alidade
