// SPDX-License-Identifier: MIT
#pragma once

// The SQLite that the program is linked with or, in the loadable module, that of the program that loads it.

#ifdef ALIDADE_SQLITE_MODULE
#include <sqlite3ext.h>
SQLITE_EXTENSION_INIT3
#else
#include <sqlite3.h>
#endif
