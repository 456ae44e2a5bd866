// SPDX-License-Identifier: MIT
#include "extensions/postgres/shard_plan.h"

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <functional>
#include <vector>

#include "base/bounds.h"
#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"
#include "database/sql/sql_tokens.h"
#include "database/stored_column.h"
#include "extensions/postgres/copy_format.h"
#include "extensions/postgres/server_name.h"
#include "extensions/postgres/server_sql.h"

namespace alidade::database {
namespace {

[[noreturn]] void reject_shard(std::string_view text, std::string problem) {
  // The part before an @ may be a password, which must not be in a message.
  const std::size_t at = text.rfind('@');
  const std::string found(at == std::string_view::npos ? text : text.substr(at));
  throw input_error(std::move(problem), "HOST/DATABASE or HOST:PORT/DATABASE",
                    (at == std::string_view::npos ? "" : "...") + found);
}

/// Whether a name is neither an option or setting for programs nor a command for terminals.
bool is_plain(std::string_view name) {
  const auto is_strange = [](char character) {
    return static_cast<unsigned char>(character) <= 0x20 || character == 0x7f || character == '=';
  };
  return !name.empty() && name.front() != '-' && std::ranges::none_of(name, is_strange);
}

// The scripts for servers. They are for psql, and run completely or not at all.

/// The beginning of every script, which an error ends and rolls back. Names and texts do not depend on the
/// client's settings.
constexpr const char* k_script_head =
    "\\set ON_ERROR_STOP on\n\\set QUIET on\n\\encoding UTF8\nSET standard_conforming_strings = on;\n"
    "SET client_min_messages = warning;\nBEGIN;\n";

/// A CHECK of a box; its numbers are read as the same ones.
std::string box_check(const Bounds& box) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    text += fmt::format("{}{} >= '{}'::float8 AND {} <= '{}'::float8", axis == 0 ? "" : " AND ", "xyz"[axis],
                        box.min[axis], "xyz"[axis], box.max[axis]);
  }
  return text;
}

std::string box_text(const Bounds& box) {
  return fmt::format("x {} to {}, y {} to {}, z {} to {}", box.min.x, box.max.x, box.min.y, box.max.y,
                     box.min.z, box.max.z);
}

/// "shard_1" for shard 0: the name of its files, without extension.
std::string shard_name(std::size_t shard) {
  return fmt::format("shard_{}", shard + 1);
}

/// The script that makes the table of a shard whose points are in a box, from the file of its rows.
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
      shard + 1, k_script_head, name, server_columns(columns), box_check(box), shard_name(shard),
      server_index(name));
}

