// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "jobs/remote_files.h"

namespace alidade::geo {

/// A file that is about to be fetched whole.
struct WholeFetch {
  std::string name;
  std::uint64_t bytes = 0;       ///< to be fetched: without those of an earlier run
  std::filesystem::path folder;  ///< where it will be
  bool is_kept = false;          ///< for later runs
  std::string keeping{};         ///< whether it is kept, or what would keep it, in words
};

struct RemoteOptions {
  bool (*is_interrupted)() = nullptr;  ///< called while waiting; returns whether to stop
  /// A folder that keeps fetched bytes for later runs; empty: none. Of servers that state no ETag
  /// and no time of modification, nothing is kept.
  std::filesystem::path cache{};
  std::uint64_t cache_bytes = std::uint64_t{1} << 30;  ///< that the folder may take
  /// Where requests for the file may be redirected to (http, https), beside its own host; empty: anywhere.
  std::optional<std::vector<std::string>> hosts{};
  /// Called before a file is fetched whole (RemoteFile::map()); throws if it must not be.
  std::function<void(const WholeFetch&)> permit{};
};

/// Opens a file of a name for which is_remote_name() holds. Of a file on a web server (http, https) only the
/// ranges that are read are fetched, and kept in memory (at most 64 MiB of all files); its errors are in
/// http_source.h. Buckets and archives are reached through GDAL's virtual files, which read ranges, too:
/// their version is the size and the time of modification as GDAL saw them first, and no cache keeps them. A
/// server that sends less than 4 kB/s over 30 seconds has failed. RemoteFile::map() keeps the file in the
/// cache if it has room and the server states a version, where later runs find it or continue, else in
/// temporary_folder() until the map is gone. GDAL's configuration options (GDAL_HTTP_*, AWS_*,
/// CPL_VSIL_CURL_*) are taken from the environment. What ends in .json.gz is decompressed. Errors: the file
/// is missing, the server does not answer, or its answers contradict each other. Cancelled, if is_interrupted
/// returns true. The options, but for `hosts` and `permit`, are those of the first call in a process; `hosts`
/// are those of the first for a file.
std::unique_ptr<RemoteFile> open_remote_file(const std::string& name, const RemoteOptions& options = {});

using jobs::RemoteTraffic;
/// Of this process so far.
RemoteTraffic remote_traffic();

}  // namespace alidade::geo
