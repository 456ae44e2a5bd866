// SPDX-License-Identifier: MIT
#include <dlfcn.h>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/allowed_hosts.h"
#include "base/error.h"
#include "base/input_file.h"
#include "base/shown_text.h"
#include "cloud/crs.h"
#include "python/docstrings.h"
#include "python/python_cloud.h"

namespace {

using alidade::Crs;

namespace py = pybind11;

/// Error and Cancelled of C++ as exceptions of Python.
void add_errors(py::module_& module) {
  static py::exception<alidade::Error> error(module, "Error", PyExc_ValueError);
  error.attr("__doc__") =
      "Invalid input: a file, an array or a request. The text names what was found and what is expected.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const alidade::Error& invalid) {
      error(alidade::line_text(invalid.what()).c_str());
    } catch (const alidade::Cancelled&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    }
  });
}

/// A function of the module remote_files.so beside this one, which is loaded with GDAL and its libraries when
/// the first is needed: for a remote file, or to compare systems. Null without it; `reason` is then the
/// loader's message.
void* function_with_gdal(const char* name, std::string& reason) {
  static void* const library = [] {
    ::Dl_info info{};
    ::dladdr(reinterpret_cast<const void*>(&function_with_gdal), &info);
    const std::filesystem::path file =
        std::filesystem::path(info.dli_fname).parent_path() / "remote_files.so";
    return ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  }();
  void* const found = library != nullptr ? ::dlsym(library, name) : nullptr;
  const char* const text = found == nullptr ? ::dlerror() : nullptr;
  reason = text != nullptr ? text : "";
  return found;
}

std::unique_ptr<alidade::RemoteFile> open_remote(const std::string& name) {
  using Open = std::unique_ptr<alidade::RemoteFile>(const std::string&, bool (*)(),
                                                    const std::optional<std::vector<std::string>>&);
  std::string reason;
  auto* const open = reinterpret_cast<Open*>(function_with_gdal("alidade_open_remote_file", reason));
  if (open == nullptr)
    throw alidade::file_error(
        name, "this package of alidade opens no remote files (wheels do not)",
        "a file on this machine, or the module alidade of the Debian package or of a build", reason);
  return open(name, &alidade::python::is_interrupted, alidade::hosts_for(name));
}

/// The functions of reference systems. Wheels, without GDAL, compare the text of systems.
const alidade::CrsLibrary& systems() {
  static const alidade::CrsLibrary library = [] {
    using Get = const alidade::CrsLibrary*();
    std::string reason;
    auto* const get = reinterpret_cast<Get*>(function_with_gdal("alidade_crs_library", reason));
    if (get != nullptr) return *get();
    return alidade::CrsLibrary{
        .compare = [](const Crs& a, const Crs& b) { return std::optional(compare_crs_text(a, b)); },
        .wkt = [](const Crs& crs) { return crs.wkt; }};
  }();
  return library;
}

}  // namespace

PYBIND11_MODULE(_alidade, module) {
  // The docstrings have signatures of their own, without C++ types.
  py::options options;
  options.disable_function_signatures();
  module.doc() = alidade::python::k_module_doc;
  module.attr("__version__") = ALIDADE_VERSION;
  add_errors(module);
  alidade::set_remote_files(&open_remote);
  alidade::use_crs_library({.compare = [](const Crs& a, const Crs& b) { return systems().compare(a, b); },
                            .wkt = [](const Crs& crs) { return systems().wkt(crs); }});
  alidade::python::add_cloud(module);
  alidade::python::add_images(module);
}