/// The script that makes the table over all shards, whose points are in these boxes, and its NAME_cloud.
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
      k_script_head, sql_name(table), server_columns(columns));
  for (std::size_t i = 0; i < shards.size(); ++i) {
    const std::string name = sql_name(table + "_" + shard_name(i));
    // extensions: shards evaluate conditions on distances. async_capable: shards work at the same time.
    // use_remote_estimate: shards estimate the cost of queries.
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

/// The text of README.txt: the commands to type.
std::string plan_readme(const std::string& table, std::span<const Shard> shards,
                        std::span<const Bounds> boxes) {
  std::string text =
      "A cloud for several PostgreSQL servers. All of them need the extension alidade_pg, in the same "
      "version.\n\n"
      "1. Fill the shards, in this folder. Each script is one transaction:\n\n";
  for (std::size_t i = 0; i < shards.size(); ++i) {
    text += fmt::format("   psql -h {} -p {} -d {} -f {}.sql\n", shell_word(shards[i].host), shards[i].port,
                        shell_word(shards[i].database), shard_name(i));
  }
  text += fmt::format(
      "\n2. Create the table over all shards on the coordinating server:\n\n"
      "   psql -d DATABASE -f coordinator.sql\n"
      "\n   For another user or a password of a shard:\n\n"
      "   ALTER USER MAPPING FOR CURRENT_USER SERVER {0}\n"
      "     OPTIONS (ADD user 'NAME', ADD password 'PASSWORD');\n\n"
      "   Every other role that queries needs its own mappings (CREATE USER MAPPING FOR ROLE SERVER ...), "
      "with a "
      "password\n"
      "   unless it is a superuser. Other roles run coordinator.sql after GRANT USAGE ON FOREIGN "
      "DATA "
      "WRAPPER\n"
      "   postgres_fdw TO ROLE.\n"
      "\n3. Query that server. EXPLAIN (VERBOSE) shows the query that each shard receives:\n\n"
      "   SELECT * FROM {1} WHERE dist_ray(ox,oy,oz, dx,dy,dz, x,y,z) <= 1;\n\n"
      "Positions of the shards:\n\n",
      sql_name(table + "_" + shard_name(0)), sql_name(table));
  for (std::size_t i = 0; i < shards.size(); ++i)
    text += fmt::format("   {}: {}\n", shard_name(i), box_text(boxes[i]));
  return text;
}

/// Writes the next `count` rows, those of one shard, and returns their box.
Bounds write_rows(const std::filesystem::path& path, OrderedCloud& cloud, const CopyRows& rows,
                  std::uint64_t count, const std::function<void(std::size_t)>& report_progress) {
  OutputFile file(path, false);
  const Bounds box = rows.copy(cloud, count, [&](std::span<const std::byte> bytes, std::size_t points) {
    file.write(bytes);
    report_progress(points);
  });
  file.commit();
  return box;
}

void write_files(const std::filesystem::path& folder, OrderedCloud& cloud, std::span<const Shard> shards,
                 const ShardPlanOptions& options) {
  const CopyRows rows(cloud.columns(), cloud.whole.rest.lattice);
  check_column_count(rows.columns());
  const std::uint64_t size = cloud.points.size();
  check_that(!shards.empty() && size >= shards.size(),
             fmt::format("cannot distribute {} points over {} shards", size, shards.size()),
             "at least one point for each shard");
  std::uint64_t done = 0;
  const auto report_progress = [&](std::size_t count) {
    done += count;
    report(options.progress, done, size);
  };
  std::vector<Bounds> boxes;
  for (std::size_t i = 0; i < shards.size(); ++i) {
    const std::string name = shard_name(i);
    const std::uint64_t count = size / shards.size() + (i < size % shards.size() ? 1 : 0);
    boxes.push_back(write_rows(folder / (name + ".copy"), cloud, rows, count, report_progress));
    write_text_file(folder / (name + ".sql"), shard_script(options.table, rows.columns(), i, boxes.back()),
                    false);
  }
  Bounds whole_box;
  for (const Bounds& box : boxes) whole_box.grow(box);
  const std::string coordinator =
      coordinator_script(options.table, rows.columns(), shards, boxes, cloud_row(cloud.whole, whole_box));
  write_text_file(folder / "coordinator.sql", coordinator, false);
  write_text_file(folder / "README.txt", plan_readme(options.table, shards, boxes), false);
}

}  // namespace

Shard parse_shard(std::string_view text) {
  if (text.find('@') != std::string_view::npos)
    reject_shard(text, "the shard name contains a user or password, which belong in a user mapping");
  const std::size_t slash = text.rfind('/');
  if (slash == std::string_view::npos) reject_shard(text, "missing database in the shard name");
  const auto [host, port, is_address] = split_host(text.substr(0, slash));
  Shard shard{.host = std::string(host), .database = std::string(text.substr(slash + 1))};
  if (port) {
    const std::optional<int> number = parse_port(*port);
    if (!number) reject_shard(text, "the shard port is not a number from 1 to 65535");
    shard.port = *number;
  }
  if (!is_address) reject_shard(text, "invalid shard host");
  if (!is_plain(shard.host) || shard.host.find('/') != std::string::npos || !is_plain(shard.database))
    reject_shard(text, "missing host or database in the shard name");
  return shard;
}

void check_shard_plan(const std::filesystem::path& folder, const std::string& table) {
  check_server_table(table);
  const std::filesystem::path whole_folder = (folder / "").parent_path();
  if (std::filesystem::exists(std::filesystem::symlink_status(whole_folder)))
    throw file_error(whole_folder, "the folder exists", "the name of a new folder");
}

void write_shard_plan(const std::filesystem::path& folder, OrderedCloud& cloud, std::span<const Shard> shards,
                      const ShardPlanOptions& options) {
  check_shard_plan(folder, options.table);
  const std::filesystem::path whole_folder = (folder / "").parent_path();
  const std::filesystem::path beside = whole_folder.string() + fmt::format(".part{}", ::getpid());
  std::error_code error;
  if (!std::filesystem::create_directory(beside, error))
    throw file_error(whole_folder, "cannot create the folder: " + error.message());
  try {
    write_files(beside, cloud, shards, options);
    std::filesystem::rename(beside, whole_folder);
  } catch (...) {
    std::filesystem::remove_all(beside, error);
    throw;
  }
}

}  // namespace alidade::database
