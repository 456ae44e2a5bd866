// SPDX-License-Identifier: MIT
#include "base/remote_map.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/userfaultfd.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <shared_mutex>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/input_file.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_page = 4096;
constexpr int k_fetching_threads = 4;

std::uint64_t page_end(std::uint64_t offset) {
  return (offset + k_page - 1) / k_page * k_page;
}

/// All maps, and the last failure that nobody has heard of.
struct Registry {
  std::mutex mutex;
  std::map<const std::byte*, std::weak_ptr<RemoteMap>> maps;  ///< by their first byte
  std::exception_ptr new_failure;
};

Registry& registry() {
  static Registry& registry = *new Registry;
  return registry;
}

/// What serves the faults of an address range; not open if the system does not permit it.
FileDescriptor open_faults(void* begin, std::uint64_t bytes) {
#ifndef UFFD_USER_MODE_ONLY
  constexpr int UFFD_USER_MODE_ONLY = 1;
#endif
  FileDescriptor faults(
      static_cast<int>(::syscall(SYS_userfaultfd, O_CLOEXEC | O_NONBLOCK | UFFD_USER_MODE_ONLY)));
  if (!faults.is_open()) return faults;
  ::uffdio_api api{.api = UFFD_API, .features = 0, .ioctls = 0};
  ::uffdio_register range{.range = {reinterpret_cast<std::uint64_t>(begin), bytes},
                          .mode = UFFDIO_REGISTER_MODE_MISSING,
                          .ioctls = 0};
  if (::ioctl(faults.number(), UFFDIO_API, &api) != 0 ||
      ::ioctl(faults.number(), UFFDIO_REGISTER, &range) != 0)
    return {};
  return faults;
}

class FaultingMap final : public RemoteMap {
 public:
  FaultingMap(std::string name, std::uint64_t most_bytes)
      : name_(std::move(name)), file_(open_remote_file(name_)), most_bytes_(most_bytes) {
    size_ = file_->size();
    mapped_ = std::max(page_end(size_), k_page);
    void* const map = ::mmap(nullptr, mapped_, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (map == MAP_FAILED) return;
    begin_ = static_cast<std::byte*>(map);
    ::madvise(map, mapped_, MADV_NOHUGEPAGE);
    faults_ = open_faults(map, mapped_);
    stop_ = FileDescriptor(::eventfd(0, EFD_CLOEXEC));
    pages_.resize(mapped_ / k_page, Page::missing);
    if (is_permitted())
      for (std::thread& thread : threads_) thread = std::thread([this] { serve(); });
  }

  ~FaultingMap() override {
    is_stopping_ = true;
    constexpr std::uint64_t k_one = 1;
    [[maybe_unused]] const ::ssize_t written = ::write(stop_.number(), &k_one, sizeof(k_one));
    for (std::thread& thread : threads_)
      if (thread.joinable()) thread.join();
    {
      const std::scoped_lock lock(registry().mutex);
      registry().maps.erase(begin_);
    }
    if (begin_ != nullptr) ::munmap(begin_, mapped_);
  }

  bool is_permitted() const { return begin_ != nullptr && faults_.is_open() && stop_.is_open(); }
  std::span<const std::byte> bytes() const override { return {begin_, static_cast<std::size_t>(size_)}; }

  void set_blocks(BlockOf block_of, CheckBlock check) override {
    const std::unique_lock lock(blocks_mutex_);
    block_of_ = std::move(block_of);
    check_ = std::move(check);
  }

  void fetch(std::span<const std::byte> wanted) noexcept override {
    const auto first = static_cast<std::uint64_t>(wanted.data() - begin_);
    try {
      bring(*open_again(), first, std::min(first + wanted.size(), size_));
    } catch (...) {
      fail(std::current_exception());
    }
  }

  std::exception_ptr failure() {
    const std::scoped_lock lock(mutex_);
    return failure_;
  }

 private:
  enum class Page : std::uint8_t { missing, coming, there };
  using Block = std::pair<std::uint64_t, std::uint64_t>;  ///< begin and end, both multiples of a page

  /// For one thread. Errors: it is another version.
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
    if (!block_of_) return {offset / k_page * k_page, offset / k_page * k_page + k_page};
    const auto [begin, end] = block_of_(offset);
    return {begin, page_end(end)};
  }

