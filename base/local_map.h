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
/// If another program truncates the file, or its disk fails, the missing pages become zeros and the map has
/// failed permanently, like one of a remote file (base/remote_map.h): RemoteMap::check() throws the map's
/// Error until the map is destroyed. Replacing the file by renaming, as OutputFile does, does not affect its
/// map.
///
/// The first map of a process installs a handler for SIGBUS, also in programs that load the library. Signals
/// for other memory go to the handler that was installed before. Limits: if a handler that is installed later
/// does not call this one, or a thread blocks SIGBUS, a missing page ends the program. Only check_all() finds
/// what another program writes into the file while it is mapped, or cuts off within the last page.
class LocalMap {
 public:
  /// Maps the file at `path`; `name` is its name in messages. Errors: it is missing, not a regular file, or
  /// cannot be mapped.
  static std::shared_ptr<const LocalMap> open(const std::string& path, const std::string& name);

  virtual ~LocalMap() = default;
  virtual std::span<const std::byte> bytes() const = 0;

  /// Errors: that of the map that contains the address, if it has failed. Cost: nothing while no map has
  /// failed.
  static void check(const void* address) {
    if (failures_ > 0) check_map(address);
  }
  /// Errors: that of any failed map; the size of a mapped file, or the time of its last change, is not the
  /// one it had when it was mapped. Cost: a microsecond per map.
  static void check_all();

 protected:
  static inline std::atomic<int> failures_ = 0;  ///< failed maps that are not destroyed yet

 private:
  static void check_map(const void* address);
};

}  // namespace alidade
