// SPDX-License-Identifier: MIT
#include "extensions/web/block_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <mutex>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "base/output_file.h"

namespace alidade::geo {
namespace fs = std::filesystem;
namespace {

/// The head of a block's file. Both sums are compared when it is read, so that no block is mistaken for
/// another.
struct BlockHeader {
  std::array<char, 8> magic = {'A', 'L', 'B', 'L', 'O', 'C', 'K', '1'};
  std::uint64_t sum_of_key = 0, sum_of_block = 0;
  bool operator==(const BlockHeader&) const = default;
};

std::uint64_t sum_of(std::string_view text) {
  return checksum(std::as_bytes(std::span(text)));
}

BlockHeader header_of(const std::string& key, std::span<const std::byte> block) {
  BlockHeader header;
  header.sum_of_key = sum_of("block of " + key);
  header.sum_of_block = checksum(block);
  return header;
}

/// Follows the bytes of a whole file: how much of it has been fetched.
struct CopyState {
  std::array<char, 8> magic = {'A', 'L', 'W', 'H', 'O', 'L', 'E', '1'};
  std::uint64_t sum_of_key = 0, fetched = 0;
};

constexpr std::string_view k_extension = ".block", k_copy_extension = ".whole";
constexpr const char* k_mark = "alidade-cache";  // an empty file: the folder is ours
constexpr std::size_t k_folder_digits = 2, k_file_digits = 14;

bool read_fully(int descriptor, void* into, std::size_t count) {
  return ::read(descriptor, into, count) == static_cast<::ssize_t>(count);
}

bool are_hex_digits(std::string_view text, std::size_t count) {
  return text.size() == count && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

bool is_name(std::string_view name, std::string_view extension) {
  return name.ends_with(extension) &&
         are_hex_digits(name.substr(0, name.size() - extension.size()), k_file_digits);
}

/// Whether a name is that of a file that is being written.
bool is_temporary_name(std::string_view name) {
  const std::size_t end = 1 + k_file_digits + k_extension.size();
  return name.starts_with('.') && name.size() > end && is_name(name.substr(1, end - 1), k_extension) &&
         name.substr(end).starts_with(".part-");
}

/// Never waits, as opening a named pipe would, and follows no links.
FileDescriptor open_block(const fs::path& path, int flags = O_RDONLY) {
  FileDescriptor file(::open(path.c_str(), flags | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW, 0600));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.number(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  return file;
}

/// The state that follows `bytes` bytes of a copy; empty if the file is not a copy.
std::optional<CopyState> state_of(const FileDescriptor& file, std::uint64_t bytes) {
  CopyState state;
  if (file.read_at(bytes, std::as_writable_bytes(std::span(&state, 1))) != sizeof(state) ||
      state.magic != CopyState().magic)
    return std::nullopt;
  return state;
}

/// How many of the bytes of a copy are there; empty if the file is not the copy of this key.
std::optional<std::uint64_t> fetched(const FileDescriptor& file, const std::string& key,
                                     std::uint64_t bytes) {
  const std::optional<CopyState> state = state_of(file, bytes);
  if (!state || state->sum_of_key != sum_of("copy of " + key) || state->fetched > bytes) return std::nullopt;
  return state->fetched;
}

/// Whether a file is a block or a copy.
bool is_ours(const fs::path& path) {
  const FileDescriptor file = open_block(path);
  if (!file.is_open()) return false;
  if (path.extension() == k_copy_extension) {
    const std::uint64_t size = file.size_of_regular(path.string());
    return size >= sizeof(CopyState) && state_of(file, size - sizeof(CopyState));
  }
  BlockHeader header;
  return read_fully(file.number(), &header, sizeof(header)) && header.magic == BlockHeader().magic;
}

/// Errors: the folder holds something else, or others may write to it: what they put there would be read as
/// points.
void check_folder(const fs::path& folder) {
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0 || ::access(folder.c_str(), R_OK | W_OK | X_OK) != 0)
    throw system_error(folder.string(), "cannot write to the folder of the cache");
  if (status.st_uid != ::geteuid() || (status.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    throw file_error(folder.string(), "other users may write to the folder of the cache",
                     "a folder of yours that only you may write to (chmod go-w)",
                     fmt::format("user {}, mode {:o}", status.st_uid, status.st_mode & 07777));
  // In this order: another program may make the folder a cache meanwhile.
  std::error_code error;
  const fs::path mark = folder / k_mark;
  if (!fs::is_empty(folder, error) && !error && !fs::exists(fs::symlink_status(mark, error)))
    throw file_error(folder.string(), "the folder of the cache holds something else",
                     "a new or an empty folder");
  const FileDescriptor file(
      ::open(mark.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW, 0600));
  if (!file.is_open()) throw system_error(mark.string(), "cannot write to the folder of the cache");
}

}  // namespace

BlockFolder::BlockFolder(fs::path folder, std::uint64_t most_bytes)
    : folder_(std::move(folder)), most_bytes_(most_bytes) {
  std::error_code error;
  if (!fs::is_directory(folder_, error)) {
    fs::create_directories(folder_, error);
    if (!error) fs::permissions(folder_, fs::perms::owner_all, error);
    if (error) throw system_error(folder_.string(), "cannot make the folder of the cache", error.value());
  }
  check_folder(folder_);
  make_room();
}

fs::path BlockFolder::path_of(const std::string& key, std::string_view extension) const {
  const std::string name = fmt::format("{:016x}", sum_of(key));
  return folder_ / name.substr(0, k_folder_digits) / name.substr(k_folder_digits).append(extension);
}

bool BlockFolder::has_room(std::uint64_t bytes, std::uint64_t block) const {
  // make_room() removes at least a fifth of all, what is older first: none of these blocks, nor a mark beside
  // them.
  return bytes + (bytes / block + 3) * sizeof(BlockHeader) <= cut_bytes();
}

bool BlockFolder::contains(const std::string& key) const {
  return ::access(path_of(key, k_extension).c_str(), R_OK) == 0;
}

std::optional<std::vector<std::byte>> BlockFolder::find(const std::string& key, std::size_t count) {
  const fs::path path = path_of(key, k_extension);
  const FileDescriptor file = open_block(path);
  if (!file.is_open()) return std::nullopt;
  BlockHeader header;
  std::vector<std::byte> block(count);
  if (!read_fully(file.number(), &header, sizeof(header)) ||
      !read_fully(file.number(), block.data(), count) || header != header_of(key, block))
    return std::nullopt;  // keep() replaces it
  // The time of its last use.
  ::futimens(file.number(), nullptr);
  return block;
}

void BlockFolder::keep(const std::string& key, std::span<const std::byte> block) {
  const fs::path path = path_of(key, k_extension);
  const std::uint64_t size = sizeof(BlockHeader) + block.size();
  if (size > most_bytes_) return;
  std::error_code error;
  fs::create_directory(path.parent_path(), error);
  const fs::path temporary = path.parent_path() / fmt::format(".{}.part-{}-{}", path.filename().string(),
                                                              ::getpid(), temporaries_++);
  {
    const FileDescriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (!file.is_open()) return;
    try {
      const BlockHeader header = header_of(key, block);
      write_fully(temporary.string(), file.number(), 0, std::as_bytes(std::span(&header, 1)));
      write_fully(temporary.string(), file.number(), sizeof(header), block);
    } catch (const Error&) {
      ::unlink(temporary.c_str());
      return;
    }
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    ::unlink(temporary.c_str());
    return;
  }
  if ((bytes_ += size) > most_bytes_) make_room();
}

std::uint64_t BlockFolder::fetched_of(const std::string& key, std::uint64_t bytes) const {
  const FileDescriptor file = open_block(path_of(key, k_copy_extension));
  return file.is_open() ? fetched(file, key, bytes).value_or(0) : 0;
}

std::optional<KeptCopy> BlockFolder::copy_of(const std::string& key, std::uint64_t bytes) {
  if (bytes == 0 || !has_room(bytes, bytes)) return std::nullopt;
  const fs::path path = path_of(key, k_copy_extension);
  std::error_code error;
  fs::create_directory(path.parent_path(), error);
  KeptCopy copy{open_block(path, O_RDWR | O_CREAT)};
  if (!copy.file.is_open()) return std::nullopt;
  ::futimens(copy.file.number(), nullptr);  // the time of its last use
  copy.fetched = fetched(copy.file, key, bytes).value_or(0);
  if (copy.fetched == bytes) return copy;
  struct stat status {};
  if (::flock(copy.file.number(), LOCK_EX | LOCK_NB) != 0 || ::fstat(copy.file.number(), &status) != 0 ||
      status.st_nlink == 0)
    return std::nullopt;
  // Another process may have fetched more before the lock was taken.
  const std::optional<std::uint64_t> known = fetched(copy.file, key, bytes);
  copy.fetched = known.value_or(0);
  if (known) return copy;
  try {
    if (::ftruncate(copy.file.number(), 0) != 0) return std::nullopt;
    extend(copy, key, bytes, {});
  } catch (const Error&) {
    return std::nullopt;
  }
  if ((bytes_ += bytes) > most_bytes_) make_room();
  return copy;
}

void BlockFolder::extend(KeptCopy& copy, const std::string& key, std::uint64_t bytes,
                         std::span<const std::byte> next) {
  CopyState state;
  state.sum_of_key = sum_of("copy of " + key);
  state.fetched = copy.fetched + next.size();
  const std::string name = folder_.string();
  write_fully(name, copy.file.number(), copy.fetched, next);
  // What is noted as there is on the disk.
  if (::fdatasync(copy.file.number()) != 0)
    throw system_error(name, "cannot write to the folder of the cache");
  write_fully(name, copy.file.number(), bytes, std::as_bytes(std::span(&state, 1)));
  copy.fetched = state.fetched;
  if (copy.fetched == bytes) ::flock(copy.file.number(), LOCK_UN);
}

void BlockFolder::make_room() {
  struct Entry {
    fs::file_time_type used;
    std::uint64_t bytes;
    fs::path path;
  };
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  std::vector<Entry> entries;
  std::uint64_t bytes = 0;
  const auto now = fs::file_time_type::clock::now();
  const auto note = [&](const fs::directory_entry& file) {
    std::error_code error;  // another program may remove it
    const std::string name = file.path().filename().string();
    const bool is_temporary = is_temporary_name(name);
    if (!is_temporary && !is_name(name, k_extension) && !is_name(name, k_copy_extension)) return;
    if (!fs::is_regular_file(file.symlink_status(error)) || error) return;
    Entry entry{file.last_write_time(error), 0, file.path()};
    if (error) return;
    // A file that a killed program left.
    if (is_temporary && now - entry.used > std::chrono::hours(1)) fs::remove(file.path(), error);
    entry.bytes = is_temporary ? 0 : file.file_size(error);
    if (is_temporary || error) return;
    bytes += entry.bytes;
    entries.push_back(std::move(entry));
  };
  const auto for_each_entry = [](const fs::path& folder, const auto& visit) {
    std::error_code error;  // what cannot be read is left alone
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
      visit(*entry);
  };
  for_each_entry(folder_, [&](const fs::directory_entry& part) {
    std::error_code error;
    if (are_hex_digits(part.path().filename().string(), k_folder_digits) &&
        fs::is_directory(part.symlink_status(error)))
      for_each_entry(part.path(), note);
  });
  const std::uint64_t goal = bytes > most_bytes_ ? cut_bytes() : most_bytes_;
  std::ranges::sort(entries, {}, &Entry::used);
  for (const Entry& entry : entries) {
    if (bytes <= goal) break;
    std::error_code error;
    if (is_ours(entry.path) && fs::remove(entry.path, error)) bytes -= entry.bytes;
  }
  bytes_ = bytes;
}

}  // namespace alidade::geo
