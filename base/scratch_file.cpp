// SPDX-License-Identifier: MIT
#include "base/scratch_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace alidade {
namespace {

[[noreturn]] void fail_in(const std::filesystem::path& folder, const char* problem, int number = errno) {
  Error::Parts parts =
      system_error((folder.empty() ? std::filesystem::path(".") : folder).string(), problem, number).parts();
  if (number == ENOSPC || number == EDQUOT) parts.expected = "more free space there, or another folder";
  throw Error(std::move(parts));
}

constexpr const char* k_no_write = "cannot write a temporary file in this folder";

int open_scratch(const std::filesystem::path& folder) {
  // A program that is killed between making and removing a name would leave it.
  const int nameless =
      ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (nameless >= 0) return nameless;
  // Some file systems do not support files without a name.
  std::string name = (folder / ".alidade-XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) fail_in(folder, "cannot create a temporary file in this folder");
  ::unlink(name.c_str());
  return descriptor;
}

/// Without this, pages for which the disk has no room would end the program when they are written.
int reserve(int descriptor, std::uint64_t offset, std::uint64_t count) {
  int number = 0;
  do {
    number = ::posix_fallocate(descriptor, static_cast<::off_t>(offset), static_cast<::off_t>(count));
  } while (number == EINTR);
  return number;
}

/// Calls madvise() for the pages that lie completely in these bytes, and returns its result.
int advise(std::span<const std::byte> bytes, int advice) noexcept {
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = (reinterpret_cast<std::uintptr_t>(bytes.data()) + page - 1) / page * page;
  const auto end = (reinterpret_cast<std::uintptr_t>(bytes.data()) + bytes.size()) / page * page;
  return begin < end ? ::madvise(reinterpret_cast<void*>(begin), end - begin, advice) : 0;
}

}  // namespace

std::filesystem::path temporary_folder() {
  std::error_code error;
  std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (!error) return folder;
  const char* const given = std::getenv("TMPDIR");
  throw file_error(given ? given : "/tmp", "no folder for temporary files",
                   "the environment variable TMPDIR to name a folder", error.message());
}

ScratchFile::~ScratchFile() {
  if (mapped_) ::munmap(mapped_, size_);
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : folder_(std::move(other.folder_)),
      descriptor_(std::move(other.descriptor_)),
      size_(std::exchange(other.size_, 0)),
      mapped_(std::exchange(other.mapped_, nullptr)) {}

ScratchFile& ScratchFile::operator=(ScratchFile&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  std::swap(mapped_, other.mapped_);
  return *this;
}

void ScratchFile::fail(const char* problem) const {
  fail_in(folder_, problem);
}

void ScratchFile::fail_to_write() const {
  fail(k_no_write);
}

void ScratchFile::open() {
  if (!descriptor_.is_open()) descriptor_ = FileDescriptor(open_scratch(folder_));
}

void ScratchFile::append(std::span<const std::byte> bytes) {
  open();
  while (!bytes.empty()) {
    const ::ssize_t count =
        ::pwrite(descriptor_.number(), bytes.data(), bytes.size(), static_cast<::off_t>(size_));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_to_write();
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    size_ += static_cast<std::uint64_t>(count);
  }
}

void ScratchFile::append_zeros(std::uint64_t count) {
  if (count == 0) return;
  open();
  if (const int number = reserve(descriptor_.number(), size_, count)) fail_in(folder_, k_no_write, number);
  size_ += count;
}

void ScratchFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  if (descriptor_.read_at(offset, into) < into.size()) fail("cannot read a temporary file in this folder");
}

void ScratchFile::cut(std::uint64_t kept) {
  assert(kept <= size_ && !mapped_);
  if (kept == size_) return;
  if (::ftruncate(descriptor_.number(), static_cast<::off_t>(kept)) != 0) fail_to_write();
  size_ = kept;
}

std::span<std::byte> ScratchFile::map() {
  return map(PROT_READ | PROT_WRITE, MAP_SHARED);
}

std::span<std::byte> ScratchFile::map(int protection, int flags) {
  if (size_ == 0) return {};
  if (!mapped_) {
    void* const mapped = ::mmap(nullptr, size_, protection, flags, descriptor_.number(), 0);
    if (mapped == MAP_FAILED) fail("cannot map a temporary file in this folder");
    mapped_ = static_cast<std::byte*>(mapped);
  }
  return {mapped_, static_cast<std::size_t>(size_)};
}

void* map_scratch_pages(std::size_t byte_count, const std::filesystem::path& folder) {
  const int descriptor = open_scratch(folder);
  const int number = reserve(descriptor, 0, byte_count);
  void* const mapped = number != 0
                           ? MAP_FAILED
                           : ::mmap(nullptr, byte_count, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  const int problem = number != 0 ? number : errno;
  ::close(descriptor);
  if (mapped == MAP_FAILED) fail_in(folder, k_no_write, problem);
  return mapped;
}

void expect_random_reads(std::span<const std::byte> bytes) noexcept {
  advise(bytes, MADV_RANDOM);
}

void discard_scratch_pages(std::span<const std::byte> bytes) noexcept {
  if (advise(bytes, MADV_REMOVE) != 0) advise(bytes, MADV_DONTNEED);
}

}  // namespace alidade
