// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "cloud/read_cloud.h"
#include "database/sqlite/rewrite_statement.h"
#include "database/sqlite/sql_tokens.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/console.h"
#include "tools/sql/statements.h"

namespace alidade::tools {
namespace {

struct RewriteCommand {
  std::string statement, bounds;
  std::filesystem::path file;
  database::RewriteOptions options;
  Verbosity verbosity = Verbosity::normal;
};

Bounds parse_bounds(const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& word : split_list(text)) numbers.push_back(parse_number(word));
  if (numbers.size() != 6 ||
      !std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); }))
    throw file_error("--bounds", "invalid bounds", "x0,y0,z0,x1,y1,z1 or a cloud", text);
  Bounds bounds{{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
  if (bounds.empty()) throw file_error("--bounds", "limits out of order", "the lower corner first", text);
  return bounds;
}

/// The bounds of a cloud, or those of the text itself; a name of a cloud may contain commas.
Bounds bounds_of(const std::string& text) {
  std::error_code error;
  if (text.find(',') != std::string::npos && !std::filesystem::exists(text, error)) return parse_bounds(text);
  const std::array<std::filesystem::path, 1> names = {text};
  Bounds bounds;
  for (const CloudInput& input : resolve_clouds(names, cloud_formats()).inputs) {
    const Bounds box = stated_box({{input}});
    if (box.empty())
      throw file_error(input.name, "the file does not state its bounds",
                       "--bounds x0,y0,z0,x1,y1,z1, which 'alidade info' prints");
    bounds.grow(box);
  }
  return bounds;
}

/// The statements of a text, without what separates them.
std::vector<std::string_view> statements_of(std::string_view text) {
  std::vector<std::string_view> statements;
  const database::TokenList tokens(text);
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= tokens.size(); ++i) {
    if (i < tokens.size() && !tokens.is_sign(i, ";")) continue;
    if (i > begin) {
      const std::size_t first = tokens[begin].begin;
      statements.push_back(text.substr(first, tokens[i - 1].end - first));
    }
    begin = i + 1;
  }
  return statements;
}

ExitCode run(const RewriteCommand& command, bool has_statement) {
  database::RewriteOptions options = command.options;
  if (!command.bounds.empty()) options.bounds = bounds_of(command.bounds);
  const bool is_given = has_statement && command.statement != "-";
  const std::string text = is_given ? command.statement : read_sql(command.file.empty() ? "-" : command.file);
  std::string output;
  for (const std::string_view statement : statements_of(text)) {
    const database::RewrittenStatement rewritten = database::rewrite_statement(statement, options);
    output += rewritten.text + ";\n";
    if (rewritten.box_count > 0)
      say_note(command.verbosity,
               fmt::format("conditions on {} {}, {:.3g} % of the bounds", rewritten.box_count,
                           rewritten.box_count == 1 ? "box" : "boxes", 100.0 * rewritten.share));
    if (!rewritten.reason.empty())
      say_note(command.verbosity,
               fmt::format("{}: {}",
                           rewritten.box_count == 0 ? "no conditions on boxes" : "not all conditions prune",
                           rewritten.reason));
  }
  write_to_stdout(output);
  return ExitCode::done;
}

}  // namespace

Command add_sql_rewrite(const Options& sql) {
  const auto command = std::make_shared<RewriteCommand>();
  const Options rewrite = sql.command(
      "rewrite", "Rewrite statements for engines without dist_ray, such as DuckDB on Parquet files");
  using database::SqlDialect;
  rewrite.required().choice("--dialect", "the engine that will run the statement", command->options.dialect,
                            {{"datafusion", SqlDialect::datafusion},
                             {"duckdb", SqlDialect::duckdb},
                             {"postgres", SqlDialect::postgres},
                             {"spark", SqlDialect::spark},
                             {"sqlite", SqlDialect::sqlite},
                             {"trino", SqlDialect::trino}});
  const Field statement = rewrite.text(
      "statement", "STATEMENT", "SQL to rewrite; - or nothing reads standard input", command->statement);
  rewrite.excludes(statement).file("-f,--file", "FILE", "rewrite the statements of a file", command->file);
  rewrite.text(
      "--bounds", "CLOUD|x0,y0,z0,x1,y1,z1",
      "bounds of all points of the table, in the unit of the CRS, inclusive: a cloud that states them, or "
      "numbers; without them no conditions on boxes are added",
      command->bounds);
  rewrite.count("--boxes", "N", "most boxes along a ray, 1 to 64 (default: 8)", command->options.box_count, 1,
                64);
  add_verbosity(rewrite, command->verbosity);
  return {rewrite, [command, statement](const CommandLine&) { return run(*command, statement.given()); }};
}

}  // namespace alidade::tools