  /// Marks the missing blocks from the one of `offset` on as coming, up to `end` or the first that is not missing.
  std::vector<Block> claim(std::uint64_t offset, std::uint64_t end) {
    constexpr std::uint64_t k_most = std::uint64_t{8} << 20;  // fetched by one request
    std::vector<Block> claimed;
    const std::scoped_lock lock(mutex_);
    while (offset < end && (claimed.empty() || claimed.back().second - claimed.front().first < k_most)) {
      const Block block = block_at(offset);
      if (pages_[static_cast<std::size_t>(offset / k_page)] != Page::missing) break;
      const auto begin = pages_.begin() + static_cast<std::ptrdiff_t>(block.first / k_page);
      std::fill(begin, begin + static_cast<std::ptrdiff_t>((block.second - block.first) / k_page),
                Page::coming);
      claimed.push_back(block);
      offset = block.second;
    }
    return claimed;
  }

  /// Lets all blocks arrive that have bytes in [begin, end) and are missing.
  void bring(RemoteFile& file, std::uint64_t begin, std::uint64_t end) {
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

  void receive(RemoteFile& file, const std::vector<Block>& blocks) {
    const std::uint64_t begin = blocks.front().first, end = blocks.back().second;
    std::vector<std::byte> bytes;
    try {
      bytes.resize(static_cast<std::size_t>(end - begin));
      if (!has_failed_)
        file.read(begin, std::span(bytes).first(static_cast<std::size_t>(std::min(end, size_) - begin)));
      check_blocks(blocks, bytes);
    } catch (...) {
      fail(std::current_exception());
    }
    store(begin, end, has_failed_ ? nullptr : bytes.data());
  }

  void check_blocks(const std::vector<Block>& blocks, std::span<const std::byte> bytes) {
    if (has_failed_) return;
    const std::shared_lock lock(blocks_mutex_);
    if (!check_) return;
    const std::uint64_t begin = blocks.front().first;
    for (const auto& [first, last] : blocks)
      check_(first, bytes.subspan(static_cast<std::size_t>(first - begin),
                                  static_cast<std::size_t>(std::min(last, size_) - first)));
  }

  /// Puts whole pages into the map, of zeros if `from` is null, and wakes the threads that wait for them.
  void store(std::uint64_t begin, std::uint64_t end, const std::byte* from) {
    for (std::uint64_t at = begin; at < end;) {
      ::uffdio_copy copy{.dst = reinterpret_cast<std::uint64_t>(begin_ + at),
                         .src = reinterpret_cast<std::uint64_t>(from + (at - begin)),
                         .len = end - at,
                         .mode = 0,
                         .copy = 0};
      ::uffdio_zeropage zeros{.range = {copy.dst, copy.len}, .mode = 0, .zeropage = 0};
      const int result = from != nullptr ? ::ioctl(faults_.number(), UFFDIO_COPY, &copy)
                                         : ::ioctl(faults_.number(), UFFDIO_ZEROPAGE, &zeros);
      if (result == 0) break;
      const std::int64_t placed = from != nullptr ? copy.copy : zeros.zeropage;
      if (placed > 0) {
        at += static_cast<std::uint64_t>(placed);
      } else if (errno == EEXIST) {
        at += k_page;  // it arrived alone, before there were blocks
      } else if (errno != EAGAIN) {
        std::terminate();  // threads would wait for ever
      }
    }
    const std::scoped_lock lock(mutex_);
    std::fill(pages_.begin() + static_cast<std::ptrdiff_t>(begin / k_page),
              pages_.begin() + static_cast<std::ptrdiff_t>(end / k_page), Page::there);
    arrived_.emplace_back(begin, end);
    arrived_bytes_ += end - begin;
    while (arrived_bytes_ > most_bytes_ && arrived_.size() > 1) drop_oldest();
  }

  /// Requires mutex_: pages that are there cannot be on their way meanwhile, and whose fault comes now will wait.
  void drop_oldest() {
    const auto [begin, end] = arrived_.front();
    arrived_.pop_front();
    arrived_bytes_ -= end - begin;
    ::madvise(begin_ + begin, end - begin, MADV_DONTNEED);
    std::fill(pages_.begin() + static_cast<std::ptrdiff_t>(begin / k_page),
              pages_.begin() + static_cast<std::ptrdiff_t>(end / k_page), Page::missing);
  }

  void fail(std::exception_ptr failure) {
    {
      const std::scoped_lock lock(mutex_);
      if (failure_) return;
      failure_ = failure;
    }
    const std::scoped_lock lock(registry().mutex);
    registry().new_failure = failure;
    has_failed_ = true;
    ++failures_;
  }

  void wake(std::uint64_t offset) {
    ::uffdio_range range{reinterpret_cast<std::uint64_t>(begin_ + offset / k_page * k_page), k_page};
    ::ioctl(faults_.number(), UFFDIO_WAKE, &range);
  }

  /// Whoever goes through the map gets ever more at once.
  std::uint64_t end_of_fault(std::uint64_t offset) {
    constexpr std::uint64_t k_most = std::uint64_t{8} << 20;
    const Block block = block_at(offset);
    const std::scoped_lock lock(mutex_);
    ahead_ = block.first == next_ ? std::min(2 * ahead_ + (block.second - block.first), k_most) : 0;
    next_ = std::min(block.second + ahead_, size_);
    return next_;
  }

  void serve() {
    std::unique_ptr<RemoteFile> file;
    while (!is_stopping_) {
      std::array<::pollfd, 2> waiting = {{{faults_.number(), POLLIN, 0}, {stop_.number(), POLLIN, 0}}};
      if (::poll(waiting.data(), waiting.size(), -1) <= 0) continue;
      ::uffd_msg message;
      if (::read(faults_.number(), &message, sizeof(message)) != sizeof(message)) continue;
      if (message.event != UFFD_EVENT_PAGEFAULT) continue;
      const auto offset = message.arg.pagefault.address - reinterpret_cast<std::uint64_t>(begin_);
      if (state_at(offset) != Page::missing) {
        // If it is coming, it wakes the threads itself; if it came between the fault and this message, it has not.
        if (state_at(offset) == Page::there) wake(offset);
        continue;
      }
      try {
        if (!file) file = open_again();
      } catch (...) {
        fail(std::current_exception());
      }
      const std::vector<Block> blocks = claim(offset, end_of_fault(offset));
      if (!blocks.empty())
        receive(*(file ? file : file_), blocks);
      else if (state_at(offset) == Page::there)
        wake(offset);
    }
  }

  Page state_at(std::uint64_t offset) {
    const std::scoped_lock lock(mutex_);
    return pages_[static_cast<std::size_t>(offset / k_page)];
  }

  const std::string name_;
  std::unique_ptr<RemoteFile> file_;
  const std::uint64_t most_bytes_;
  std::uint64_t size_ = 0, mapped_ = 0;
  std::byte* begin_ = nullptr;
  FileDescriptor faults_, stop_;
  std::array<std::thread, k_fetching_threads> threads_;
  std::atomic<bool> is_stopping_ = false, has_failed_ = false;
  mutable std::shared_mutex blocks_mutex_;
  BlockOf block_of_;
  CheckBlock check_;
  std::mutex mutex_;  ///< of all that follows
  std::vector<Page> pages_;
  std::deque<Block> arrived_;  ///< in their order
  std::uint64_t arrived_bytes_ = 0;
  std::exception_ptr failure_;
  std::uint64_t next_ = 0, ahead_ = 0;
};

}  // namespace

