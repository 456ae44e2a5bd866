// SPDX-License-Identifier: MIT
#include "base/local_map.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstdint>
#include <mutex>
#include <set>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/input_file.h"

namespace alidade {
namespace {

const auto k_page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));  // 64 KiB on some ARM systems

/// Where a map lies, as the handler of a signal may read it at any time: entries are never deleted, but used again.
struct Place {
  std::atomic<std::uintptr_t> begin = 0, end = 0;  ///< end 0: free
  std::atomic<bool> has_failed = false;
  Place* next = nullptr;
};
std::atomic<Place*> first_place = nullptr;

class WatchedMap;

/// For all that handlers do not need.
struct Registry {
  std::mutex mutex;
  std::set<const WatchedMap*> maps;
  bool has_handler = false;
};
/// What was there before the handler of SIGBUS.
struct sigaction handler_before {};

Registry& registry() {
  static Registry& registry = *new Registry;
  return registry;
}

Place* free_place() {
  for (Place* place = first_place; place != nullptr; place = place->next)
    if (place->end == 0) return place;
  auto* const made = new Place;
  made->next = first_place;
  first_place = made;
  return made;
}

class WatchedMap final : public LocalMap {
 public:
  WatchedMap(const std::string& path, std::string name) : path_(path), name_(std::move(name)) {
    const FileDescriptor file(path_, O_RDONLY | O_CLOEXEC);  // closed when the map is made
    const auto size = static_cast<std::size_t>(file.size_of_regular(name_));
    if (::fstat(file.number(), &status_) != 0) throw system_error(name_, "cannot read the file");
    if (size == 0) return;
    void* const map = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.number(), 0);
    if (map == MAP_FAILED) throw system_error(name_, "cannot map the file into memory");
    bytes_ = {static_cast<const std::byte*>(map), size};
    if (size > available_memory().value_or(size)) ::madvise(map, size, MADV_RANDOM);
    const std::scoped_lock lock(registry().mutex);
    install_handler();
    place_ = free_place();
    place_->begin = reinterpret_cast<std::uintptr_t>(map);
    place_->end = place_->begin + size;
    registry().maps.insert(this);
  }
  ~WatchedMap() override {
    if (bytes_.empty()) return;
    {
      const std::scoped_lock lock(registry().mutex);
      registry().maps.erase(this);
      // First, as handlers in other threads take what is before it for this map.
      place_->end = 0;
      if (place_->has_failed.exchange(false)) --failures_;
    }
    ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
  }
  WatchedMap(const WatchedMap&) = delete;
  WatchedMap& operator=(const WatchedMap&) = delete;

  std::span<const std::byte> bytes() const override { return bytes_; }
  bool holds(const void* address) const {
    const auto* const byte = static_cast<const std::byte*>(address);
    return byte >= bytes_.data() && byte < bytes_.data() + bytes_.size();
  }
  bool has_failed() const { return place_->has_failed; }

  /// Whether the file is there, but has changed. One that was replaced is another.
  bool is_changed() const {
    struct stat now {};
    if (::stat(path_.c_str(), &now) != 0 || now.st_dev != status_.st_dev || now.st_ino != status_.st_ino)
      return false;
    return now.st_size != status_.st_size || now.st_mtim.tv_sec != status_.st_mtim.tv_sec ||
           now.st_mtim.tv_nsec != status_.st_mtim.tv_nsec;
  }

  [[noreturn]] void fail() const {
    struct stat now {};
    const bool has_size = ::stat(path_.c_str(), &now) == 0 && now.st_size != status_.st_size;
    throw file_error(name_, "the file changed or its disk failed while it was read; read it again",
                     has_size ? fmt::format("{} bytes", status_.st_size) : "",
                     has_size ? fmt::format("{} bytes", now.st_size) : "");
  }

 private:
  /// Puts zeros where the file has no bytes any more. Only calls what signal handlers may.
  static void on_bus_error(int number, siginfo_t* info, void* context) {
    const auto address = reinterpret_cast<std::uintptr_t>(info->si_addr);
    for (Place* place = first_place; place != nullptr; place = place->next) {
      const std::uintptr_t begin = place->begin, end = place->end;
      // The place may get another map meanwhile.
      if (address < begin || address >= end || place->begin != begin) continue;
      const int error = errno;
      // In this order: who sees zeros must find the failure.
      if (!place->has_failed.exchange(true)) ++failures_;
      const std::uintptr_t page = address / k_page * k_page;
      const void* const map = ::mmap(reinterpret_cast<void*>(page), end - page, PROT_READ,
                                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED, -1, 0);
      errno = error;
      if (map != MAP_FAILED) return;
    }
    const struct sigaction& before = handler_before;
    if ((before.sa_flags & SA_SIGINFO) != 0) {
      before.sa_sigaction(number, info, context);
    } else if (before.sa_handler != SIG_DFL && before.sa_handler != SIG_IGN) {
      before.sa_handler(number);
    } else {
      ::signal(number, SIG_DFL);
      ::raise(number);
    }
  }

  static void install_handler() {
    if (registry().has_handler) return;
    struct sigaction action {};
    action.sa_sigaction = &on_bus_error;
    action.sa_flags = static_cast<int>(SA_SIGINFO | SA_ONSTACK);
    sigemptyset(&action.sa_mask);
    ::sigaction(SIGBUS, nullptr, &handler_before);
    registry().has_handler = ::sigaction(SIGBUS, &action, nullptr) == 0;
  }

  const std::string path_, name_;
  struct stat status_ {};
  std::span<const std::byte> bytes_;
  Place* place_ = nullptr;
};

}  // namespace

std::shared_ptr<const LocalMap> LocalMap::open(const std::string& path, const std::string& name) {
  return std::make_shared<const WatchedMap>(path, name);
}

void LocalMap::check_map(const void* address) {
  const std::scoped_lock lock(registry().mutex);
  for (const WatchedMap* const map : registry().maps)
    if (map->holds(address) && map->has_failed()) map->fail();
}

void LocalMap::check_all() {
  const std::scoped_lock lock(registry().mutex);
  for (const WatchedMap* const map : registry().maps)
    if (map->has_failed() || map->is_changed()) map->fail();
}

}  // namespace alidade
