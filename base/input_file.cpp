// SPDX-License-Identifier: MIT
#include "base/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/local_map.h"
#include "base/text_scanner.h"

namespace alidade {

namespace {

constexpr int k_read_flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK;

OpenRemoteFile open_remote = nullptr;

}  // namespace

bool is_remote_name(std::string_view name) {
  constexpr const char* k_begins[] = {"https://",  "http://",  "s3://",     "gs://",   "az://",
                                      "/vsicurl/", "/vsis3/",  "/vsigs/",   "/vsiaz/", "/vsioss/",
                                      "/vsizip/",  "/vsitar/", "/vsigzip/", "/vsi7z/", "/vsiswift/"};
  return std::ranges::any_of(k_begins, [&](const char* begin) { return name.starts_with(begin); });
}

void set_remote_files(OpenRemoteFile open) {
  open_remote = open;
}

std::unique_ptr<RemoteFile> open_remote_file(const std::string& name) {
  if (open_remote == nullptr)
    throw Error({.file = name, .problem = "cannot open remote files", .expected = "a file on this machine"});
  return open_remote(name);
}

FileDescriptor::FileDescriptor(const std::string& path, int flags) : number_(::open(path.c_str(), flags)) {
  if (number_ < 0) throw system_error(path, "cannot open the file");
}

void FileDescriptor::close() {
  if (number_ >= 0) ::close(number_);
  number_ = -1;
}

std::size_t FileDescriptor::read_at(std::uint64_t offset, std::span<std::byte> into) const noexcept {
  std::size_t done = 0;
  while (done < into.size()) {
    const ::ssize_t count =
        ::pread(number_, into.data() + done, into.size() - done, static_cast<::off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errno = 0;
    if (count <= 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

void FileDescriptor::lock_checkpoint(const std::string& path) const {
  if (::flock(number_, LOCK_EX | LOCK_NB) == 0) return;
  if (errno == EWOULDBLOCK) throw file_error(path, "another run is using this checkpoint");
  throw system_error(path, "cannot lock the checkpoint");
}

std::uint64_t FileDescriptor::size_of_regular(const std::string& path) const {
  struct stat status {};
  if (::fstat(number_, &status) != 0 || !S_ISREG(status.st_mode)) {
    throw Error({.file = path,
                 .problem = "cannot read the file",
                 .expected = "a regular file",
                 .found = S_ISDIR(status.st_mode) ? "a folder" : "a special file"});
  }
  return static_cast<std::uint64_t>(status.st_size);
}

InputFile::InputFile(const std::filesystem::path& path)
    : address_(path.string()), name_(public_name(address_)) {
  if (is_remote_name(name_)) {
    remote_ = open_remote_file(address_);
    size_ = remote_->size();
    version_ = remote_->version();
  } else {
    descriptor_ = FileDescriptor(address_, k_read_flags);
    size_ = descriptor_.size_of_regular(name_);
  }
}

InputFile::InputFile(std::span<const std::byte> bytes, std::string name)
    : address_(std::move(name)), name_(public_name(address_)), size_(bytes.size()), memory_(bytes) {}

void InputFile::rest() {
  descriptor_.close();
  remote_.reset();
  window_ = {};
  window_size_ = 0;
}

void InputFile::check_range(std::uint64_t offset, std::uint64_t count) const {
  if (offset <= size_ && count <= size_ - offset) return;
  fail_at_byte(name_, offset, "truncated file", std::to_string(count) + " bytes from here",
               std::to_string(offset <= size_ ? size_ - offset : 0));
}

std::unique_ptr<RemoteFile> InputFile::open_again() const {
  std::unique_ptr<RemoteFile> remote = open_remote_file(address_);
  if (remote->size() == size_ && remote->version() == version_) return remote;
  throw file_error(name_, "the file changed while it was read; read it again",
                   fmt::format("{} bytes, version {}", size_, version_),
                   fmt::format("{} bytes, version {}", remote->size(), remote->version()));
}

void InputFile::fill(std::uint64_t offset, std::span<std::byte> into) {
  if (is_remote()) {
    if (!remote_) remote_ = open_again();
    return remote_->read(offset, into);
  }
  if (!descriptor_.is_open()) descriptor_ = FileDescriptor(address_, k_read_flags);
  const std::size_t count = descriptor_.read_at(offset, into);
  if (count == into.size()) return;
  fail_at_byte(name_, offset + count,
               errno != 0 ? std::string("cannot read the file: ") + std::strerror(errno)
                          : "the file was truncated while it was read");
}

MappedBytes InputFile::map(const Progress& progress) const {
  if (is_remote()) return open_again()->map(progress);
  if (!memory_) {
    const FileDescriptor file(address_, k_read_flags);  // closed when the map is made
    return map_file(file, file.size_of_regular(name_), name_);
  }
  constexpr std::align_val_t k_page{4096};
  void* const copy = ::operator new(memory_->size(), k_page);
  std::ranges::copy(*memory_, static_cast<std::byte*>(copy));
  return {{static_cast<const std::byte*>(copy), memory_->size()},
          std::shared_ptr<const void>(
              copy, [](const void* at) { ::operator delete(const_cast<void*>(at), k_page); })};
}

void InputFile::read_at(std::uint64_t offset, std::span<std::byte> into) {
  check_range(offset, into.size());
  if (into.empty()) return;
  if (memory_) {
    std::memcpy(into.data(), memory_->data() + offset, into.size());
  } else {
    fill(offset, into);
  }
}

std::span<const std::byte> InputFile::view(std::uint64_t offset, std::size_t count) {
  check_range(offset, count);
  if (memory_) return memory_->subspan(static_cast<std::size_t>(offset), count);
  const bool inside = window_size_ > 0 && offset >= window_offset_ &&
                      offset - window_offset_ <= window_size_ &&
                      count <= window_size_ - (offset - window_offset_);
  if (!inside) {
    if (window_.size() < count) window_ = std::vector<std::byte>(count);
    const std::size_t useful =
        static_cast<std::size_t>(std::min<std::uint64_t>(window_.size(), size_ - offset));
    window_size_ = 0;
    fill(offset, std::span(window_).first(useful));
    window_offset_ = offset;
    window_size_ = useful;
  }
  return std::span(window_).subspan(static_cast<std::size_t>(offset - window_offset_), count);
}

std::span<const std::byte> InputFile::view_up_to(std::uint64_t offset, std::size_t count) {
  const std::uint64_t left = offset < size_ ? size_ - offset : 0;
  return view(std::min(offset, size_), static_cast<std::size_t>(std::min<std::uint64_t>(count, left)));
}

std::string read_text_file(const std::filesystem::path& file, std::uintmax_t largest) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw Error({.file = file.string(), .problem = "no such file"});
  if (!std::filesystem::is_regular_file(status))
    throw Error({.file = file.string(), .problem = "not a regular file"});
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > largest) {
    throw Error({.file = file.string(),
                 .problem = "scene or camera file too large",
                 .expected = "at most " + std::to_string(largest >> 20) + " MiB"});
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text(size, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(size));
  if (!stream && !stream.eof()) throw Error({.file = file.string(), .problem = "cannot read the file"});
  text.resize(static_cast<std::size_t>(stream.gcount()));
  reject_utf16(text, file.string());
  return text;
}

}  // namespace alidade
