// SPDX-License-Identifier: MIT
#include "tools/image_module.h"

#include <dlfcn.h>
#include <filesystem>
#include <new>
#include <string_view>

#include "base/error.h"
#include "base/remote_map.h"

namespace alidade::tools {
namespace {

/// Where the module is: beside the program as it is built, else where both are installed.
std::filesystem::path module_file() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::canonical("/proc/self/exe", error).parent_path();
  const std::filesystem::path beside = folder / ALIDADE_IMAGE_MODULE;
  return std::filesystem::exists(beside, error) ? beside
                                                : folder / ALIDADE_MODULE_FOLDER / ALIDADE_IMAGE_MODULE;
}

[[noreturn]] void fail(const std::filesystem::path& file) {
  const char* const reason = ::dlerror();
  const std::string_view text = reason != nullptr ? reason : "";
  // The loader's message depends on the step at which memory has run out.
  for (const char* const sign :
       {"annot allocate memory", "failed to map segment", "cannot create shared object"})
    if (text.find(sign) != text.npos) throw std::bad_alloc();
  throw Error({.file = file.string(),
               .problem = std::string("cannot load the module for images and maps: ") +
                          (reason != nullptr ? reason : "unknown reason")});
}

}  // namespace

const ImageModule& image_module() {
  RemoteMap::check_all();
  static const ImageModule& module = []() -> const ImageModule& {
    const std::filesystem::path file = module_file();
    void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) fail(file);
    void* const function = ::dlsym(library, "alidade_image_module");
    if (function == nullptr) fail(file);
    return *reinterpret_cast<const ImageModule* (*)()>(function)();
  }();
  return module;
}

}  // namespace alidade::tools
