// SPDX-License-Identifier: MIT
#include "jobs/sql/rewrite.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "base/error.h"
#include "cloud/read_cloud.h"
#include "database/sql/sql_tokens.h"
#include "jobs/load_cloud.h"

namespace alidade::jobs {
namespace {

Bounds parse_bounds(const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& word : split_list(text)) numbers.push_back(parse_number(word));
  if (numbers.size() != 6)
    throw file_error("--bounds", "invalid bounds", "x0,y0,z0,x1,y1,z1 or a cloud", text);
  Bounds bounds{{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
  if (bounds.empty()) throw file_error("--bounds", "limits out of order", "the lower corner first", text);
  return bounds;
}

/// The bounds of a cloud, or those of the text itself; a name of a cloud may contain commas.
Bounds bounds_of(const std::string& text) {
  std::error_code error;
  if (text.find(',') != std::string::npos && !std::filesystem::exists(text, error)) return parse_bounds(text);
  const std::filesystem::path name = text;
  Bounds bounds;
  for (const CloudInput& input : resolve_clouds({&name, 1}, cloud_formats()).inputs) {
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

}  // namespace

void add_rewrite_fields(const Fields& fields, RewriteRequest& request) {
  using database::SqlDialect;
  fields.required().choice("--dialect", "the engine that will run the statement", request.options.dialect,
                           {{"datafusion", SqlDialect::datafusion},
                            {"duckdb", SqlDialect::duckdb},
                            {"postgres", SqlDialect::postgres},
                            {"spark", SqlDialect::spark},
                            {"sqlite", SqlDialect::sqlite},
                            {"trino", SqlDialect::trino}});
  add_sql_source(fields, "SQL to rewrite; - or nothing reads standard input",
                 "rewrite the statements of a file", request.source);
  fields.value(
      "--bounds", "CLOUD|x0,y0,z0,x1,y1,z1",
      "bounds of all points of the table, in the unit of the CRS, inclusive: a cloud that states them, or "
      "numbers; without them no conditions on boxes are added",
      [&bounds = request.options.bounds](const std::string& text) {
        if (!text.empty()) bounds = bounds_of(text);
      });
  fields.count("--boxes", "N", "most boxes along a ray, 1 to 64 (default: 8)", request.options.box_count, 1,
               64);
}

RewritePlan plan(const RewriteRequest& request) {
  return RewritePlan(request, {.reads = {request.source.file}});
}

std::vector<database::RewrittenStatement> run(const RewritePlan& plan, Listener& listener) {
  const SqlText sql = read_sql(plan.request().source);
  std::vector<database::RewrittenStatement> all;
  for (const std::string_view statement : statements_of(sql.text)) {
    const auto& rewritten = all.emplace_back(database::rewrite_statement(statement, plan.request().options));
    if (rewritten.box_count > 0)
      listener.note(fmt::format("conditions on {} {}, {:.3g} % of the bounds", rewritten.box_count,
                                rewritten.box_count == 1 ? "box" : "boxes", 100.0 * rewritten.share));
    if (!rewritten.reason.empty())
      listener.note(fmt::format(
          "{}: {}", rewritten.box_count == 0 ? "no conditions on boxes" : "not all conditions prune",
          rewritten.reason));
  }
  return all;
}

}  // namespace alidade::jobs
