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
/// waits for it (userfaultfd(2)). What has arrived stays until the map ends. Read only; safe to use from many
/// threads.
///
/// Touching memory cannot fail. If the network fails, or what arrives is damaged, or all maps together would
/// hold too much, the pages that are missing become zeros and the map has failed, for good: check() throws
/// its Error as long as it lives. So code that reads the bytes calls check() before the result counts.
/// OutputFile and standard output call check_all(): while a failed map lives, nothing is written.
///
/// System calls do not wait for pages: they fail on those that no thread has touched. A process that forks
/// has no thread that fetches: there, all maps have failed.
class RemoteMap {
 public:
  /// The part of the file that arrives together with the byte at an offset: begins at a multiple of 4096, and
  /// ends at one or at the file's end.
  using BlockOf = std::function<std::pair<std::uint64_t, std::uint64_t>(std::uint64_t offset)>;
  /// Errors: the bytes, a block that begins at `offset`, are damaged.
  using CheckBlock = std::function<void(std::uint64_t offset, std::span<const std::byte> bytes)>;

  /// Opens the file. It fails when all maps together hold `most_bytes` more than now, by default half of
  /// available_memory(). Null if the system does not permit it: Linux before 5.11, and some containers.
  /// Errors: those of open_remote_file(); the file claims to have 64 TiB or more.
  static std::shared_ptr<RemoteMap> open(const std::string& name,
                                         std::optional<std::uint64_t> most_bytes = {});
  /// The map that contains an address; null if no map does.
  static std::shared_ptr<RemoteMap> find(const void* address);

  virtual ~RemoteMap() = default;
  virtual std::span<const std::byte> bytes() const = 0;
  /// From now on whole blocks are fetched, and checked; before, single pages. What has arrived stays
  /// unchecked.
  virtual void set_blocks(BlockOf block_of, CheckBlock check) = 0;
  /// Fetches what has not arrived of some bytes, in large requests.
  virtual void fetch(std::span<const std::byte> bytes) noexcept = 0;

  /// Reads a byte of each page, so that all have arrived. Costs as much for any memory.
  static void touch(std::span<const std::byte> bytes);

  /// Errors: that of the map an address lies in, if it has failed, also of a file on this machine. Cancelled.
  /// Cost: nothing while no map has.
  static void check(const void* address) {
    if (failures_ > 0) check_map(address);
    LocalMap::check(address);
  }
  /// Errors: that of a map that has failed and still lives; those of LocalMap::check_all(). Cancelled.
  static void check_all() {
    if (failures_ > 0) check_all_maps();
    LocalMap::check_all();
  }

 protected:
  static inline std::atomic<int> failures_ = 0;  ///< maps that have failed and still live

 private:
  static void check_map(const void* address);
  static void check_all_maps();
};

}  // namespace alidade
