// SPDX-License-Identifier: MIT
#include "database/server/shard_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "database/server/server_column.h"
#include "database/sql_name.h"

namespace alidade {
namespace {

/// What every script begins with: an error ends it, and nothing that it did stays. Whatever the client's
/// settings say, names and texts end where they end here.
constexpr const char* k_head =
    "\\set ON_ERROR_STOP on\n\\set QUIET on\n\\encoding UTF8\nSET standard_conforming_strings = on;\n"
    "SET client_min_messages = warning;\nBEGIN;\n";

/// Numbers are written such that reading gives the same ones.
std::string box_check(const Bounds& box) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    text += fmt::format("{}{} >= '{}'::float8 AND {} <= '{}'::float8", axis == 0 ? "" : " AND ", "xyz"[axis],
                        box.min[axis], "xyz"[axis], box.max[axis]);
  }
  return text;
}

/// `word` as a shell takes it for a word, whatever is in it.
std::string shell_word(const std::string& word) {
  const auto is_plain = [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '_' || letter == '-' || letter == '.' || letter == ':';
  };
  if (std::ranges::all_of(word, is_plain)) return word;
  std::string quoted = "'";
  for (const char letter : word) quoted += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  return quoted + "'";
}

std::string box_text(const Bounds& box) {
  return fmt::format("x {} to {}, y {} to {}, z {} to {}", box.min.x, box.max.x, box.min.y, box.max.y,
                     box.min.z, box.max.z);
}

}  // namespace

std::string shard_name(std::size_t shard) {
  return fmt::format("shard_{}", shard + 1);
}

std::string shard_script(const std::string& table, const std::vector<StoredColumn>& columns,
                         std::size_t shard, const Bounds& box) {
  const std::string name = sql_name(table);
  return fmt::format(
      "-- Run by psql in the folder of this file, connected to shard {0}.\n"
      "{1}"
      "CREATE EXTENSION IF NOT EXISTS alidade_pg;\n"
      "CREATE TABLE {2}({3},\n"
      "  CONSTRAINT box CHECK ({4}));\n"
      "\\copy {2} FROM '{5}.copy' (FORMAT binary)\n"
      "{6};\n"
      "COMMIT;\n"
      "ANALYZE {2};\n",
      shard + 1, k_head, name, server_columns(columns), box_check(box), shard_name(shard),
      server_index(name));
}

std::string coordinator_script(const std::string& table, const std::vector<StoredColumn>& columns,
                               std::span<const Shard> shards, std::span<const Bounds> boxes,
                               const CloudRow& cloud) {
  std::string text = fmt::format(
      "-- Run by psql, connected to the database that is to answer for all shards.\n"
      "{0}"
      "CREATE EXTENSION IF NOT EXISTS alidade_pg;\n"
      "CREATE EXTENSION IF NOT EXISTS postgres_fdw;\n"
      "-- The rows are in the tables that inherit from this one.\n"
      "CREATE TABLE {1}({2},\n"
      "  CONSTRAINT no_rows_here CHECK (false) NO INHERIT);\n",
      k_head, sql_name(table), server_columns(columns));
  for (std::size_t i = 0; i < shards.size(); ++i) {
    const std::string name = sql_name(table + "_" + shard_name(i));
    // extensions: conditions on distances are for the shard. async_capable: shards work at the same time.
    // use_remote_estimate: shards say what a query will cost them.
    text += fmt::format(
        "CREATE SERVER {0} FOREIGN DATA WRAPPER postgres_fdw OPTIONS (host {1}, port '{2}', dbname {3},\n"
        "  extensions 'alidade_pg', async_capable 'true', use_remote_estimate 'true', fetch_size '10000');\n"
        "CREATE USER MAPPING FOR CURRENT_USER SERVER {0};\n"
        "CREATE FOREIGN TABLE {0}(\n"
        "  CONSTRAINT box CHECK ({4}))\n"
        "  INHERITS ({5}) SERVER {0} OPTIONS (table_name {6});\n",
        name, sql_text(shards[i].host), shards[i].port, sql_text(shards[i].database), box_check(boxes[i]),
        sql_name(table), sql_text(table));
  }
  const std::string beside = sql_name(table + "_cloud");
  return text + fmt::format("{};\n{};\nCOMMIT;\n", cloud_row_table(beside), cloud_row_insert(beside, cloud));
}

std::string plan_readme(const std::string& table, std::span<const Shard> shards,
                        std::span<const Bounds> boxes) {
  std::string text =
      "A cloud for several PostgreSQL servers. All of them need the extension alidade_pg, in the same "
      "version.\n\n"
      "1. Fill the shards, in this folder. Each script works as a whole or not at all:\n\n";
  for (std::size_t i = 0; i < shards.size(); ++i) {
    text += fmt::format("   psql -h {} -p {} -d {} -f {}.sql\n", shell_word(shards[i].host), shards[i].port,
                        shell_word(shards[i].database), shard_name(i));
  }
  text += fmt::format(
      "\n2. Make the table over all of them, on the server that is asked:\n\n"
      "   psql -d DATABASE -f coordinator.sql\n"
      "\n   A shard that wants another user or a password gets it from there:\n\n"
      "   ALTER USER MAPPING FOR CURRENT_USER SERVER {0}\n"
      "     OPTIONS (ADD user 'NAME', ADD password 'PASSWORD');\n\n"
      "   Each other role that asks needs mappings of its own (CREATE USER MAPPING FOR ROLE SERVER ...), "
      "with a "
      "password\n"
      "   unless it is a superuser. A role that is none runs coordinator.sql after GRANT USAGE ON FOREIGN "
      "DATA "
      "WRAPPER\n"
      "   postgres_fdw TO ROLE.\n"
      "\n3. Ask there. EXPLAIN (VERBOSE) shows what each shard is asked:\n\n"
      "   SELECT * FROM {1} WHERE dist_ray(ox,oy,oz, dx,dy,dz, x,y,z) <= 1;\n\n"
      "Where the points are:\n\n",
      sql_name(table + "_" + shard_name(0)), sql_name(table));
  for (std::size_t i = 0; i < shards.size(); ++i)
    text += fmt::format("   {}: {}\n", shard_name(i), box_text(boxes[i]));
  return text;
}

}  // namespace alidade
