// SPDX-License-Identifier: MIT
#include "python/python_arrays.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <future>
#include <thread>

namespace alidade::python {
namespace {

std::string type_text(const py::array& array) {
  return py::str(array.dtype()).cast<std::string>();
}

/// Any object as an array of any type. Errors: NumPy cannot convert it.
py::array array_of(const py::handle& given, const char* name) {
  py::array array = py::array::ensure(given);
  if (!array) {
    PyErr_Clear();
    throw input_error(fmt::format("{} is not an array", name), "an array of numbers",
                      py::str(py::type::handle_of(given).attr("__name__")).cast<std::string>());
  }
  return array;
}

/// Real numbers: signed, unsigned, floating point.
Doubles doubles_of(const py::array& array, const char* name) {
  const char kind = array.dtype().kind();
  const bool is_real = kind == 'f' || kind == 'i' || kind == 'u';
  Doubles numbers = is_real ? Doubles::ensure(array) : Doubles();
  if (!is_real || !numbers)
    throw input_error(fmt::format("{} is not an array of real numbers", name),
                      "an array of floating-point or whole numbers",
                      fmt::format("dtype {} of shape {}", type_text(array), shape_text(array)));
  return numbers;
}

std::atomic<bool> has_interruption = false;
std::atomic<void (*)(int)> python_handler = nullptr;

void note_interruption(int signal) {
  has_interruption = true;
  if (const auto next = python_handler.load()) next(signal);
}

}  // namespace

std::string shape_text(const py::array& array) {
  const Shape shape(array.shape(), array.shape() + array.ndim());
  return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

Doubles real_numbers(const py::handle& given, const char* name) {
  return doubles_of(array_of(given, name), name);
}

Doubles numbers_of(const py::handle& given, const char* name, std::initializer_list<py::ssize_t> widths) {
  const py::array array = array_of(given, name);
  const bool fits =
      array.ndim() > 0 && std::ranges::find(widths, array.shape(array.ndim() - 1)) != widths.end();
  if (!fits)
    throw input_error(fmt::format("{} has the wrong shape", name),
                      fmt::format("(..., {})", fmt::join(widths, " or ")),
                      fmt::format("shape {}, dtype {}", shape_text(array), type_text(array)));
  return doubles_of(array, name);
}

Shape leading_shape(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim() - 1};
}

void watch_interruption() {
  has_interruption = false;
  struct sigaction now {};
  if (::sigaction(SIGINT, nullptr, &now) != 0 || (now.sa_flags & SA_SIGINFO) != 0) return;
  if (now.sa_handler == SIG_IGN || now.sa_handler == SIG_DFL || now.sa_handler == &note_interruption) return;
  // A second time only if Python's own handler is back: another handler may call this one.
  void (*known)(int) = nullptr;
  if (!python_handler.compare_exchange_strong(known, now.sa_handler) && known != now.sa_handler) return;
  now.sa_handler = &note_interruption;
  ::sigaction(SIGINT, &now, nullptr);
}

bool is_interrupted() {
  return has_interruption;
}

void raise_interruption(const Error& otherwise) {
  if (PyErr_Occurred() != nullptr || PyErr_CheckSignals() != 0) throw py::error_already_set();
  throw otherwise;
}

void run_interruptible(int workers, const std::function<void(const Progress&)>& work) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds k_between_looks(50);
  const std::thread::id caller = std::this_thread::get_id();
  Clock::time_point last_look = Clock::now();
  bool ends = false;
  const Progress progress = [&](std::uint64_t, std::uint64_t) {
    if (!ends && std::this_thread::get_id() == caller && Clock::now() - last_look >= k_between_looks) {
      const py::gil_scoped_acquire acquire;
      ends = PyErr_CheckSignals() != 0;
      last_look = Clock::now();
    }
    return !ends;
  };
  run_free(workers, [&] { work(progress); });
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void run_watched(int workers, const py::object& watch, const std::function<void(const Progress&)>& work) {
  constexpr std::chrono::milliseconds k_between_looks(50);
  std::atomic<bool> ends = false;
  std::exception_ptr raised;
  const auto keep_raised = [&] {
    if (!raised) raised = std::current_exception();
    ends = true;
  };
  const Progress progress = [&](std::uint64_t done, std::uint64_t total) {
    if (!ends && !watch.is_none()) {
      const py::gil_scoped_acquire acquire;
      try {
        watch(done, total);
      } catch (...) {
        keep_raised();
      }
    }
    return !ends;
  };
  watch_interruption();
  // Only the calling thread notices signals.
  std::future<void> result =
      std::async(std::launch::async, [&] { on_threads(workers, [&] { work(progress); }); });
  for (bool is_done = false; !is_done;) {
    {
      const py::gil_scoped_release release;
      is_done = result.wait_for(k_between_looks) == std::future_status::ready;
    }
    if (ends || PyErr_CheckSignals() == 0) continue;
    try {
      throw py::error_already_set();
    } catch (...) {
      keep_raised();
    }
  }
  try {
    result.get();
  } catch (const Cancelled&) {
    if (raised) std::rethrow_exception(raised);
    raise_interruption(Error({.problem = "the work was interrupted by Ctrl-C before its end"}));
  }
  if (raised) std::rethrow_exception(raised);
}

}  // namespace alidade::python
