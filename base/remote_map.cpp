// SPDX-License-Identifier: MIT
#include "base/remote_map.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>
#include <algorithm>
#include <exception>
#include <map>
#include <mutex>
#include <shared_mutex>
#include <system_error>
#include <thread>
#include <unordered_map>
#include <vector>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/input_file.h"
#include "base/page_faults.h"

namespace alidade {
namespace {

constexpr int k_fetching_threads = 4;
/// A request ends with the block that reaches this size.
constexpr std::uint64_t k_request_bytes = std::uint64_t{8} << 20;

std::uint64_t page_end(std::uint64_t offset) {
  return (offset + k_fault_page - 1) / k_fault_page * k_fault_page;
}

class FaultingMap;

/// All maps, and the errors of those that have failed.
struct Registry {
  std::mutex mutex;
  std::map<const std::byte*, std::weak_ptr<FaultingMap>> maps;  ///< by their first byte
  std::map<const FaultingMap*, std::exception_ptr> failures;
};

Registry& registry() {
  static Registry& registry = *new Registry;
  return registry;
}

std::atomic<std::uint64_t> bytes_of_all_maps = 0;  ///< held in memory

class FaultingMap final : public RemoteMap {
 public:
  /// Errors: those of open_remote_file(); the server states a size that no file has.
  FaultingMap(std::string name, std::uint64_t most_bytes)
      : name_(std::move(name)),
        file_(open_remote_file(name_)),
        size_(file_->size()),
        mapped_(std::max(page_end(size_), k_fault_page)),
        most_of_all_maps_(most_bytes > ~std::uint64_t{0} - bytes_of_all_maps
                              ? ~std::uint64_t{0}
                              : bytes_of_all_maps + most_bytes) {
    constexpr std::uint64_t k_largest = std::uint64_t{1} << 46;  // half of the addresses of a program
    if (size_ >= k_largest)
      throw file_error(name_, "the server states a size that no index file has",
                       fmt::format("less than {} bytes", k_largest), fmt::format("{}", size_));
  }

  ~FaultingMap() override {
    const bool is_forked = ::getpid() != process_;
    if (is_forked) {
      // The threads run only in the parent, and the userfaultfd is shared with it: neither may be stopped
      // here, and what they use is leaked.
      new std::vector<std::thread>(std::move(threads_));
      (void)file_.release();
    } else if (!threads_.empty()) {
      faults_.stop();
      for (std::thread& thread : threads_) thread.join();
    }
    {
      const std::scoped_lock lock(registry().mutex);
      registry().maps.erase(begin_);
      if (registry().failures.erase(this) > 0) --failures_;
    }
    if (begin_ != nullptr) ::munmap(begin_, mapped_);
    bytes_of_all_maps -= held_bytes_;
  }

