// SPDX-License-Identifier: MIT
#include "database/sqlite/cloud_table.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "database/file_cloud.h"
#include "database/sqlite/chunk_store.h"
#include "database/sqlite/scan.h"
#include "database/sqlite/virtual_table.h"
#include "database/stored_column.h"

namespace alidade::database {
namespace {

struct Table {
  sqlite3_vtab base{};  // SQLite's part, which must be first
  sqlite3* database = nullptr;
  std::string schema, name;
  std::unique_ptr<FileCloud> files;  ///< null: the cloud is in the database
  CloudSchema cloud;
  TableColumns columns;
  ScanReads* reads;  ///< of the connection, or null

  Table(sqlite3* connection, std::string schema_name, std::string table_name,
        std::unique_ptr<FileCloud> cloud_files, ScanReads* all_reads)
      : database(connection),
        schema(std::move(schema_name)),
        name(std::move(table_name)),
        files(std::move(cloud_files)),
        cloud(files ? files->schema() : read_cloud_schema(database, schema, name)),
        columns(cloud.columns),
        reads(all_reads) {}

  int best_index(sqlite3_index_info& info) const { return choose_plan(columns, cloud.point_count, info); }
};

struct Cursor {
  sqlite3_vtab_cursor base{};  // SQLite's part, which must be first
  const Table& table;
  std::unique_ptr<ChunkStore> store;  ///< null: all scans share one source
  ChunkSource& source;
  Arguments arguments;
  std::optional<PointCursor> points;

  explicit Cursor(const Table& from)
      : table(from),
        store(from.files ? nullptr
                         : std::make_unique<ChunkStore>(from.database, from.schema, from.name, from.cloud)),
        source(from.files ? from.files->source() : *store) {
    if (table.files) table.files->check_unchanged();
  }
  ~Cursor() { end_scan(); }
  Cursor(const Cursor&) = delete;
  Cursor& operator=(const Cursor&) = delete;

  void end_scan() {
    if (points && table.reads != nullptr) *table.reads += points->reads();
    points.reset();
  }

  void filter(int order, const char* plan, std::span<sqlite3_value* const> values) {
    end_scan();
    if (table.reads != nullptr) *table.reads += {.scans = 1, .chunks = table.cloud.chunk_count};
    const std::optional<ScanFilter> wanted = plan_filter(plan, values, arguments);
    if (wanted) points.emplace(source, table.cloud, *wanted, static_cast<RowOrder>(order));
  }

  void next() { points->next(); }
  bool at_end() const noexcept { return !points || points->at_end(); }

  sqlite3_int64 row_id() const noexcept {
    return static_cast<sqlite3_int64>(points->chunk().id << k_row_bits | points->row());
  }

