// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "base/input_file.h"

namespace alidade {

/// A file's bytes in memory without reading them: the system fetches pages when they are looked at, and
/// programs that map one file share them. Copies share the map. Read only; safe to use from many threads.
///
/// Whoever makes a mapped file shorter, or pulls out its disk, ends the program that looks at the missing
/// pages (SIGBUS): no check can rule that out. Replacing the file by renaming, as OutputFile does, leaves
/// maps as they were.
class MappedFile {
 public:
  /// Maps the file that `file` names; a file in memory is copied. Cost: constant for a file on disk. Errors:
  /// it is missing, unreadable or not a regular file.
  explicit MappedFile(const InputFile& file);

  /// Path as the caller gave it; what error messages call the file.
  const std::string& name() const { return name_; }
  /// All bytes; they begin at a multiple of 4096.
  std::span<const std::byte> bytes() const { return bytes_; }
  /// What keeps the bytes alive.
  const std::shared_ptr<const void>& storage() const { return storage_; }

 private:
  std::string name_;
  std::span<const std::byte> bytes_;
  std::shared_ptr<const void> storage_;
};

}  // namespace alidade
