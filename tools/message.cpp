// SPDX-License-Identifier: MIT
#include "tools/message.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "octree/error.h"
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
  const bool written =
      std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (written) return;
  if (errno == EPIPE) throw ReaderGone();
  if (interrupted()) throw Cancelled();
  throw Error({.file = "standard output", .problem = "cannot write", .found = std::strerror(errno)});
}

}  // namespace alidade
