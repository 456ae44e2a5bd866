// SPDX-License-Identifier: MIT
#include "base/checkpoint.h"

#include <gtest/gtest.h>
#include <filesystem>

#include <fstream>
#include <iterator>

namespace alidade::test {
namespace {

constexpr std::uint64_t k_count = 5;

/// A run of five parts; the answers of part i are i + 1 numbers.
class PartCheckpointTest : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() /
            (std::string("parts_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove(file_);
  }
  void TearDown() override { std::filesystem::remove(file_); }

  PartsOptions options(bool resume) const { return {.file = file_, .interval = 1e-3, .resume = resume}; }
  static Fingerprint fingerprint() { return {{"command", "count"}, {"--step", "2"}}; }

  /// Computes parts [found, end) and returns all answers so far.
  std::vector<int> run(PartCheckpoint* parts, std::uint64_t end = k_count) {
    std::vector<int> all;
    try {
      run_parts(
          parts, k_count,
          [&](std::uint64_t part, PartWriter& writer) {
            if (part >= end) throw Cancelled();
            ++computed_;
            writer.put(std::uint64_t{part + 1});
            writer.put_all(std::vector<int>(part + 1, static_cast<int>(10 * part)));
          },
          [&](std::uint64_t, PartReader& reader) {
            std::vector<int> answers(reader.take_count(sizeof(int)));
            reader.take_all(answers);
            all.insert(all.end(), answers.begin(), answers.end());
          });
    } catch (const Cancelled&) {
    }
    return all;
  }
  /// A file with the first three parts.
  void write_three() {
    PartCheckpoint parts(options(false), fingerprint());
    run(&parts, 3);
    computed_ = 0;
  }
  std::string read() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& content) const { std::ofstream(file_, std::ios::binary) << content; }
  std::string message_of_resuming(const Fingerprint& asked) const {
    try {
      PartCheckpoint parts(options(true), asked);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path file_;
  int computed_ = 0;
};

TEST_F(PartCheckpointTest, file_belongs_to_one_run_at_a_time) {
  write_three();
  const std::string before = read();
  {
    PartCheckpoint first(options(true), fingerprint());
    EXPECT_THROW(PartCheckpoint(options(true), fingerprint()), Error);
    EXPECT_EQ(read(), before);
  }
  PartCheckpoint next(options(true), fingerprint());
  EXPECT_EQ(next.finished(), 3u);
}

TEST_F(PartCheckpointTest, run_that_was_cut_off_computes_the_others_only_and_answers_the_same) {
  const std::vector<int> whole = run(nullptr);
  EXPECT_EQ(whole.size(), 15u);
  write_three();
  PartCheckpoint parts(options(true), fingerprint());
  EXPECT_TRUE(parts.is_kept());
  EXPECT_EQ(parts.finished(), 3u);
  EXPECT_EQ(parts.count(), k_count);
  EXPECT_FALSE(parts.has_begun());
  EXPECT_EQ(run(&parts), whole);
  EXPECT_EQ(computed_, 2);
  EXPECT_TRUE(parts.has_begun());
  parts.remove();
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(PartCheckpointTest, without_resume_the_file_begins_again) {
  write_three();
  PartCheckpoint parts(options(false), {{"command", "another"}});
  EXPECT_FALSE(parts.is_kept());
  EXPECT_EQ(run(&parts), run(nullptr));
  EXPECT_EQ(computed_, 10);
}

TEST_F(PartCheckpointTest, cut_anywhere_in_the_records_it_resumes_from_the_intact_ones) {
  const std::vector<int> whole = run(nullptr);
  write_three();
  const std::string content = read();
  std::size_t head = 0;
  {
    std::filesystem::remove(file_);
    PartCheckpoint parts(options(false), fingerprint());
    parts.start(k_count);
    head = read().size();
  }
  for (std::size_t size = head; size <= content.size(); ++size) {
    write(content.substr(0, size));
    computed_ = 0;
    PartCheckpoint parts(options(true), fingerprint());
    EXPECT_EQ(run(&parts), whole) << size;
    // Records are 32 + 8 + 4 (part + 1) bytes.
    const std::size_t kept = size - head;
    EXPECT_EQ(computed_, kept < 44 ? 5 : kept < 44 + 48 ? 4 : kept < 44 + 48 + 52 ? 3 : 2) << size;
  }
  for (std::size_t size = 0; size < head; ++size) {
    write(content.substr(0, size));
    EXPECT_NE(message_of_resuming(fingerprint()), "no error") << size;
  }
}

TEST_F(PartCheckpointTest, every_damaged_byte_is_an_error_that_names_file_and_offset) {
  write_three();
  const std::string content = read();
  for (std::size_t offset = 0; offset < content.size(); ++offset) {
    std::string damaged = content;
    damaged[offset] = static_cast<char>(damaged[offset] ^ 4);
    write(damaged);
    const std::string message = message_of_resuming(fingerprint());
    EXPECT_EQ(message.find(file_.string() + ":byte "), 0u) << offset << ": " << message;
    EXPECT_EQ(read(), damaged);
  }
}

TEST_F(PartCheckpointTest, another_run_is_rejected_and_the_difference_is_reported) {
  write_three();
  const std::string message = message_of_resuming({{"command", "count"}, {"--step", "3"}});
  EXPECT_NE(
      message.find("this checkpoint belongs to another run: it has --step 2, this run has 3; expected the "
                   "same cloud and options, or no --resume"),
      std::string::npos)
      << message;
  write("ALIDPART and so on");
  EXPECT_NE(message_of_resuming(fingerprint()).find("not a visibility checkpoint"), std::string::npos);
  EXPECT_FALSE(is_parts_file(file_));
}

TEST_F(PartCheckpointTest, another_number_of_parts_is_an_error) {
  write_three();
  PartCheckpoint parts(options(true), fingerprint());
  EXPECT_THROW(parts.start(k_count + 1), Error);
}

TEST_F(PartCheckpointTest, answers_of_another_length_are_an_error) {
  const std::vector<std::byte> bytes(12);
  PartReader reader(bytes, "file", 7);
  EXPECT_EQ(reader.take<int>(), 0);
  EXPECT_THROW(reader.finish(), Error);
  std::vector<double> too_many(2);
  EXPECT_THROW(reader.take_all(too_many), Error);
  const std::vector<std::byte> endless(8, std::byte{0xFF});
  PartReader count(endless, "file", 7);
  try {
    count.take_count(4);
    FAIL() << "takes memory for what is not there";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "file: corrupt checkpoint: part 7 cannot be read");
  }
}

TEST_F(PartCheckpointTest, file_that_cannot_be_written_is_an_error_at_the_start) {
  PartsOptions absent = options(false);
  absent.file = file_ / "absent" / "parts";
  PartCheckpoint parts(absent, fingerprint());
  EXPECT_THROW(parts.start(k_count), Error);
}

}  // namespace
}  // namespace alidade::test
