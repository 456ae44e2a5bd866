// SPDX-License-Identifier: MIT
#include "tools/image_writer.h"

#include <dlfcn.h>

#include "octree/error.h"

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
               .problem = "pictures cannot be written without this part of the program",
               .found = reason != nullptr ? reason : "nothing"});
}

/// The function of that name in the module.
void* load_function(const char* name) {
  const std::filesystem::path file = module_file();
  void* const module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) fail(file);
  void* const function = ::dlsym(module, name);
  if (function == nullptr) fail(file);
  return function;
}

}  // namespace

ImageWriter load_image_writer() {
  return reinterpret_cast<ImageWriter>(load_function("alidade_write_image"));
}

LegendWriter load_legend_writer() {
  return reinterpret_cast<LegendWriter>(load_function("alidade_write_legend"));
}

SkyImageReader load_sky_image_reader() {
  return reinterpret_cast<SkyImageReader>(load_function("alidade_read_sky_image"));
}

SunPlacer load_sun_placer() {
  return reinterpret_cast<SunPlacer>(load_function("alidade_place_sun"));
}

}  // namespace alidade
