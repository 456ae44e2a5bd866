// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "geo/crs_library.h"
#include "geo/remote_file.h"

/// The functions with which python/module.cpp compares reference systems and reads their codes.
extern "C" [[gnu::visibility("default")]] const alidade::CrsLibrary* alidade_crs_library() {
  static constexpr alidade::CrsLibrary library{.compare = &alidade::geo::compare_systems,
                                               .wkt = &alidade::geo::library_wkt};
  return &library;
}

/// The function with which python/module.cpp opens remote files. The cache is that of the program. The
/// `is_interrupted` of the first call holds for the process.
extern "C" [[gnu::visibility("default")]] std::unique_ptr<alidade::RemoteFile> alidade_open_remote_file(
    const std::string& name, bool (*is_interrupted)(), const std::optional<std::vector<std::string>>& hosts) {
  static const char* const cache = std::getenv("ALIDADE_CACHE");
  return alidade::geo::open_remote_file(
      name, {.is_interrupted = is_interrupted, .cache = cache != nullptr ? cache : "", .hosts = hosts});
}
