// SPDX-License-Identifier: MIT
#include "base/input_file.h"

#include <fcntl.h>
#include <sys/mman.h>
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

namespace alidade {

InputFile::InputFile(const std::filesystem::path& path) : name_(path.string()) {
  open();
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw Error({.file = name_,
                 .problem = "cannot be read",
                 .expected = "a regular file",
                 .found = S_ISDIR(status.st_mode) ? "a folder" : "something else"});
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::InputFile(std::span<const std::byte> bytes, std::string name)
    : name_(std::move(name)), size_(bytes.size()), memory_(bytes), in_memory_(true) {}

InputFile::~InputFile() {
  rest();
}

InputFile::InputFile(InputFile&& other) noexcept
    : name_(std::move(other.name_)),
      size_(std::exchange(other.size_, 0)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      memory_(std::exchange(other.memory_, {})),
      in_memory_(std::exchange(other.in_memory_, true)),
      window_(std::move(other.window_)),
      window_place_(other.window_place_),
      window_size_(std::exchange(other.window_size_, 0)) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(size_, other.size_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(memory_, other.memory_);
  std::swap(in_memory_, other.in_memory_);
  std::swap(window_, other.window_);
  std::swap(window_place_, other.window_place_);
  std::swap(window_size_, other.window_size_);
  return *this;
}

void InputFile::open() {
  descriptor_ = ::open(name_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0)
    throw Error({.file = name_, .problem = "cannot be opened", .found = std::strerror(errno)});
}

void InputFile::rest() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  window_ = {};
  window_size_ = 0;
}

void InputFile::check_range(std::uint64_t place, std::uint64_t count) const {
  if (place <= size_ && count <= size_ - place) return;
  throw Error({.file = name_,
               .place = "byte " + std::to_string(place),
               .problem = "the file ends early",
               .expected = std::to_string(count) + " bytes from here",
               .found = std::to_string(place <= size_ ? size_ - place : 0)});
}

void InputFile::fill(std::uint64_t place, std::span<std::byte> into) {
  if (descriptor_ < 0) open();
  while (!into.empty()) {
    const ::ssize_t count = ::pread(descriptor_, into.data(), into.size(), static_cast<::off_t>(place));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      throw Error({.file = name_,
                   .place = "byte " + std::to_string(place),
                   .problem = "reading failed",
                   .found = count < 0 ? std::strerror(errno) : "the file became shorter while it was read"});
    }
    into = into.subspan(static_cast<std::size_t>(count));
    place += static_cast<std::uint64_t>(count);
  }
}

void InputFile::read_at(std::uint64_t place, std::span<std::byte> into) {
  check_range(place, into.size());
  if (into.empty()) return;
  if (in_memory_) {
    std::memcpy(into.data(), memory_.data() + place, into.size());
  } else {
    fill(place, into);
  }
}

std::span<const std::byte> InputFile::view(std::uint64_t place, std::size_t count) {
  check_range(place, count);
  if (in_memory_) return memory_.subspan(static_cast<std::size_t>(place), count);
  const bool inside = window_size_ > 0 && place >= window_place_ && place - window_place_ <= window_size_ &&
                      count <= window_size_ - (place - window_place_);
  if (!inside) {
    if (window_.size() < count) window_ = std::vector<std::byte>(count);
    const std::size_t useful =
        static_cast<std::size_t>(std::min<std::uint64_t>(window_.size(), size_ - place));
    window_size_ = 0;
    fill(place, std::span(window_).first(useful));
    window_place_ = place;
    window_size_ = useful;
  }
  return std::span(window_).subspan(static_cast<std::size_t>(place - window_place_), count);
}

std::span<const std::byte> InputFile::view_up_to(std::uint64_t place, std::size_t count) {
  const std::uint64_t left = place < size_ ? size_ - place : 0;
  return view(std::min(place, size_), static_cast<std::size_t>(std::min<std::uint64_t>(count, left)));
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
                 .problem = "too large for a scene or camera",
                 .expected = "at most " + std::to_string(largest >> 20) + " MiB"});
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text(size, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(size));
  if (!stream && !stream.eof()) throw Error({.file = file.string(), .problem = "cannot be read"});
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

namespace {

/// Closes the file when it goes away; the map stays.
struct Descriptor {
  explicit Descriptor(const std::string& name) : number(::open(name.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (number < 0) throw Error({.file = name, .problem = "cannot be opened", .found = std::strerror(errno)});
  }
  ~Descriptor() { ::close(number); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number;
};

std::shared_ptr<const void> aligned_copy(std::span<const std::byte> bytes) {
  constexpr std::align_val_t k_page{4096};
  void* const copy = ::operator new(bytes.size(), k_page);
  const auto release = [](const void* at) { ::operator delete(const_cast<void*>(at), k_page); };
  std::shared_ptr<const void> storage(copy, release);
  if (!bytes.empty()) std::memcpy(copy, bytes.data(), bytes.size());
  return storage;
}

}  // namespace

MappedFile::MappedFile(const InputFile& file) : name_(file.name()) {
  if (const auto memory = file.memory()) {
    storage_ = aligned_copy(*memory);
    bytes_ = {static_cast<const std::byte*>(storage_.get()), memory->size()};
    return;
  }
  const Descriptor descriptor(name_);
  struct stat status {};
  if (::fstat(descriptor.number, &status) != 0 || !S_ISREG(status.st_mode))
    throw Error({.file = name_, .problem = "cannot be read", .expected = "a regular file"});
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return;
  void* const map = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor.number, 0);
  if (map == MAP_FAILED)
    throw Error({.file = name_, .problem = "cannot be mapped into memory", .found = std::strerror(errno)});
  storage_ = std::shared_ptr<const void>(
      map, [size](const void* address) { ::munmap(const_cast<void*>(address), size); });
  bytes_ = {static_cast<const std::byte*>(map), size};
}

}  // namespace alidade
