// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "geo/crs_library.h"
#include "geo/remote_file.h"

/// What it compares reference systems with, and reads their codes.
extern "C" [[gnu::visibility("default")]] const alidade::CrsLibrary* alidade_crs_library() {
  static constexpr alidade::CrsLibrary library{.compare = &alidade::geo::compare_systems,
                                               .wkt = &alidade::geo::whole_wkt};
  return &library;
}

/// What the module alidade opens remote files with (python/module.cpp). The cache is as for the program; the first
/// `is_interrupted` is that of the process.
extern "C" [[gnu::visibility("default")]] std::unique_ptr<alidade::RemoteFile> alidade_open_remote_file(
    const std::string& name, bool (*is_interrupted)(), const std::optional<std::vector<std::string>>& hosts) {
  static const char* const cache = std::getenv("ALIDADE_CACHE");
  return alidade::geo::open_remote_file(
      name, {.is_interrupted = is_interrupted, .cache = cache != nullptr ? cache : "", .hosts = hosts});
}
