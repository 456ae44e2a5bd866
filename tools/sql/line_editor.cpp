// SPDX-License-Identifier: MIT
#include "tools/sql/line_editor.h"

#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "tools/interrupt.h"
#include "tools/message.h"

namespace alidade {
namespace {

constexpr int k_kept_lines = 1000;

/// The next byte of stdin; EOF at its end and when the program is interrupted.
int read_byte() {
  while (!interrupted()) {
    unsigned char byte = 0;
    const ::ssize_t count = ::read(STDIN_FILENO, &byte, 1);
    if (count == 1) return byte;
    if (count == 0 || errno != EINTR) break;
  }
  return EOF;
}

/// The next letter, which libedit takes as its code in Unicode. Left to itself it would wait on after Ctrl-C.
/// Bytes that are no UTF-8 are U+FFFD, or nothing if a key comes where the letter should go on.
int read_letter(FILE*) {
  constexpr int k_no_letter = 0xfffd;
  int code = 0, missing = 0;
  while (true) {
    const int byte = read_byte();
    if (byte == EOF || byte < 0x80) return byte;
    if (byte >= 0xf8) return k_no_letter;
    if (byte >= 0xc0) {
      missing = byte >= 0xf0 ? 3 : byte >= 0xe0 ? 2 : 1;
      code = byte & (0x3f >> missing);
      continue;
    }
    if (missing == 0) return k_no_letter;
    code = code << 6 | (byte & 0x3f);
    if (--missing > 0) continue;
    const bool is_letter = code >= 0x80 && code <= 0x10ffff && (code < 0xd800 || code > 0xdfff);
    return is_letter ? code : k_no_letter;
  }
}

std::optional<std::string> read_plain_line(const std::string& prompt) {
  write_to_stdout(prompt);
  std::string line;
  for (int byte = read_byte(); byte != '\n'; byte = read_byte()) {
    if (byte == EOF) return std::nullopt;
    line += static_cast<char>(byte);
  }
  return line;
}

}  // namespace

/// The part of libedit that has readline's names.
struct LineEditor::Library {
  char* (*read_line)(const char*) = nullptr;
  int (*add_history)(const char*) = nullptr;
  int (*read_history)(const char*) = nullptr;
  int (*write_history)(const char*) = nullptr;
  void (*stifle_history)(int) = nullptr;

  /// Nothing if it is not there or another library than expected.
  static std::unique_ptr<Library> load() {
    void* const handle = ::dlopen("libedit.so.2", RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return nullptr;
    auto library = std::make_unique<Library>();
    const auto find = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(handle, name));
      return function != nullptr;
    };
    int* catches_signals = nullptr;
    int (**next_letter)(FILE*) = nullptr;
    if (!find(library->read_line, "readline") || !find(library->add_history, "add_history") ||
        !find(library->read_history, "read_history") || !find(library->write_history, "write_history") ||
        !find(library->stifle_history, "stifle_history") || !find(catches_signals, "rl_catch_signals") ||
        !find(next_letter, "rl_getc_function"))
      return nullptr;
    // Letters beyond ASCII are edited only where the locale has them.
    if (std::setlocale(LC_CTYPE, "") == nullptr || MB_CUR_MAX == 1) std::setlocale(LC_CTYPE, "C.UTF-8");
    *catches_signals = 0;
    *next_letter = read_letter;
    return library;
  }
};

std::filesystem::path sql_history_file() {
  const auto folder = [](const char* variable) {
    const char* const value = std::getenv(variable);
    return std::filesystem::path(value == nullptr ? "" : value);
  };
  if (const std::filesystem::path state = folder("XDG_STATE_HOME"); state.is_absolute())
    return state / "alidade" / "sql_history";
  const std::filesystem::path home = folder("HOME");
  return home.empty() ? home : home / ".local" / "state" / "alidade" / "sql_history";
}

LineEditor::LineEditor(std::filesystem::path history)
    : history_(std::move(history)), library_(Library::load()) {
  if (library_ == nullptr) return;
  library_->stifle_history(k_kept_lines);
  if (!history_.empty()) library_->read_history(history_.c_str());
}

LineEditor::~LineEditor() {
  if (library_ == nullptr || history_.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(history_.parent_path(), error);
  // Nobody else's to read.
  const ::mode_t before = ::umask(0077);
  library_->write_history(history_.c_str());
  ::umask(before);
}

std::optional<std::string> LineEditor::read(const std::string& prompt) {
  if (library_ == nullptr) return read_plain_line(prompt);
  char* const typed = library_->read_line(prompt.c_str());
  if (typed == nullptr) return std::nullopt;
  std::string line = typed;
  std::free(typed);
  if (interrupted()) return std::nullopt;
  if (!line.empty()) library_->add_history(line.c_str());
  return line;
}

}  // namespace alidade
