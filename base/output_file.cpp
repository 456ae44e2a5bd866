// SPDX-License-Identifier: MIT
#include "base/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <map>
#include <mutex>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"

namespace alidade {
namespace {

constexpr std::size_t k_buffer_size = 1 << 18;

[[noreturn]] void fail(const std::string& name) {
  throw system_error(name, "cannot write the file");
}

/// Whether others can put links into the folder of a file.
bool is_in_shared_folder(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.parent_path();
  struct stat status {};
  if (::stat(folder.empty() ? "." : folder.c_str(), &status) != 0) return false;
  const bool is_of_others = status.st_uid != ::geteuid() && status.st_uid != 0;
  return is_of_others || (status.st_mode & (S_IWGRP | S_IWOTH)) != 0;
}

/// The file a symbolic link leads to, which need not exist, so that writing keeps the link. Errors: too
/// many links; `trusts_links` is false and a link is in a folder that others can write, who then choose
/// which file is written.
std::filesystem::path resolve(std::filesystem::path path, bool trusts_links) {
  constexpr int k_most_links = 40;  // as many as Linux follows
  std::error_code error;
  const std::string name = path.string();
  for (int i = 0; i < k_most_links && std::filesystem::is_symlink(path, error); ++i) {
    if (!trusts_links && is_in_shared_folder(path))
      throw file_error(name, "the output is a symbolic link in a folder that others can write",
                       "another name, or --overwrite");
    const std::filesystem::path target = std::filesystem::read_symlink(path, error);
    if (error) return path;
    path = path.parent_path() / target;
  }
  if (std::filesystem::is_symlink(path, error))
    throw system_error(path.string(), "cannot write the file", ELOOP);
  return path;
}

/// Beginning and end of the names of an output's temporary files. With the numbers between them they are
/// short enough for file systems, however long the output's own name is.
struct TemporaryName {
  std::string begin, end;

  explicit TemporaryName(const std::filesystem::path& path) {
    constexpr std::size_t k_longest = 255, k_numbers = 32;
    begin = "." + path.stem().string();
    end = path.extension().string();
    if (end.size() > k_longest / 4) end.clear();
    begin.resize(std::min(begin.size(), k_longest - k_numbers - end.size()));
    begin += ".part-";
  }
};

/// Temporary files that other processes had in a folder when this process first wrote there. A folder is
/// listed only once, so that writing thousands of frames to it takes no time that grows with their square.
const std::vector<std::filesystem::path>& temporaries_in(const std::filesystem::path& folder) {
  static std::mutex mutex;
  static std::map<std::filesystem::path, std::vector<std::filesystem::path>> known;
  std::error_code error;
  const std::lock_guard lock(mutex);
  const auto [found, is_new] =
      known.try_emplace(std::filesystem::absolute(folder.empty() ? "." : folder, error));
  if (is_new) {
    for (const auto& entry : std::filesystem::directory_iterator(found->first, error))
      if (entry.path().filename().string().find(".part-") != std::string::npos)
        found->second.push_back(entry.path());
  }
  return found->second;
}

/// Removes the temporary files of this output that no process has locked: numbers of processes are used
/// again, and on a shared file system a process of another machine may write the file.
void remove_stale(const std::filesystem::path& folder, const TemporaryName& like) {
  for (const std::filesystem::path& path : temporaries_in(folder)) {
    const std::string name = path.filename().string();
    if (name.size() <= like.begin.size() + like.end.size() || !name.starts_with(like.begin) ||
        !name.ends_with(like.end))
      continue;
    int process = 0, attempt = 0, read = 0;
    const std::string numbers =
        name.substr(like.begin.size(), name.size() - like.begin.size() - like.end.size());
    const bool is_ours = std::sscanf(numbers.c_str(), "%d-%d%n", &process, &attempt, &read) == 2 &&
                         static_cast<std::size_t>(read) == numbers.size() && process > 0;
    if (!is_ours) continue;
    // NFS locks only files that are open for writing.
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor < 0) continue;
    // Its process keeps it locked until it is renamed.
    struct stat locked {
    }, named{};
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && ::fstat(descriptor, &locked) == 0 &&
        ::lstat(path.c_str(), &named) == 0 && locked.st_dev == named.st_dev && locked.st_ino == named.st_ino)
      ::unlink(path.c_str());
    ::close(descriptor);
  }
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
    if (count < 0 && errno == EFAULT) {
      // Of a mapped file that became shorter. Reading them ends the process with a message that names it.
      for (std::size_t i = 0; i < bytes.size(); i += 4096)
        static_cast<void>(*static_cast<const volatile std::byte*>(&bytes[i]));
      errno = EFAULT;
    }
    if (count < 0) fail(name);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
}

void check_links(const std::filesystem::path& path) {
  resolve(path, false);
}

void check_output(const std::filesystem::path& path, bool overwrite) {
  std::error_code error;
  if (path.filename().empty()) throw Error({.file = path.string(), .problem = "not a file name"});
  const std::filesystem::path folder = path.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, error)) {
    throw Error(
        {.file = path.string(), .problem = "cannot write the file: no such folder " + folder.string()});
  }
  resolve(path, overwrite);
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_regular_file(status)) {
    throw Error({.file = path.string(), .problem = "cannot replace the file: not a regular file"});
  }
  if (!overwrite) fail_because_it_exists(path.string());
}

std::filesystem::path temporary_beside(const std::filesystem::path& path, int attempt) {
  const TemporaryName like(path);
  return path.parent_path() / fmt::format("{}{}-{}{}", like.begin, ::getpid(), attempt, like.end);
}

int create_temporary(const std::filesystem::path& output, const std::string& name,
                     std::filesystem::path& temporary) {
  remove_stale(output.parent_path(), TemporaryName(output));
  for (int attempt = 0;; ++attempt) {
    temporary = temporary_beside(output, attempt);
    const int descriptor = ::open(temporary.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno != EEXIST) fail(name);
    if (descriptor < 0) continue;
    // Another process may have taken it for stale before it was locked. Where locks are not supported, none
    // does.
    struct stat status {};
    const bool is_taken = ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!is_taken && ::fstat(descriptor, &status) == 0 && status.st_nlink > 0) return descriptor;
    ::close(descriptor);
  }
}

bool sync_temporary(int descriptor) {
  // Some file systems report a full disk only when a file is closed. Closing a copy keeps the lock.
  return ::fsync(descriptor) == 0 && ::close(::dup(descriptor)) == 0;
}

OutputFile::OutputFile(const std::filesystem::path& path, bool overwrite)
    : name_(path.string()), overwrite_(overwrite) {
  check_output(path, overwrite);
  path_ = resolve(path, overwrite);
  descriptor_ = create_temporary(path_, name_, temporary_);
  buffer_.reserve(k_buffer_size);
}

OutputFile::~OutputFile() {
  if (!committed_) ::unlink(temporary_.c_str());
  if (descriptor_ >= 0) ::close(descriptor_);
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
  if (!sync_temporary(descriptor_)) fail(name_);
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
  ::close(std::exchange(descriptor_, -1));
}

void write_text_file(const std::filesystem::path& path, std::string_view text, bool overwrite) {
  OutputFile file(path, overwrite);
  file.write(text);
  file.commit();
}

}  // namespace alidade
