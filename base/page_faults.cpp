// SPDX-License-Identifier: MIT
#include "base/page_faults.h"

#include <fcntl.h>
#include <linux/userfaultfd.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <cstdint>
#include <exception>

namespace alidade {
namespace {

std::uint64_t address_of(const std::byte* byte) {
  return reinterpret_cast<std::uint64_t>(byte);
}

}  // namespace

bool PageFaults::open(std::span<std::byte> map) {
#ifndef UFFD_USER_MODE_ONLY
  constexpr int UFFD_USER_MODE_ONLY = 1;
#endif
  faults_ = FileDescriptor(
      static_cast<int>(::syscall(SYS_userfaultfd, O_CLOEXEC | O_NONBLOCK | UFFD_USER_MODE_ONLY)));
  stop_ = FileDescriptor(::eventfd(0, EFD_CLOEXEC));
  if (!faults_.is_open() || !stop_.is_open()) return false;
  ::uffdio_api api{.api = UFFD_API, .features = 0, .ioctls = 0};
  ::uffdio_register range{
      .range = {address_of(map.data()), map.size()}, .mode = UFFDIO_REGISTER_MODE_MISSING, .ioctls = 0};
  return ::ioctl(faults_.number(), UFFDIO_API, &api) == 0 &&
         ::ioctl(faults_.number(), UFFDIO_REGISTER, &range) == 0;
}

const std::byte* PageFaults::next() {
  while (!is_stopping_) {
    std::array<::pollfd, 2> waiting = {{{faults_.number(), POLLIN, 0}, {stop_.number(), POLLIN, 0}}};
    if (::poll(waiting.data(), waiting.size(), -1) <= 0) continue;
    ::uffd_msg message;
    if (::read(faults_.number(), &message, sizeof(message)) != sizeof(message)) continue;
    if (message.event == UFFD_EVENT_PAGEFAULT)
      return reinterpret_cast<const std::byte*>(message.arg.pagefault.address);
  }
  return nullptr;
}

void PageFaults::stop() {
  is_stopping_ = true;
  constexpr std::uint64_t k_one = 1;
  [[maybe_unused]] const ::ssize_t written = ::write(stop_.number(), &k_one, sizeof(k_one));
}

void PageFaults::fill(std::span<std::byte> pages, const std::byte* from) {
  while (!pages.empty()) {
    ::uffdio_copy copy{
        .dst = address_of(pages.data()), .src = address_of(from), .len = pages.size(), .mode = 0, .copy = 0};
    ::uffdio_zeropage zeros{.range = {copy.dst, copy.len}, .mode = 0, .zeropage = 0};
    const int result = from != nullptr ? ::ioctl(faults_.number(), UFFDIO_COPY, &copy)
                                       : ::ioctl(faults_.number(), UFFDIO_ZEROPAGE, &zeros);
    if (result == 0) return;
    std::int64_t placed = from != nullptr ? copy.copy : zeros.zeropage;
    if (placed <= 0) {
      if (errno == EAGAIN) continue;
      if (errno != EEXIST) std::terminate();  // threads would wait forever
      placed = k_fault_page;                  // it was filled alone before
    }
    pages = pages.subspan(static_cast<std::size_t>(placed));
    if (from != nullptr) from += placed;
  }
}

void PageFaults::wake(const std::byte* page) {
  ::uffdio_range range{address_of(page) / k_fault_page * k_fault_page, k_fault_page};
  ::ioctl(faults_.number(), UFFDIO_WAKE, &range);
}

}  // namespace alidade