  void column(sqlite3_context* context, int number) {
    const TableColumns::Kind kind = table.columns.kind(number);
    if (kind == TableColumns::Kind::stored) {
      const StoredColumn& stored = table.columns.stored(number);
      set_result(context, stored_value(stored, source.bytes(points->chunk(), stored, points->row())));
    } else if (kind == TableColumns::Kind::axis) {
      sqlite3_result_double(context, points->position()[table.columns.axis(number)]);
    } else if (kind == TableColumns::Kind::chunk) {
      sqlite3_result_int64(context, static_cast<sqlite3_int64>(points->chunk().id));
    } else if (!arguments) {
      throw Error({.problem = "dist, t and ox to dz are columns of a ray", .expected = k_ray_form});
    } else if (kind == TableColumns::Kind::argument) {
      sqlite3_result_double(context, (*arguments)[table.columns.argument(number)]);
    } else {
      const RayProjection at = *points->projection();
      sqlite3_result_double(context, kind == TableColumns::Kind::t ? at.t : at.distance);
    }
  }
};

/// Declares a table to SQLite. `columns`: the origin of the columns, for messages.
void declare(std::unique_ptr<Table> table, const std::string& columns, sqlite3_vtab** made) {
  sqlite3* const database = table->database;
  const int count = table->columns.size(), most = sqlite3_limit(database, SQLITE_LIMIT_COLUMN, -1);
  if (count > most) {
    throw file_error(columns, "too many columns for a table of SQLite",
                     fmt::format("at most {}, with x, y, z and {} hidden ones", most, TableColumns::k_hidden),
                     std::to_string(count));
  }
  const int result = sqlite3_declare_vtab(database, table->columns.declaration().c_str());
  if (result != SQLITE_OK) {
    throw SqliteError(
        result,
        {.file = file_of(database, table->schema), .location = columns, .problem = sqlite3_errmsg(database)});
  }
  // A table of a cloud in the database reads nothing but tables, whatever the file contains. Cloud files are
  // read only for a statement of the user, not for a view or trigger.
  sqlite3_vtab_config(database, table->files ? SQLITE_VTAB_DIRECTONLY : SQLITE_VTAB_INNOCUOUS);
  *made = &table.release()->base;
}

int connect(sqlite3* database, void* reads, int count, const char* const* words, sqlite3_vtab** made,
            char** message) {
  return guarded(
      [&] {
        check_that(count <= 3, "pointcloud takes no arguments", "USING pointcloud");
        auto table =
            std::make_unique<Table>(database, words[1], words[2], nullptr, static_cast<ScanReads*>(reads));
        const std::string columns = "table " + table->name + "_column";
        declare(std::move(table), columns, made);
      },
      [&](const char* text) { keep_message(message, text); });
}

/// Not connect() itself: a module whose xCreate is its xConnect has an eponymous table, which exists without
/// CREATE VIRTUAL TABLE.
int create(sqlite3* database, void* reads, int count, const char* const* words, sqlite3_vtab** made,
           char** message) {
  return connect(database, reads, count, words, made, message);
}

/// The text of a literal of SQL. Errors: anything else.
std::string literal_text(std::string_view literal) {
  const TokenList tokens(literal);
  check_that(tokens.size() == 1 && tokens.is(0, SqlTokenKind::text) && tokens.text(0).size() > 2,
             "invalid argument of alidade", "a quoted file name: USING alidade('site.laz')",
             std::string(literal));
  return unquoted(tokens.text(0));
}

/// Opening a database must not open files that its author chose. Errors: a table of files does not belong to
/// this connection alone.
void check_owner(sqlite3* database, const std::string& schema, const std::string& table, bool is_new) {
  if (schema == "temp") return;
  // A database in memory may come from elsewhere, too (sqlite3_deserialize()).
  int is_trusted = 0;
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, -1, &is_trusted);
  const std::string file = file_of(database, schema);
  if (file.empty() && (is_new || is_trusted != 0)) return;
  throw SqliteError(SQLITE_AUTH, {.file = file,
                                  .location = {},
                                  .problem = "the table " + table + " would let a database open files",
                                  .expected = "CREATE VIRTUAL TABLE temp." + sql_name(table)});
}

int open_files(sqlite3* database, const void* context, std::span<const char* const> words, bool is_new,
               sqlite3_vtab** made, char** message) {
  return guarded(
      [&] {
        static const FileTables k_plain;
        const FileTables& tables = context == nullptr ? k_plain : *static_cast<const FileTables*>(context);
        const std::string schema = words[1], name = words[2];
        check_owner(database, schema, name, is_new);
        std::vector<std::filesystem::path> files;
        for (const char* const word : words.subspan(3)) files.emplace_back(literal_text(word));
        check_that(!files.empty(), "missing argument of alidade",
                   "a quoted file name: USING alidade('site.laz')");
        auto cloud = std::make_unique<FileCloud>(files, tables);
        if (tables.warn) {
          std::vector<std::string> warnings = cloud->warnings();
          for (const char* const column : {"dist", "t"}) {
            const std::string moved = line_column(cloud->schema().columns, column);
            if (moved != column)
              warnings.push_back(
                  fmt::format("{0}: {1} is an attribute of the cloud; the {1} of a line is {2}",
                              files.front().string(), column, moved));
          }
          tables.warn(warnings);
        }
        declare(std::make_unique<Table>(database, schema, name, std::move(cloud), tables.reads),
                files.front().string(), made);
      },
      [&](const char* text) { keep_message(message, text); });
}

int create_files(sqlite3* database, void* context, int count, const char* const* words, sqlite3_vtab** made,
                 char** message) {
  return open_files(database, context, std::span(words, static_cast<std::size_t>(count)), true, made,
                    message);
}

int connect_files(sqlite3* database, void* context, int count, const char* const* words, sqlite3_vtab** made,
                  char** message) {
  return open_files(database, context, std::span(words, static_cast<std::size_t>(count)), false, made,
                    message);
}

int rename_files(sqlite3_vtab*, const char*) {
  return SQLITE_OK;
}

int rename(sqlite3_vtab* base, const char* name) {
  return table_guarded(base, [&] {
    const Table& table = table_of<Table>(base);
    rename_cloud_tables(table.database, table.schema, table.name, name);
  });
}

int destroy(sqlite3_vtab* base) {
  const int result = table_guarded(base, [&] {
    const Table& table = table_of<Table>(base);
    drop_cloud_tables(table.database, table.schema, table.name);
  });
  if (result == SQLITE_OK) delete &table_of<Table>(base);
  return result;
}

/// Makes in_chunk(_chunk, limit) a constraint that best_index() gets.
int find_function(sqlite3_vtab*, int count, const char* name,
                  void (**function)(sqlite3_context*, int, sqlite3_value**), void** context) {
  if (count != 2 || sqlite3_stricmp(name, "in_chunk") != 0) return 0;
  *function = in_chunk;
  *context = nullptr;
  return SQLITE_INDEX_CONSTRAINT_FUNCTION;
}

/// Whether a table is a shadow table, which ordinary SQL cannot write in SQLite's defensive mode.
int is_shadow(const char* name) {
  for (const char* const part : k_cloud_table_parts) {
    if (sqlite3_stricmp(name, part) == 0) return 1;
  }
  return 0;
}

const sqlite3_module k_module = [] {
  sqlite3_module module = reading_module<Table, Cursor>();
  module.iVersion = 3;
  module.xCreate = create;
  module.xConnect = connect;
  module.xDestroy = destroy;
  module.xFindFunction = find_function;
  module.xRename = rename;
  module.xShadowName = is_shadow;
  return module;
}();

/// Tables of cloud files, which have no shadow tables.
const sqlite3_module k_file_module = [] {
  sqlite3_module module = k_module;
  module.xCreate = create_files;
  module.xConnect = connect_files;
  module.xDestroy = module.xDisconnect;
  module.xRename = rename_files;
  module.xShadowName = nullptr;
  return module;
}();

}  // namespace

int add_cloud_table(sqlite3* database, ScanReads* reads) {
  return sqlite3_create_module_v2(database, "pointcloud", &k_module, reads, nullptr);
}

int add_file_tables(sqlite3* database, const FileTables* tables) {
  return sqlite3_create_module_v2(database, "alidade", &k_file_module, const_cast<FileTables*>(tables),
                                  nullptr);
}

}  // namespace alidade::database
