// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

// Image formats, map formats and reference systems come through OpenImageIO and GDAL, which bring some 250
// libraries: loading them takes longer, and more memory, than all the work of most commands. So they stand in
// a module beside the program, and only who needs them loads it.

/// The function of that name in the module, which stays loaded. Errors: the module is not where the program
/// was built or installed, or it lacks a library.
void* load_module_function(const char* name);

/// The same as a pointer to a function of that type.
template <class Function>
Function load_module_function(const char* name) {
  return reinterpret_cast<Function>(load_module_function(name));
}

}  // namespace alidade
