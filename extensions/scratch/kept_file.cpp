// SPDX-License-Identifier: MIT
#include "extensions/scratch/kept_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cassert>
#include <string>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/progress.h"

namespace alidade {

KeptFile::KeptFile(const std::filesystem::path& path, std::uint64_t kept)
    : ScratchFile(path.parent_path()), is_named_(true) {
  descriptor_ =
      FileDescriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (!descriptor_.is_open()) throw system_error(path.string(), "cannot write the file");
  size_ = kept;
  const std::uint64_t size = descriptor_.size_of_regular(path.string());
  if (size < kept)
    throw file_error(path, "corrupt checkpoint: truncated file", fmt::format("at least {} bytes", kept),
                     std::to_string(size));
  if (::ftruncate(descriptor_.number(), static_cast<::off_t>(kept)) != 0)
    throw system_error(path.string(), "cannot write the file");
}

void KeptFile::append(std::span<const std::byte> bytes) {
  ScratchFile::append(bytes);
  sum_blocks();
}

void KeptFile::cut(std::uint64_t kept) {
  ScratchFile::cut(kept);
  sums_.resize(std::min<std::size_t>(sums_.size(), size_ / k_checksum_block));
}

std::uint64_t KeptFile::sum_of(std::uint64_t offset, std::uint64_t count) const {
  std::vector<std::byte> bytes(count);
  read(offset, bytes);
  return alidade::checksum(bytes);
}

/// Called soon after blocks were written, as long as the system has them in memory.
void KeptFile::sum_blocks(const std::function<bool()>& is_interrupted) {
  if (!is_named_) return;
  while (sums_.size() < size_ / k_checksum_block) {
    if (is_interrupted && is_interrupted()) throw Cancelled();
    sums_.push_back(sum_of(sums_.size() * k_checksum_block, k_checksum_block));
  }
}

std::uint64_t KeptFile::checksum(const std::function<bool()>& is_interrupted) {
  assert(is_named_);
  sum_blocks(is_interrupted);
  std::vector<std::uint64_t> sums = sums_;
  const std::uint64_t rest = sums.size() * k_checksum_block;
  sums.push_back(sum_of(rest, size_ - rest));
  return alidade::checksum(std::as_bytes(std::span(sums)));
}

void KeptFile::sync() const {
  if (descriptor_.is_open() && ::fdatasync(descriptor_.number()) != 0) fail_to_write();
}

std::span<std::byte> KeptFile::map() {
  // The system might have to hold every page of a private map that can be written: it does not map one larger
  // than memory. Of a shared one, discard_scratch_pages() would remove the bytes.
  return is_named_ ? ScratchFile::map(PROT_READ, MAP_PRIVATE) : ScratchFile::map();
}

}  // namespace alidade
