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

/// What a block's file begins with. Both sums are over the key, too: no key is stored, and no block stands for another.
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

constexpr const char* k_extension = ".block";

bool read_fully(int descriptor, void* into, std::size_t count) {
  return ::read(descriptor, into, count) == static_cast<::ssize_t>(count);
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
  if (::access(folder_.c_str(), W_OK | X_OK) != 0)
    throw system_error(folder_.string(), "cannot write to the folder of the cache");
  make_room();
}

fs::path BlockFolder::path_of(const std::string& key) const {
  const std::string name = fmt::format("{:016x}", sum_of(key));
  return folder_ / name.substr(0, 2) / (name.substr(2) + k_extension);
}

bool BlockFolder::contains(const std::string& key) const {
  return ::access(path_of(key).c_str(), R_OK) == 0;
}

std::optional<std::vector<std::byte>> BlockFolder::find(const std::string& key, std::size_t count) {
  const fs::path path = path_of(key);
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return std::nullopt;
  BlockHeader header;
  std::vector<std::byte> block(count);
  if (!read_fully(file.number(), &header, sizeof(header)) ||
      !read_fully(file.number(), block.data(), count) || header != header_of(key, block)) {
    ::unlink(path.c_str());
    return std::nullopt;
  }
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
  std::error_code error;
  const auto now = fs::file_time_type::clock::now();
  for (fs::recursive_directory_iterator file(folder_, error), end; !error && file != end;
       file.increment(error)) {
    std::error_code gone;  // by another program
    const fs::path& path = file->path();
    const bool is_temporary = path.filename().string().find(".block.part-") != std::string::npos;
    if (!is_temporary && path.extension() != k_extension) continue;  // not ours
    Entry entry{file->last_write_time(gone), file->file_size(gone), path};
    if (gone) continue;
    // What a program that was killed has left.
    if (is_temporary && now - entry.used > std::chrono::hours(1)) fs::remove(path, gone);
    if (is_temporary) continue;
    bytes += entry.bytes;
    entries.push_back(std::move(entry));
  }
  // Some more than needed, so that this is rare.
  const std::uint64_t goal = bytes > most_bytes_ ? most_bytes_ / 5 * 4 : most_bytes_;
  std::ranges::sort(entries, {}, &Entry::used);
  for (const Entry& entry : entries) {
    if (bytes <= goal) break;
    if (fs::remove(entry.path, error)) bytes -= entry.bytes;
  }
  bytes_ = bytes;
}

}  // namespace alidade::geo
