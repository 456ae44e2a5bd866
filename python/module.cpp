// SPDX-License-Identifier: MIT
#include "python/docstrings.h"
#include "python/python_cloud.h"

namespace {

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
      error(invalid.what());
    } catch (const alidade::Cancelled&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    }
  });
}

}  // namespace

PYBIND11_MODULE(_alidade, module) {
  // The signatures of the manual are those that people write.
  py::options options;
  options.disable_function_signatures();
  module.doc() = alidade::python::k_module_doc;
  module.attr("__version__") = ALIDADE_VERSION;
  add_errors(module);
  alidade::python::add_cloud(module);
  alidade::python::add_pictures(module);
}
