// SPDX-License-Identifier: MIT
#include "geo/block_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
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

constexpr std::string_view k_extension = ".block";
constexpr const char* k_mark = "alidade-cache";  // an empty file: the folder is ours
constexpr std::size_t k_folder_digits = 2, k_file_digits = 14;

bool read_fully(int descriptor, void* into, std::size_t count) {
  return ::read(descriptor, into, count) == static_cast<::ssize_t>(count);
}

bool are_hex_digits(std::string_view text, std::size_t count) {
  return text.size() == count && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

bool is_block_name(std::string_view name) {
  return name.ends_with(k_extension) &&
         are_hex_digits(name.substr(0, name.size() - k_extension.size()), k_file_digits);
}

/// Whether a name is that of a file that is being written.
bool is_temporary_name(std::string_view name) {
  const std::size_t end = 1 + k_file_digits + k_extension.size();
  return name.starts_with('.') && name.size() > end && is_block_name(name.substr(1, end - 1)) &&
         name.substr(end).starts_with(".part-");
}

/// Never waits, as opening a named pipe would, and follows no links.
FileDescriptor open_block(const fs::path& path) {
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.number(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  return file;
}

bool is_block(const fs::path& path) {
  const FileDescriptor file = open_block(path);
  BlockHeader header;
  return file.is_open() && read_fully(file.number(), &header, sizeof(header)) &&
         header.magic == BlockHeader().magic;
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

fs::path BlockFolder::path_of(const std::string& key) const {
  const std::string name = fmt::format("{:016x}", sum_of(key));
  return folder_ / name.substr(0, k_folder_digits) / name.substr(k_folder_digits).append(k_extension);
}

bool BlockFolder::has_room(std::uint64_t bytes, std::uint64_t block) const {
  // make_room() removes at least a fifth of all, what is older first: none of these blocks, nor a mark beside
  // them.
  return bytes + (bytes / block + 3) * sizeof(BlockHeader) <= cut_bytes();
}

bool BlockFolder::contains(const std::string& key) const {
  return ::access(path_of(key).c_str(), R_OK) == 0;
}

std::optional<std::vector<std::byte>> BlockFolder::find(const std::string& key, std::size_t count) {
  const fs::path path = path_of(key);
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
  const fs::path path = path_of(key);
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
    if (!is_temporary && !is_block_name(name)) return;
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
    if (is_block(entry.path) && fs::remove(entry.path, error)) bytes -= entry.bytes;
  }
  bytes_ = bytes;
}

}  // namespace alidade::geo
