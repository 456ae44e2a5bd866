// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "base/progress.h"

// NumPy arrays in and out.

namespace alidade::python {

namespace py = pybind11;

using Shape = std::vector<py::ssize_t>;

/// Numbers of any kind as consecutive doubles; copied only if they are not.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// One of the named tuples of alidade/_answers.py.
inline py::object answer_type(const char* name) {
  return py::module_::import("alidade._answers").attr(name);
}

/// A text of a file, of any encoding: bytes that are not UTF-8 become surrogates, as in names of files.
inline py::str text_of(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape"));
}

/// "(100, 3)".
std::string shape_text(const py::array& array);

/// An array of real numbers as doubles. Errors: Error with shape and type of what was found.
Doubles real_numbers(const py::handle& given, const char* name);

/// An array of numbers whose last dimension is one of `widths`, such as (..., 3). Errors: Error with shape
/// and type of what was found, also for everything that NumPy does not convert to real numbers.
Doubles numbers_of(const py::handle& given, const char* name, std::initializer_list<py::ssize_t> widths);

/// The shape without its last dimension.
Shape leading_shape(const py::array& array);

/// Rows of three doubles as positions, without copying. Requires: the last dimension is 3.
inline std::span<const glm::dvec3> as_positions(const Doubles& array) {
  static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
  return {reinterpret_cast<const glm::dvec3*>(array.data()), static_cast<std::size_t>(array.size() / 3)};
}

/// The values that `owner` keeps alive, without copying and read-only.
template <class T>
py::array view_of(const T* values, Shape shape, Shape strides, const py::handle& owner) {
  py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), values, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

template <class T>
py::array view_of(std::span<const T> values, const py::handle& owner) {
  return view_of(values.data(), {static_cast<py::ssize_t>(values.size())}, {sizeof(T)}, owner);
}

/// Calls work() on so many threads, no more than the machine has; on all of them where `workers` is below 1.
template <class Work>
void on_threads(int workers, const Work& work) {
  if (workers < 1) return work();
  tbb::task_arena(std::min(workers, tbb::info::default_concurrency())).execute(work);
}

/// Begins to watch for Ctrl-C, and forgets earlier ones.
void watch_interruption();
/// Whether Ctrl-C came since then. For threads that wait for servers: Python handles signals in its main
/// thread only.
bool is_interrupted();

/// Raises what Ctrl-C raises in Python, after Cancelled was thrown. Errors: `otherwise`, if no exception is
/// pending: Ctrl-C came before, its handler ignored it, or another thread handles it.
[[noreturn]] void raise_interruption(const Error& otherwise);

/// on_threads() without the GIL. Raises Ctrl-C if that ended a wait for a server.
template <class Work>
void run_free(int workers, const Work& work) {
  watch_interruption();
  try {
    const py::gil_scoped_release release;
    on_threads(workers, work);
    return;
  } catch (const Cancelled&) {
  }
  raise_interruption(input_error("the wait for a server was interrupted", "the cloud, opened again"));
}

/// Calls work(progress) in a thread of its own without the GIL, and waits for it. `progress` calls
/// watch(done, total) unless `watch` is None. Exceptions of `watch`, and Ctrl-C, end the work and are raised
/// here.
void run_watched(int workers, const py::object& watch, const std::function<void(const Progress&)>& work);

/// Calls work(progress) without the GIL, on this thread and others. Ctrl-C ends it when it reports its
/// progress from this thread.
void run_interruptible(int workers, const std::function<void(const Progress&)>& work);

/// Calls work(begin, end) for pieces of `count` items without the GIL. Ctrl-C is noticed between pieces,
/// whose size follows from the time of earlier pieces, so that each takes about a tenth of a second at most.
template <class Work>
void in_pieces(int workers, std::size_t count, const Work& work) {
  constexpr std::size_t k_largest = std::size_t{1} << 17;  // rays and hits of a piece stay in the caches
  PieceSize piece({.first = k_largest / 16, .least = 64, .most = k_largest});
  for (std::size_t begin = 0, end; begin < count; begin = end) {
    end = begin + std::min(count - begin, piece.next());
    const PieceSize::Clock::time_point start = PieceSize::Clock::now();
    run_free(workers, [&] { work(begin, end); });
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    piece.learn(end - begin, PieceSize::Clock::now() - start);
  }
}

/// The numbers that a thread takes at a time in loops over arrays.
inline constexpr std::size_t k_array_grain = 4096;

}  // namespace alidade::python
