// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "base/scratch_file.h"

namespace alidade {

/// A scratch file that may have a name, and then stays.
class KeptFile : private ScratchFile {
 public:
  /// A ScratchFile in this folder.
  using ScratchFile::ScratchFile;
  /// A file with a name; it is made if it is missing, and cut to its first `kept` bytes. Links are not
  /// followed. Errors: it has fewer; it cannot be written.
  KeptFile(const std::filesystem::path& path, std::uint64_t kept);

  using ScratchFile::append_zeros;
  using ScratchFile::read;
  using ScratchFile::size;
  void append(std::span<const std::byte> bytes);
  void cut(std::uint64_t kept);

  /// Waits until the bytes are on the disk. Errors: they cannot be written.
  void sync() const;
  /// Checksum of all bytes of a file with a name, however they were appended. Cost: at most 1 MiB is read of
  /// the bytes that this object has appended, and all others. `is_interrupted`, if given, is called for every
  /// MiB of these and returns whether to stop. Errors: as read(). Cancelled.
  std::uint64_t checksum(const std::function<bool()>& is_interrupted = {});

  /// ScratchFile::map(). The map of a file with a name is read-only, and discarding its bytes does not remove
  /// them from the file.
  std::span<std::byte> map();

 private:
  void sum_blocks(const std::function<bool()>& is_interrupted = {});
  std::uint64_t sum_of(std::uint64_t offset, std::uint64_t count) const;

  bool is_named_ = false;
  std::vector<std::uint64_t> sums_;  ///< of the whole blocks of one with a name
};

}  // namespace alidade