  /// Maps the file and starts to serve its page faults. False if the system does not permit that.
  bool start() {
    void* const map = ::mmap(nullptr, mapped_, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (map == MAP_FAILED) return false;
    begin_ = static_cast<std::byte*>(map);
    ::madvise(map, mapped_, MADV_NOHUGEPAGE);
    if (!faults_.open({begin_, static_cast<std::size_t>(mapped_)})) return false;
    threads_.reserve(k_fetching_threads);
    try {
      for (int i = 0; i < k_fetching_threads; ++i) threads_.emplace_back([this] { serve(); });
    } catch (const std::system_error&) {
      return false;  // no more threads
    }
    return true;
  }

  std::span<const std::byte> bytes() const override { return {begin_, static_cast<std::size_t>(size_)}; }

  void set_blocks(BlockOf block_of, CheckBlock check) override {
    const std::unique_lock lock(blocks_mutex_);
    block_of_ = std::move(block_of);
    check_ = std::move(check);
  }

  void fetch(std::span<const std::byte> wanted) noexcept override {
    const auto first = static_cast<std::uint64_t>(wanted.data() - begin_);
    if (has_failed_) return;
    try {
      fetch_missing(*open_again(), first, std::min(first + wanted.size(), size_));
    } catch (...) {
      fail(std::current_exception());
    }
  }

  /// Keeps the first failure only. Requires the registry's mutex. has_failed_ is set last: a thread that
  /// reads it as true stores zeros, and check() must throw by then.
  void fail_locked(const std::exception_ptr& failure) {
    if (!registry().failures.emplace(this, failure).second) return;
    ++failures_;
    has_failed_ = true;
  }
  const std::string& name() const { return name_; }

 private:
  enum class PageState : std::uint8_t { missing, requested, present };
  using Block = std::pair<std::uint64_t, std::uint64_t>;  ///< begin and end, both multiples of a page

  /// A connection for one thread. Errors: the file on the server has changed.
  std::unique_ptr<RemoteFile> open_again() const {
    auto file = open_remote_file(name_);
    if (file->version() != file_->version() || file->size() != size_)
      throw file_error(name_, "the file changed while it was read; read it again",
                       fmt::format("{} bytes, version {}", size_, file_->version()),
                       fmt::format("{} bytes, version {}", file->size(), file->version()));
    return file;
  }

  Block block_at(std::uint64_t offset) const {
    const std::shared_lock lock(blocks_mutex_);
    if (!block_of_)
      return {offset / k_fault_page * k_fault_page, offset / k_fault_page * k_fault_page + k_fault_page};
    const auto [begin, end] = block_of_(offset);
    return {begin, page_end(end)};
  }

  /// Of the page at `offset`; missing until set. Requires mutex_.
  PageState& state(std::uint64_t offset) {
    const std::uint64_t page = offset / k_fault_page;
    return states_[page / k_chunk_pages][static_cast<std::size_t>(page % k_chunk_pages)];
  }
  void set_states(std::uint64_t begin, std::uint64_t end, PageState to) {
    for (std::uint64_t offset = begin; offset < end; offset += k_fault_page) state(offset) = to;
  }

  /// Marks missing blocks as requested, from the one that contains `offset` up to `end`, the first that is
  /// not missing, or the size of a request. Returns them: the caller must receive() them.
  std::vector<Block> claim(std::uint64_t offset, std::uint64_t end) {
    std::vector<Block> claimed;
    const std::scoped_lock lock(mutex_);
    while (offset < end &&
           (claimed.empty() || claimed.back().second - claimed.front().first < k_request_bytes)) {
      const Block block = block_at(offset);
      if (state(offset) != PageState::missing) break;
      set_states(block.first, block.second, PageState::requested);
      claimed.push_back(block);
      offset = block.second;
    }
    return claimed;
  }

  /// Fetches the missing blocks that have bytes in [begin, end).
  void fetch_missing(RemoteFile& file, std::uint64_t begin, std::uint64_t end) {
    while (begin < end) {
      const std::vector<Block> blocks = claim(begin, end);
      if (blocks.empty()) {
        begin = block_at(begin).second;
        continue;
      }
      receive(file, blocks);
      begin = blocks.back().second;
    }
  }

  /// Fetches, checks and stores the blocks that claim() returned; stores zeros if the map has failed.
  void receive(RemoteFile& file, const std::vector<Block>& blocks) {
    const std::uint64_t begin = blocks.front().first, end = blocks.back().second;
    std::vector<std::byte> bytes;
    if (!has_failed_) {
      try {
        reserve(end - begin);
        bytes.resize(static_cast<std::size_t>(end - begin));
        file.read(begin, std::span(bytes).first(static_cast<std::size_t>(std::min(end, size_) - begin)));
        check_blocks(blocks, bytes);
      } catch (...) {
        bytes.clear();
        fail(std::current_exception());
      }
    }
    store(begin, end, bytes.empty() ? nullptr : bytes.data());
  }

  /// Counts bytes that the map is about to hold. Errors: all maps together would hold too much.
  void reserve(std::uint64_t bytes) {
    if ((bytes_of_all_maps += bytes) <= most_of_all_maps_) {
      held_bytes_ += bytes;
      return;
    }
    bytes_of_all_maps -= bytes;
    throw file_error(name_,
                     "too much of the remote file is needed to keep it in memory; copy it to this machine",
                     fmt::format("at most {} bytes of remote index files in memory", most_of_all_maps_));
  }

  void check_blocks(const std::vector<Block>& blocks, std::span<const std::byte> bytes) {
    const std::shared_lock lock(blocks_mutex_);
    if (!check_) return;
    const std::uint64_t begin = blocks.front().first;
    for (const auto& [first, behind] : blocks)
      check_(first, bytes.subspan(static_cast<std::size_t>(first - begin),
                                  static_cast<std::size_t>(std::min(behind, size_) - first)));
  }

  /// Puts whole pages into the map, of zeros if `from` is null, and wakes the threads that wait for them.
  void store(std::uint64_t begin, std::uint64_t end, const std::byte* from) {
    faults_.fill({begin_ + begin, static_cast<std::size_t>(end - begin)}, from);
    const std::scoped_lock lock(mutex_);
    set_states(begin, end, PageState::present);
  }

  void fail(const std::exception_ptr& failure) {
    const std::scoped_lock lock(registry().mutex);
    fail_locked(failure);
  }

  /// End of the request for the block at `offset`. The read-ahead grows while requests follow one another.
  std::uint64_t request_end(std::uint64_t offset) {
    const Block block = block_at(offset);
    const std::scoped_lock lock(mutex_);
    const bool is_sequential = block.first == request_end_;
    read_ahead_ =
        is_sequential ? std::min(2 * read_ahead_ + (block.second - block.first), k_request_bytes) : 0;
    request_end_ = std::min(block.second + read_ahead_, size_);
    return request_end_;
  }

  /// Answers page faults until the map is destroyed. If an exception ended it, threads would wait forever.
  void serve() noexcept {
    std::unique_ptr<RemoteFile> file;
    while (const std::byte* const page = faults_.next()) {
      const auto offset = static_cast<std::uint64_t>(page - begin_);
      if (state_at(offset) != PageState::missing) {
        // A requested page wakes its threads when it is stored. One that was stored between the fault and
        // this message has not woken them.
        if (state_at(offset) == PageState::present) faults_.wake(begin_ + offset);
        continue;
      }
      try {
        if (!file && !has_failed_) file = open_again();
      } catch (...) {
        fail(std::current_exception());
      }
      const std::vector<Block> blocks = claim(offset, request_end(offset));
      if (!blocks.empty())
        receive(*(file ? file : file_), blocks);
      else if (state_at(offset) == PageState::present)
        faults_.wake(begin_ + offset);
    }
  }

  PageState state_at(std::uint64_t offset) {
    const std::scoped_lock lock(mutex_);
    return state(offset);
  }

  static constexpr std::size_t k_chunk_pages = 256;

  const std::string name_;
  const ::pid_t process_ = ::getpid();
  std::unique_ptr<RemoteFile> file_;
  const std::uint64_t size_, mapped_;     ///< bytes of the file, and of the map, which ends with a page
  const std::uint64_t most_of_all_maps_;  ///< bytes that all maps may hold while this one grows
  std::atomic<std::uint64_t> held_bytes_ = 0;
  std::byte* begin_ = nullptr;
  PageFaults faults_;
  std::vector<std::thread> threads_;
  std::atomic<bool> has_failed_ = false;
  mutable std::shared_mutex blocks_mutex_;
  BlockOf block_of_;
  CheckBlock check_;
  std::mutex mutex_;  ///< of all members below
  /// By chunk of pages, created on first use: servers may state any size.
  std::unordered_map<std::uint64_t, std::array<PageState, k_chunk_pages>> states_;
  std::uint64_t request_end_ = 0;  ///< of the last fault
  std::uint64_t read_ahead_ = 0;   ///< bytes
};

// userfaultfd(2) does not serve the child of fork(2), which would read zeros.

void lock_registry() {
  registry().mutex.lock();
}
void unlock_registry() {
  registry().mutex.unlock();
}
void fail_all_in_child() {
  for (const auto& [begin, known] : registry().maps)
    if (const auto map = known.lock())
      map->fail_locked(std::make_exception_ptr(file_error(
          map->name(), "the process was forked, and remote files do not follow; open the file again")));
  registry().mutex.unlock();
}

std::shared_ptr<FaultingMap> find_map(const void* address) {
  const auto* const byte = static_cast<const std::byte*>(address);
  std::shared_ptr<FaultingMap> map;  // destroyed after the lock is released
  const std::scoped_lock lock(registry().mutex);
  const auto after = registry().maps.upper_bound(byte);
  if (after == registry().maps.begin()) return nullptr;
  map = std::prev(after)->second.lock();
  return map && byte < map->bytes().data() + map->bytes().size() ? map : nullptr;
}

}  // namespace

std::shared_ptr<RemoteMap> RemoteMap::open(const std::string& name, std::optional<std::uint64_t> most_bytes) {
  [[maybe_unused]] static const int is_set =
      ::pthread_atfork(&lock_registry, &unlock_registry, &fail_all_in_child);
  constexpr std::uint64_t k_unlimited = ~std::uint64_t{0};
  const std::uint64_t room = available_memory() ? *available_memory() / 2 : k_unlimited;
  auto map = std::make_shared<FaultingMap>(name, most_bytes.value_or(room));
  if (!map->start()) return nullptr;
  const std::scoped_lock lock(registry().mutex);
  registry().maps[map->bytes().data()] = map;
  return map;
}

std::shared_ptr<RemoteMap> RemoteMap::find(const void* address) {
  return find_map(address);
}

void RemoteMap::touch(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  const auto read = [](const volatile std::byte& byte) { [[maybe_unused]] const std::byte copy = byte; };
  for (std::size_t at = 0; at < bytes.size(); at += k_fault_page) read(bytes[at]);
  read(bytes.back());
}

void RemoteMap::check_map(const void* address) {
  const std::shared_ptr<FaultingMap> map = find_map(address);
  std::exception_ptr failure;
  {
    const std::scoped_lock lock(registry().mutex);
    const auto found = registry().failures.find(map.get());
    if (found == registry().failures.end()) return;
    failure = found->second;
  }
  std::rethrow_exception(failure);
}

void RemoteMap::check_all_maps() {
  std::exception_ptr failure;
  {
    const std::scoped_lock lock(registry().mutex);
    if (registry().failures.empty()) return;
    failure = registry().failures.begin()->second;
  }
  std::rethrow_exception(failure);
}

}  // namespace alidade
