// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/local_map.h"

namespace alidade {

/// The bytes of a remote file in memory. Each page is fetched when a thread first touches it, and the thread
/// waits for it (userfaultfd(2)). Fetched pages stay in memory until the map is destroyed. Read only; safe to
/// use from many threads.
///
/// Touching memory cannot report an error. If the network fails, the bytes received are damaged, or all maps
/// together would hold too much, the missing pages become zeros and the map has failed permanently: check()
/// throws the map's Error until the map is destroyed. Code that reads the bytes calls check() before it uses
/// the result. OutputFile and standard output call check_all(): while a failed map exists, nothing is
/// written.
///
/// System calls do not wait for pages: they fail on those that no thread has touched. After fork(2), the
/// child has no threads that fetch: all maps have failed there.
class RemoteMap {
 public:
  /// Begin and end of the part of the file that is fetched together with the byte at `offset`. It begins at a
  /// multiple of 4096, and ends at one or at the file's end.
  using BlockOf = std::function<std::pair<std::uint64_t, std::uint64_t>(std::uint64_t offset)>;
  /// Checks the bytes of the block that begins at `offset`. Errors: they are damaged.
  using CheckBlock = std::function<void(std::uint64_t offset, std::span<const std::byte> bytes)>;

  /// Opens the file. The map fails once all maps together would hold over `most_bytes` more than they hold
  /// now; the default is half of available_memory(). Null if the system does not permit it: Linux before
  /// 5.11, and some containers. Errors: those of open_remote_file(); the file claims to have 64 TiB or more.
  static std::shared_ptr<RemoteMap> open(const std::string& name,
                                         std::optional<std::uint64_t> most_bytes = {});
  /// The map that contains an address; null if no map does.
  static std::shared_ptr<RemoteMap> find(const void* address);

  virtual ~RemoteMap() = default;
  virtual std::span<const std::byte> bytes() const = 0;
  /// From this call on, whole blocks are fetched and checked; until then, pages are. Pages that were fetched
  /// before are not checked.
  virtual void set_blocks(BlockOf block_of, CheckBlock check) = 0;
  /// Fetches the missing blocks of a part of bytes(), in requests that end with the block that reaches 8 MiB.
  /// An error fails the map.
  virtual void fetch(std::span<const std::byte> bytes) noexcept = 0;

  /// Reads a byte of each page, so that all are fetched. For memory of any kind; cost: one read per 4096
  /// bytes.
  static void touch(std::span<const std::byte> bytes);

  /// Errors: that of the map, remote or local (base/local_map.h), that contains the address, if it has
  /// failed. Cancelled. Cost: nothing while no map has failed.
  static void check(const void* address) {
    if (failures_ > 0) check_map(address);
    LocalMap::check(address);
  }
  /// Errors: that of any failed map; those of LocalMap::check_all(). Cancelled.
  static void check_all() {
    if (failures_ > 0) check_all_maps();
    LocalMap::check_all();
  }

 protected:
  static inline std::atomic<int> failures_ = 0;  ///< failed maps that are not destroyed yet

 private:
  static void check_map(const void* address);
  static void check_all_maps();
};

}  // namespace alidade
