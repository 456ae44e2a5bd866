// SPDX-License-Identifier: MIT
#include "base/local_map.h"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>
#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/shown_text.h"

namespace alidade {
namespace {

/// The addresses of a map, as the handler of a signal may read them at any time: ranges are never deleted,
/// but used again.
struct MapRange {
  std::atomic<std::uintptr_t> begin = 0, end = 0;  ///< end 0: free
  std::string message;                             ///< does not change while `end` is not 0
  MapRange* next = nullptr;
};
std::atomic<MapRange*> first_range = nullptr;
std::mutex ranges_mutex;

/// The handler of SIGBUS before ours.
struct sigaction handler_before {};

/// Requires the mutex.
MapRange* free_range() {
  for (MapRange* range = first_range; range != nullptr; range = range->next)
    if (range->end == 0) return range;
  auto* const made = new MapRange;
  made->next = first_range;
  first_range = made;
  return made;
}

/// Only calls what signal handlers may.
void on_bus_error(int number, siginfo_t* info, void* context) {
  constexpr int k_failed = 2;  // as the program's for anything wrong
  static std::atomic_flag is_ending = ATOMIC_FLAG_INIT;
  const auto address = reinterpret_cast<std::uintptr_t>(info->si_addr);
  for (const MapRange* range = first_range; range != nullptr; range = range->next) {
    const std::uintptr_t begin = range->begin, end = range->end;
    // Another map may take the range meanwhile.
    if (address < begin || address >= end || range->begin != begin) continue;
    // Another thread must not end the process before the message is complete.
    while (is_ending.test_and_set()) ::pause();
    [[maybe_unused]] const auto count = ::write(STDERR_FILENO, range->message.data(), range->message.size());
    ::_exit(k_failed);
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

/// Requires the mutex.
void install_handler() {
  static bool is_installed = false;
  if (is_installed) return;
  struct sigaction action {};
  action.sa_sigaction = &on_bus_error;
  action.sa_flags = static_cast<int>(SA_SIGINFO | SA_ONSTACK);
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGBUS, nullptr, &handler_before);
  is_installed = ::sigaction(SIGBUS, &action, nullptr) == 0;
}

std::string message_of(const std::string& name) {
  // Behind a line of progress that is being rewritten.
  const char* const begin = ::isatty(STDERR_FILENO) == 1 ? "\n" : "";
  return begin + ("alidade: error: " + line_text(public_name(name))) +
         ": the file became shorter, or its disk failed, while it was in use; expected a file that stays as "
         "it is: replace it by renaming another one, and run this again\n";
}

}  // namespace

MappedBytes map_file(const FileDescriptor& file, std::uint64_t size, const std::string& name) {
  if (size == 0) return {};
  const auto count = static_cast<std::size_t>(size);
  void* const map = ::mmap(nullptr, count, PROT_READ, MAP_SHARED, file.number(), 0);
  if (map == MAP_FAILED) throw system_error(name, "cannot map the file into memory");
  if (size > available_memory().value_or(size)) ::madvise(map, count, MADV_RANDOM);
  MapRange* range = nullptr;
  {
    const std::scoped_lock lock(ranges_mutex);
    install_handler();
    range = free_range();
    range->message = message_of(name);
    range->begin = reinterpret_cast<std::uintptr_t>(map);
    range->end = range->begin + count;
  }
  return {{static_cast<const std::byte*>(map), count},
          std::shared_ptr<const void>(map, [range, count](const void* mapped) {
            // First: the handler would take later maps in this range for this one.
            range->end = 0;
            ::munmap(const_cast<void*>(mapped), count);
          })};
}

void expect_reads(std::span<const std::byte> bytes) noexcept {
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(bytes.data()) / page * page;
  const auto end = reinterpret_cast<std::uintptr_t>(bytes.data()) + bytes.size();
  ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_WILLNEED);
}

}  // namespace alidade
