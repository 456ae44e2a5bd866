// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade::geo {

// GDAL brings some 200 libraries: it is loaded when its first function is called, and is not linked.

/// A function of GDAL by its name. Thread safe. Errors: GDAL, or a library that it requires, is missing.
void* gdal_function(const char* name);

/// Loads GDAL, for callers that work for long before they write a map. Errors: those of gdal_function().
void load_gdal();

/// "GDAL 3.6.2": the library, with PROJ, that reads and writes maps and transforms between systems, of the
/// version whose headers were compiled. Does not load it.
std::string library_version();

}  // namespace alidade::geo
