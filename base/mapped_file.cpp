// SPDX-License-Identifier: MIT
#include "base/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>

#include "base/error.h"

namespace alidade {
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
