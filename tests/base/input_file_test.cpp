// SPDX-License-Identifier: MIT
#include "base/input_file.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade {
namespace {

using test::error_of;

std::string text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Ten bytes, as a file on disk and in memory.
class InputFileTest : public ::testing::TestWithParam<bool> {
 protected:
  InputFile open() {
    if (GetParam()) return InputFile(std::as_bytes(std::span(content_)), "memory");
    const std::filesystem::path path = std::filesystem::temp_directory_path() / "input_file_test.txt";
    test::write_text(path, content_);
    return InputFile(path);
  }
  const std::string content_ = "0123456789";
};

TEST_P(InputFileTest, reads_anywhere) {
  InputFile file = open();
  EXPECT_EQ(file.size(), 10u);
  EXPECT_EQ(text(file.view(7, 3)), "789");
  EXPECT_EQ(text(file.view(0, 2)), "01");
  EXPECT_EQ(text(file.view(3, 0)), "");
  EXPECT_EQ(text(file.view(2, 8)), "23456789");
  std::array<std::byte, 4> copy;
  file.read_at(5, copy);
  EXPECT_EQ(text(copy), "5678");
}

TEST_P(InputFileTest, maps_all_bytes_from_a_page_on) {
  const MappedBytes map = open().map();
  EXPECT_EQ(text(map.bytes), content_);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(map.bytes.data()) % 4096, 0u);
}

TEST_P(InputFileTest, view_up_to_stops_at_the_end) {
  InputFile file = open();
  EXPECT_EQ(text(file.view_up_to(8, 100)), "89");
  EXPECT_EQ(text(file.view_up_to(10, 1)), "");
  EXPECT_EQ(text(file.view_up_to(std::uint64_t(1) << 63, 1)), "");
}

TEST_P(InputFileTest, bytes_beyond_the_end_are_an_error_that_names_the_byte) {
  InputFile file = open();
  EXPECT_NE(error_of([&] { file.view(8, 3); }).find("byte 8"), std::string::npos);
  EXPECT_NE(error_of([&] { file.view(~std::uint64_t(0), 2); }).find("truncated file"), std::string::npos);
  std::array<std::byte, 11> copy;
  EXPECT_NE(error_of([&] { file.read_at(0, copy); }).find("expected 11 bytes from here, found 10"),
            std::string::npos);
  EXPECT_EQ(text(file.view(0, 10)), content_);
}

TEST_P(InputFileTest, reads_on_after_a_rest_and_a_move) {
  InputFile file = open();
  EXPECT_EQ(text(file.view(1, 2)), "12");
  file.rest();
  EXPECT_EQ(text(file.view(1, 2)), "12");
  InputFile moved = std::move(file);
  EXPECT_EQ(text(moved.view(4, 2)), "45");
  file = std::move(moved);
  EXPECT_EQ(text(file.view(4, 3)), "456");
}

INSTANTIATE_TEST_SUITE_P(, InputFileTest, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "in_memory" : "on_disk"; });

TEST(InputFileErrorTest, a_missing_file_and_a_folder_are_errors) {
  EXPECT_NE(error_of([] { InputFile(std::filesystem::path("/no/such/file")); }).find("cannot open the file"),
            std::string::npos);
  EXPECT_NE(error_of([] { InputFile{std::filesystem::temp_directory_path()}; }).find("found a folder"),
            std::string::npos);
}

TEST(InputFileErrorTest, a_file_that_became_shorter_is_an_error) {
  const std::filesystem::path path = test::test_folder() / "shrinks.txt";
  test::write_text(path, "0123456789");
  InputFile file(path);
  test::write_text(path, "012");
  EXPECT_NE(error_of([&] { file.view(0, 10); }).find("the file was truncated while it was read"),
            std::string::npos);
}

/// What the server reports of its file.
std::uint64_t served_size = 0;
std::string served_version;

class ServedFile final : public RemoteFile {
 public:
  std::uint64_t size() const override { return size_; }
  std::string version() const override { return version_; }
  void read(std::uint64_t, std::span<std::byte> into) override { std::ranges::fill(into, std::byte{'x'}); }
  MappedBytes map(const Progress&) override {
    static constexpr std::array k_bytes = {std::byte{'x'}};
    return {k_bytes, nullptr};
  }

 private:
  const std::uint64_t size_ = served_size;
  const std::string version_ = served_version;
};

TEST(InputFileErrorTest, a_remote_file_of_another_size_or_version_after_a_rest_is_an_error) {
  set_remote_files(
      [](const std::string&) -> std::unique_ptr<RemoteFile> { return std::make_unique<ServedFile>(); });
  for (const auto& [size, version, found] : {std::tuple{10u, "2", "found 10 bytes, version 2"},
                                             std::tuple{11u, "1", "found 11 bytes, version 1"}}) {
    served_size = 10;
    served_version = "1";
    InputFile file("https://host/a.laz");
    EXPECT_EQ(text(file.view(0, 2)), "xx");
    file.rest();
    EXPECT_EQ(text(file.view(0, 2)), "xx");
    EXPECT_EQ(text(file.map().bytes), "x");
    file.rest();
    served_size = size;
    served_version = version;
    for (const std::string& message : {error_of([&] { file.view(0, 2); }), error_of([&] { file.map(); })}) {
      EXPECT_NE(message.find("the file changed while it was read"), std::string::npos) << message;
      EXPECT_NE(message.find(found), std::string::npos) << message;
    }
  }
  set_remote_files(nullptr);
}

TEST(PublicName, of_a_url_has_neither_user_nor_parameters) {
  for (const auto& [name, expected] : std::initializer_list<std::pair<const char*, const char*>>{
           {"https://host/a.laz", "https://host/a.laz"},
           {"https://paul:word@host:8080/a@b.laz?sig=x&y=/z@", "https://host:8080/a@b.laz"},
           {"/vsizip//vsicurl/http://paul@host/a.zip?sig=x", "/vsizip//vsicurl/http://host/a.zip"},
           {"http://paul:w@rd@host", "http://host"},
           {"https://host?sig=x#y", "https://host"},
           {"s3://bucket/a?b.laz", "s3://bucket/a?b.laz"},
           {"folder@home/a?.laz", "folder@home/a?.laz"}}) {
    EXPECT_EQ(public_name(name), expected);
    const Error error(file_error(name, "bad"));
    EXPECT_EQ(error.what(), std::string(expected) + ": bad");
    EXPECT_EQ(error.parts().file, expected);
    const InputFile file(std::span<const std::byte>(), name);
    EXPECT_EQ(file.name(), expected);
    EXPECT_EQ(file.address(), name);
  }
}

}  // namespace
}  // namespace alidade
