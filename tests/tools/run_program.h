// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace alidade::test {

/// The words of a command line.
using Words = std::vector<std::string>;

inline Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// How the program ended and what it printed.
struct ProgramResult {
  int exit_code = -1;  ///< -1 if a signal ended it
  int signal = 0;
  std::string out, err;
};

/// The running program. It is killed if this object goes away first, and ends with SIGXCPU when it
/// takes 30 seconds of processor time (300 under a sanitizer).
class Program {
 public:
  /// Starts `alidade WORDS...` in `folder`; stdout goes to `standard_output` if one is given, stdin is
  /// `standard_input` or else empty, stderr goes to `standard_error` if one is given. No file can have more
  /// bytes than `largest_file`, as on a full disk.
  Program(const std::vector<std::string>& words, const std::filesystem::path& folder,
          const std::filesystem::path& standard_output = {},
          const std::filesystem::path& standard_input = "/dev/null",
          const std::filesystem::path& standard_error = {}, std::optional<std::uint64_t> largest_file = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Waits until the program handles the signal, which before that would just end it (not for SIGKILL).
  void send(int signal) const;
  bool running() const;
  /// What it has written to stderr by now.
  std::string errors_so_far() const;
  ProgramResult wait();

 private:
  pid_t process_ = -1;
  std::filesystem::path out_, err_;
  bool keep_out_ = false;
};

/// A test with an empty folder of its own, in which the program runs.
class ProgramTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  ProgramResult run(const std::vector<std::string>& words, const std::filesystem::path& standard_output = {});
  /// run() on a disk that is full when a file has so many bytes. The messages of the program must be shorter.
  ProgramResult run_on_full_disk(const std::vector<std::string>& words, std::uint64_t largest_file);
  /// run() with `input` on stdin.
  ProgramResult run_with_input(const std::vector<std::string>& words, const std::string& input);

  /// Writes a file into the folder.
  void write(const std::string& name, const std::string& content);
  std::string read(const std::string& name) const;
  /// Names of all files in the folder, sorted.
  std::vector<std::string> names() const;
  /// A small cloud as text: a square of 20 by 20 points, 0.1 apart, the corner at (100, 200, 5).
  void write_square(const std::string& name);

  std::filesystem::path folder;
};

/// What another program prints to stdout, started by a shell in a folder; empty if it fails or is missing.
std::string shell_output(const std::string& command, const std::filesystem::path& folder);

/// The built program.
std::filesystem::path program_file();

/// `../shared/data/NAME` beside the repository; empty if it is not there.
std::optional<std::filesystem::path> shared_data(const std::string& name);

}  // namespace alidade::test
