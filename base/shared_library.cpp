// SPDX-License-Identifier: MIT
#include "base/shared_library.h"

#include <dlfcn.h>
#include <new>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace alidade {

SharedLibrary::SharedLibrary(const std::string& file, std::string problem, std::string remedy)
    : problem_(std::move(problem)),
      remedy_(std::move(remedy)),
      library_(::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
  if (library_ == nullptr) fail();
}

void* SharedLibrary::find(const char* function) const {
  void* const found = ::dlsym(library_, function);
  if (found == nullptr) fail();
  return found;
}

void SharedLibrary::fail() const {
  const char* const reason = ::dlerror();
  const std::string_view text = reason != nullptr ? reason : "";
  // The loader's message depends on the step at which memory has run out.
  for (const char* const sign :
       {"annot allocate memory", "failed to map segment", "cannot create shared object"})
    if (text.find(sign) != text.npos) throw std::bad_alloc();
  throw input_error(problem_, remedy_, std::string(text));
}

}  // namespace alidade