std::shared_ptr<RemoteMap> RemoteMap::open(const std::string& name, std::optional<std::uint64_t> most_bytes) {
  constexpr std::uint64_t k_unlimited = ~std::uint64_t{0};
  const std::uint64_t room = available_memory() ? *available_memory() / 2 : k_unlimited;
  auto map = std::make_shared<FaultingMap>(name, most_bytes.value_or(room));
  if (!map->is_permitted()) return nullptr;
  const std::scoped_lock lock(registry().mutex);
  registry().maps[map->bytes().data()] = map;
  return map;
}

std::shared_ptr<RemoteMap> RemoteMap::find(const void* address) {
  const auto* const byte = static_cast<const std::byte*>(address);
  std::shared_ptr<RemoteMap> map;  // given back without the lock
  const std::scoped_lock lock(registry().mutex);
  const auto after = registry().maps.upper_bound(byte);
  if (after == registry().maps.begin()) return nullptr;
  map = std::prev(after)->second.lock();
  return map && byte < map->bytes().data() + map->bytes().size() ? map : nullptr;
}

void RemoteMap::touch(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  const auto read = [](const volatile std::byte& byte) { [[maybe_unused]] const std::byte copy = byte; };
  for (std::size_t at = 0; at < bytes.size(); at += k_page) read(bytes[at]);
  read(bytes.back());
}

void RemoteMap::check_map(const void* address) {
  const std::shared_ptr<RemoteMap> map = find(address);
  const std::exception_ptr failure = map ? static_cast<FaultingMap&>(*map).failure() : nullptr;
  if (!failure) return;
  {
    const std::scoped_lock lock(registry().mutex);
    if (registry().new_failure == failure) registry().new_failure = nullptr;
  }
  std::rethrow_exception(failure);
}

void RemoteMap::check_new_failures() {
  std::exception_ptr failure;
  {
    const std::scoped_lock lock(registry().mutex);
    failure = std::exchange(registry().new_failure, nullptr);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace alidade
