// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "geo/remote_file.h"

/// What the module alidade opens remote files with (python/module.cpp). The cache is as for the program.
extern "C" [[gnu::visibility("default")]] std::unique_ptr<alidade::RemoteFile> alidade_open_remote_file(
    const std::string& name) {
  static const char* const cache = std::getenv("ALIDADE_CACHE");
  return alidade::geo::open_remote_file(name, {.cache = cache != nullptr ? cache : ""});
}
