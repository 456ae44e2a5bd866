// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace alidade {

/// The bytes of a file on this machine in memory, read only. The system fetches pages on first access; maps
/// of one file share them. Safe to use from many threads.
///
/// If another program makes the file shorter, or its disk fails, the pages that are missing become zeros and
/// the map has failed, for good, as one of a remote file (base/remote_map.h): RemoteMap::check() throws its
/// Error as long as it lives. A file that was replaced by renaming, as OutputFile does, leaves
/// its map as it was.
///
/// The first map of a process installs a handler for SIGBUS, in programs that load the library, too.
/// Signals for other memory go to the handler that was there before. Limits: a handler that is installed
/// later and does not call the one before it ends the program, and so does a thread that blocks SIGBUS.
/// Only check_all() finds what another program writes into the file while it is mapped, or cuts off
/// within the last page.
class LocalMap {
 public:
  /// Maps the file at `path`; `name` is its name in messages. Errors: it is missing, not a regular file, or
  /// cannot be mapped.
  static std::shared_ptr<const LocalMap> open(const std::string& path, const std::string& name);

  virtual ~LocalMap() = default;
  virtual std::span<const std::byte> bytes() const = 0;

  /// Errors: that of the map an address lies in, if it has failed. Cost: nothing while no map has.
  static void check(const void* address) {
    if (failures_ > 0) check_map(address);
  }
  /// Errors: that of a map that has failed and still lives; the size of a mapped file, or the time of its
  /// last change, differs from that when it was mapped. Cost: a microsecond per map.
  static void check_all();

 protected:
  static inline std::atomic<int> failures_ = 0;  ///< maps that have failed and still live

 private:
  static void check_map(const void* address);
};

}  // namespace alidade
