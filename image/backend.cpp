// SPDX-License-Identifier: MIT
#include "image/backend.h"

#include <dlfcn.h>
#include <link.h>
#include <filesystem>

#include "base/shared_library.h"

namespace alidade::image {
namespace {

/// The file of the program or shared library that contains this code; empty if it cannot be found.
std::filesystem::path own_file() {
  Dl_info facts;
  void* object = nullptr;
  if (::dladdr1(reinterpret_cast<const void*>(&backend), &facts, &object, RTLD_DL_LINKMAP) == 0) return {};
  // The loader has no name for the program.
  const char* const name = static_cast<const link_map*>(object)->l_name;
  std::error_code error;
  return std::filesystem::canonical(*name == '\0' ? "/proc/self/exe" : name, error);
}

std::string module_file() {
  const std::filesystem::path own = own_file();
  std::error_code error;
  for (const char* const folder : {".", ALIDADE_MODULE_FOLDER}) {
    const std::filesystem::path file = own.parent_path() / folder / ALIDADE_IMAGE_MODULE;
    if (!own.empty() && std::filesystem::exists(file, error)) return file.string();
  }
  // Programs that are linked with the installed libraries have a run path to it.
  return ALIDADE_IMAGE_MODULE;
}

}  // namespace

const Backend& backend() {
  static const Backend& backend = []() -> const Backend& {
    const SharedLibrary module(module_file(), "image files and legends require OpenImageIO and FreeType",
                               ALIDADE_IMAGE_MODULE
                               " and the packages libopenimageio" ALIDADE_OPENIMAGEIO_SERIES
                               " and libfreetype6");
    return *reinterpret_cast<const Backend* (*)()>(module.find("alidade_image_backend"))();
  }();
  return backend;
}

}  // namespace alidade::image
