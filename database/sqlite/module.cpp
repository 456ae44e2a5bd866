// SPDX-License-Identifier: MIT
// The loadable extension for the sqlite3 shell, Python and Alidade's own program: .load ./libalidade_sqlite
#include <sqlite3ext.h>

#include "database/sqlite/cloud_table.h"
#include "database/sqlite/functions.h"

SQLITE_EXTENSION_INIT1

extern "C" __attribute__((visibility("default"))) int sqlite3_alidadesqlite_init(
    sqlite3* database, char** message, const sqlite3_api_routines* routines) {
  SQLITE_EXTENSION_INIT2(routines);
  constexpr int k_oldest = 3038000;  // the oldest that was tested
  if (sqlite3_libversion_number() < k_oldest) {
    *message = sqlite3_mprintf("alidade requires SQLite 3.38 or later, not %s", sqlite3_libversion());
    return SQLITE_ERROR;
  }
  int result = alidade::database::add_functions(database);
  if (result == SQLITE_OK) result = alidade::database::add_cloud_table(database);
  return result == SQLITE_OK ? alidade::database::add_file_tables(database) : result;
}
