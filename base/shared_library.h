// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade {

/// A library that is loaded when this is made, instead of when the program starts: some bring hundreds of
/// others, and take longer than the work of many commands. It stays loaded until the process ends.
class SharedLibrary {
 public:
  /// For messages, `problem` says what requires the library, and `remedy` how to get it. Errors: it is
  /// missing, or lacks a library itself. std::bad_alloc: the memory is not sufficient.
  SharedLibrary(const std::string& file, std::string problem, std::string remedy);

  /// A function by its name. Errors: the library has none.
  void* find(const char* function) const;

 private:
  [[noreturn]] void fail() const;

  std::string problem_, remedy_;
  void* library_ = nullptr;
};

}  // namespace alidade
