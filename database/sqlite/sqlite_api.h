// SPDX-License-Identifier: MIT
#pragma once

// SQLite as the program links it, or, inside the loadable module, as whoever loads the module hands it over.

#ifdef ALIDADE_SQLITE_MODULE
#include <sqlite3ext.h>
SQLITE_EXTENSION_INIT3
#else
#include <sqlite3.h>
#endif
