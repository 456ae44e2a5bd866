// SPDX-License-Identifier: MIT
#include "database/scratch_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include "base/error.h"

namespace alidade {

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void ScratchFile::fail(const char* problem) const {
  throw Error({.file = (folder_.empty() ? std::filesystem::path(".") : folder_).string(),
               .problem = problem,
               .found = std::strerror(errno)});
}

void ScratchFile::open() {
  std::string name = (folder_ / ".alidade-XXXXXX").string();
  descriptor_ = ::mkstemp(name.data());
  if (descriptor_ < 0) fail("no room can be made in this folder for what memory does not hold");
  ::unlink(name.c_str());
}

void ScratchFile::append(std::span<const std::byte> bytes) {
  if (descriptor_ < 0) open();
  while (!bytes.empty()) {
    const ::ssize_t count = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<::off_t>(size_));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("writing what memory does not hold into this folder failed");
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    size_ += static_cast<std::uint64_t>(count);
  }
}

void ScratchFile::read(std::uint64_t place, std::span<std::byte> into) const {
  while (!into.empty()) {
    const ::ssize_t count = ::pread(descriptor_, into.data(), into.size(), static_cast<::off_t>(place));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail("reading back what memory does not hold failed");
    into = into.subspan(static_cast<std::size_t>(count));
    place += static_cast<std::uint64_t>(count);
  }
}

}  // namespace alidade
