// SPDX-License-Identifier: MIT
#include "base/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "base/error.h"

namespace alidade {
namespace {

constexpr std::size_t k_buffer_size = 1 << 18;

[[noreturn]] void fail(const std::string& name) {
  throw system_error(name, "cannot write the file");
}

/// The file a symbolic link leads to, so that replacing it keeps the link.
std::filesystem::path resolve(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_symlink(path, error)) return path;
  const std::filesystem::path target = std::filesystem::weakly_canonical(path, error);
  return error ? path : target;
}

[[noreturn]] void fail_because_it_exists(const std::string& name) {
  throw Error({.file = name, .problem = "the file exists", .expected = "another name, or --overwrite"});
}

}  // namespace

void write_fully(const std::string& name, int descriptor, std::uint64_t offset,
                 std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ::ssize_t count = ::pwrite(descriptor, bytes.data(), bytes.size(), static_cast<::off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(name);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
}

void check_output(const std::filesystem::path& path, bool overwrite) {
  std::error_code error;
  if (path.filename().empty()) throw Error({.file = path.string(), .problem = "not a file name"});
  const std::filesystem::path folder = path.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, error)) {
    throw Error(
        {.file = path.string(), .problem = "cannot write the file: no such folder " + folder.string()});
  }
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_regular_file(status)) {
    throw Error({.file = path.string(), .problem = "cannot replace the file: not a regular file"});
  }
  if (!overwrite) fail_because_it_exists(path.string());
}

OutputFile::OutputFile(const std::filesystem::path& path, bool overwrite)
    : name_(path.string()), overwrite_(overwrite) {
  check_output(path, overwrite);
  path_ = resolve(path);
  for (int attempt = 0; descriptor_ < 0; ++attempt) {
    const std::string name = fmt::format(".{}.part-{}-{}{}", path_.stem().string(), ::getpid(), attempt,
                                         path_.extension().string());
    temporary_ = path_.parent_path() / name;
    descriptor_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno != EEXIST) fail(name_);
  }
  buffer_.reserve(k_buffer_size);
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!committed_) ::unlink(temporary_.c_str());
}

void OutputFile::flush() {
  write_fully(name_, descriptor_, size_ - buffer_.size(), buffer_);
  buffer_.clear();
}

void OutputFile::write(std::span<const std::byte> bytes) {
  if (buffer_.size() + bytes.size() > k_buffer_size) flush();
  if (bytes.size() > k_buffer_size) {
    write_fully(name_, descriptor_, size_, bytes);
  } else {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  size_ += bytes.size();
}

void OutputFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  assert(offset <= size_ && bytes.size() <= size_ - offset);
  flush();
  write_fully(name_, descriptor_, offset, bytes);
}

void OutputFile::commit() {
  assert(!committed_);
  flush();
  // Some file systems report a full disk only here.
  if (::fsync(descriptor_) != 0) fail(name_);
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) fail(name_);
  if (overwrite_) {
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(name_);
  } else if (::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) != 0) {
    if (errno == EEXIST) fail_because_it_exists(name_);
    // File systems without the atomic form: a check and a plain rename.
    if (errno != EINVAL && errno != ENOSYS) fail(name_);
    check_output(path_, false);
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(name_);
  }
  committed_ = true;
}

}  // namespace alidade
