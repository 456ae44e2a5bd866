// SPDX-License-Identifier: MIT
#include <string>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/shown_text.h"
#include "cloud/crs.h"
#include "geo/crs_library.h"
#include "geo/gdal_library.h"
#include "jobs/remote_files.h"
#include "python/docstrings.h"
#include "python/python_cloud.h"
#include "python/python_jobs.h"

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

/// Without GDAL the text of reference systems is compared.
bool has_gdal() {
  static const bool has = [] {
    try {
      alidade::geo::load_gdal();
      return true;
    } catch (const alidade::Error&) {
      return false;
    }
  }();
  return has;
}

}  // namespace

PYBIND11_MODULE(_alidade, module) {
  // The docstrings have signatures of their own, without C++ types.
  py::options options;
  options.disable_function_signatures();
  module.doc() = alidade::python::k_module_doc;
  module.attr("__version__") = ALIDADE_VERSION;
  add_errors(module);
  alidade::keep_freed_memory();
  alidade::jobs::set_remote_user({.is_interrupted = &alidade::python::is_interrupted});
  alidade::use_crs_library(
      {.compare =
           [](const Crs& a, const Crs& b) {
             return has_gdal() ? alidade::geo::compare_systems(a, b) : compare_crs_text(a, b);
           },
       .wkt = [](const Crs& crs) { return has_gdal() ? alidade::geo::library_wkt(crs) : crs.wkt; }});
  alidade::python::add_cloud(module);
  alidade::python::add_images(module);
  alidade::python::PythonHooks extensions;
  alidade::python::add_extensions(extensions);
  alidade::python::add_jobs(module, extensions);
}
