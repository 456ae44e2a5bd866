// SPDX-License-Identifier: MIT
#include "tools/message.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "base/error.h"
#include "tools/interrupt.h"

namespace alidade {
namespace {

void say(std::string_view kind, std::string_view text) {
  std::string line = "alidade: ";
  line.append(kind).append(text).append("\n");
  write_to_stderr(line);
}

}  // namespace

void write_to_stderr(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void say_error(std::string_view text) {
  say("error: ", text);
}
void say_warning(std::string_view text) {
  say("warning: ", text);
}
void say_note(std::string_view text) {
  say("", text);
}

void write_to_stdout(std::string_view text) {
  // Not by stdio, which goes on waiting for the reader whatever signal has come.
  while (!text.empty()) {
    if (interrupted()) throw Cancelled();
    const ::ssize_t count = ::write(STDOUT_FILENO, text.data(), text.size());
    if (count >= 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno == EPIPE) {
      throw ReaderGone();
    } else if (errno != EINTR) {
      throw Error({.file = "standard output", .problem = "cannot write", .found = std::strerror(errno)});
    }
  }
}

}  // namespace alidade
