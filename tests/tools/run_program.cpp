// SPDX-License-Identifier: MIT
#include "tests/tools/run_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <filesystem>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

namespace alidade::test {
namespace {

/// Processor time of one run in seconds, far beyond what any test needs: a hang ends with SIGXCPU.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr rlim_t k_most_seconds = 300;
#else
constexpr rlim_t k_most_seconds = 30;
#endif

std::string read_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  return content.str();
}

void redirect(const std::filesystem::path& path, int flags, int descriptor) {
  const int file = ::open(path.c_str(), flags, 0600);
  if (file < 0 || ::dup2(file, descriptor) < 0) ::_exit(125);
}

}  // namespace

Program::Program(const std::vector<std::string>& words, const std::filesystem::path& folder,
                 const std::filesystem::path& standard_output, const std::filesystem::path& standard_input,
                 const std::filesystem::path& standard_error, std::optional<std::uint64_t> largest_file) {
  // The program's messages are kept outside its folder, whose files the tests list.
  out_ = folder.string() + ".out";
  err_ = folder.string() + ".err";
  keep_out_ = !standard_output.empty();
  const std::filesystem::path out = keep_out_ ? standard_output : out_;
  std::vector<std::string> arguments = {program_file()};
  arguments.insert(arguments.end(), words.begin(), words.end());
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  process_ = ::fork();
  if (process_ != 0) return;
  const rlimit processor_time{k_most_seconds, k_most_seconds + 1};
  if (::setrlimit(RLIMIT_CPU, &processor_time) != 0) ::_exit(125);
  if (largest_file) {
    const rlimit file_size{*largest_file, *largest_file};
    // Writing further is an error then, and no signal.
    if (::signal(SIGXFSZ, SIG_IGN) == SIG_ERR || ::setrlimit(RLIMIT_FSIZE, &file_size) != 0) ::_exit(125);
  }
  redirect(standard_input, O_RDONLY, STDIN_FILENO);
  redirect(out, keep_out_ ? O_WRONLY : O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
  if (standard_error.empty()) {
    redirect(err_, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
  } else {
    redirect(standard_error, O_WRONLY, STDERR_FILENO);
  }
  if (::chdir(folder.c_str()) != 0) ::_exit(125);
  ::execv(pointers[0], pointers.data());
  ::_exit(126);
}

namespace {

/// Whether a process has a handler for the signal, as proc(5) lists it under SigCgt.
bool catches(pid_t process, int signal) {
  std::ifstream status(fmt::format("/proc/{}/status", process));
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("SigCgt:")) return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1)) & 1;
  }
  return false;
}

}  // namespace

Program::~Program() {
  if (process_ <= 0) return;
  send(SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

void Program::send(int signal) const {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (signal != SIGKILL && running() && !catches(process_, signal) &&
         std::chrono::steady_clock::now() < limit)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  ::kill(process_, signal);
}

bool Program::running() const {
  siginfo_t information = {};
  return ::waitid(P_PID, static_cast<id_t>(process_), &information, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         information.si_pid == 0;
}

std::string Program::errors_so_far() const {
  return read_file(err_);
}

ProgramResult Program::wait() {
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = -1;
  ProgramResult result;
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  if (!keep_out_) result.out = read_file(out_);
  result.err = read_file(err_);
  return result;
}

void ProgramTest::SetUp() {
  const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
  folder = std::filesystem::temp_directory_path() /
           fmt::format("alidade_{}_{}_{}", test->test_suite_name(), test->name(), ::getpid());
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
}

void ProgramTest::TearDown() {
  for (const char* const suffix : {"", ".in", ".out", ".err"})
    std::filesystem::remove_all(folder.string() + suffix);
}

ProgramResult ProgramTest::run(const std::vector<std::string>& words,
                               const std::filesystem::path& standard_output) {
  return Program(words, folder, standard_output).wait();
}

ProgramResult ProgramTest::run_on_full_disk(const std::vector<std::string>& words,
                                            std::uint64_t largest_file) {
  return Program(words, folder, {}, "/dev/null", {}, largest_file).wait();
}

ProgramResult ProgramTest::run_with_input(const std::vector<std::string>& words, const std::string& input) {
  const std::filesystem::path file = folder.string() + ".in";
  std::ofstream(file, std::ios::binary) << input;
  return Program(words, folder, {}, file).wait();
}

void ProgramTest::write(const std::string& name, const std::string& content) {
  std::ofstream(folder / name, std::ios::binary) << content;
}

std::string ProgramTest::read(const std::string& name) const {
  return read_file(folder / name);
}

std::vector<std::string> ProgramTest::names() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

void ProgramTest::write_square(const std::string& name) {
  std::string text;
  for (int i = 0; i < 400; ++i)
    text += fmt::format("{:.1f} {:.1f} 5.0\n", 100.0 + 0.1 * (i % 20), 200.0 + 0.1 * (i / 20));
  write(name, text);
}

std::string shell_output(const std::string& command, const std::filesystem::path& folder) {
  const std::string line = "cd '" + folder.string() + "' && " + command + " 2> /dev/null";
  std::FILE* const pipe = ::popen(line.c_str(), "r");
  if (pipe == nullptr) return "";
  std::string output;
  char bytes[4096];
  for (std::size_t count = 0; (count = std::fread(bytes, 1, sizeof bytes, pipe)) > 0;)
    output.append(bytes, count);
  return ::pclose(pipe) == 0 ? output : "";
}

std::filesystem::path program_file() {
  return ALIDADE_PROGRAM;
}

std::optional<std::filesystem::path> shared_data(const std::string& name) {
  const std::filesystem::path path =
      std::filesystem::path(ALIDADE_SOURCE_FOLDER) / ".." / "shared" / "data" / name;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return std::filesystem::canonical(path);
}

}  // namespace alidade::test
