// SPDX-License-Identifier: MIT
#include "tools/load_module.h"

#include <dlfcn.h>

#include <filesystem>

#include "base/error.h"

namespace alidade {
namespace {

/// Where the module is: beside the program as it is built, or where both are installed.
std::filesystem::path module_file() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::canonical("/proc/self/exe", error).parent_path();
  const std::filesystem::path installed = folder / ALIDADE_MODULE_FOLDER / ALIDADE_IMAGE_MODULE;
  return std::filesystem::exists(installed, error) ? installed : folder / ALIDADE_IMAGE_MODULE;
}

[[noreturn]] void fail(const std::filesystem::path& file) {
  const char* const reason = ::dlerror();
  throw Error({.file = file.string(),
               .problem = "pictures and maps cannot be read or written without this part of the program",
               .found = reason != nullptr ? reason : "nothing"});
}

}  // namespace

void* load_module_function(const char* name) {
  const std::filesystem::path file = module_file();
  void* const module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) fail(file);
  void* const function = ::dlsym(module, name);
  if (function == nullptr) fail(file);
  return function;
}

}  // namespace alidade
