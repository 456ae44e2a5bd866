// SPDX-License-Identifier: MIT
#include "tests/database/random_statement.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <optional>

#include "database/sqlite/connection.h"

namespace alidade::test {
namespace {

class Writer {
 public:
  explicit Writer(Random& random) : random_(random) {}

  RandomStatement write() {
    parameter_style_ = one_of({"?", "?", "?1", ":name", "@a", "mixed"});
    const std::string from = source();
    std::string condition = conditions(0);
    std::string text = chance(30) ? "  select /* ) ; */ " : "SELECT ";
    text += columns() + from + (chance(8) ? "\nwhere(" + condition + ")" : " WHERE " + condition);
    text += tail();
    statement_.text = with_clause_ + text + (chance(10) ? " -- the end" : chance(10) ? " ; " : "");
    return statement_;
  }

 private:
  bool chance(int percent) { return random_.below(100) < static_cast<std::uint64_t>(percent); }
  std::string one_of(std::initializer_list<const char*> texts) {
    return *(texts.begin() + random_.below(texts.size()));
  }

  /// FROM, with the names by which conditions call what is in it.
  std::string source() {
    switch (random_.below(16)) {
      case 0:
        cloud_ = "p.";
        ray_table_ = "r.";
        return " FROM rays r LEFT JOIN points p ON " + conditions(1);
      case 1:
        cloud_ = "p.";
        ray_table_ = "r.";
        return " FROM rays AS r LEFT OUTER JOIN points AS p ON " + distance_condition() + " AND r.id < 6";
      case 2:
        cloud_ = "p.";
        ray_table_ = "r.";
        return " FROM points p LEFT JOIN rays r ON " + conditions(1);
      case 3:
        cloud_ = "\"P\".";
        ray_table_ = "[r].";
        return " FROM points `p` JOIN rays r ON " + conditions(1);
      case 4:
        cloud_ = "q.";
        ray_table_ = "";
        return one_of({" FROM rays, points q", " FROM points AS q CROSS JOIN rays"});
      case 5:
        cloud_ = one_of({"a.", "b."});
        return " FROM points a JOIN \"odd \"\"cloud\" b ON a.id = b.id";
      case 6:
        return one_of({" FROM moved", " FROM showing", " FROM main.marks", " FROM plain_view"});
      case 7:
        with_clause_ = "WITH c AS (SELECT id, x, y + 5 AS y, z, _chunk FROM points) ";
        return " FROM c";
      case 8:
        return " FROM (SELECT id, x, y + 5 AS y, z, _chunk FROM points)";
      case 9:
        cloud_ = one_of({"main.points.", "points."});
        return " FROM main.points";
      case 10:
        return " FROM \"odd \"\"cloud\"";
      case 11:
        return " FROM points(690050, 5325050, 410, 0, 1, 0.1)";
      case 12:
        cloud_ = one_of({"m.", "p.", ""});
        return one_of({" FROM marks m JOIN points p USING(id)", " FROM marks m NATURAL JOIN points p",
                       " FROM marks m LEFT JOIN points p USING(id, x, y, z)",
                       " FROM points p FULL JOIN marks m ON p.id = m.id"});
      case 13:
        cloud_ = one_of({"p.", "m."});
        return " FROM points p LEFT JOIN marks m ON m.id = p.id AND " + distance_condition();
      default:
        return " FROM points";
    }
  }

  std::string columns() {
    const std::string id = cloud_ + "id";
    switch (random_.below(5)) {
      case 0:
        return "count(*)";
      case 1:
        return "count(*), sum(" + id + "), max(" + cloud_ + "x), min(" + distance() + ")";
      case 2:
        return cloud_.empty() || !ray_table_ ? "*" : cloud_ + "*";
      case 3:
        return id + ", " + distance() + " < 5, " + distance() + " AS d";
      default:
        return id + ", " + cloud_ + "x AS y, 7 AS _chunk";
    }
  }

  std::string tail() {
    switch (random_.below(12)) {
      case 0:
        statement_.is_ordered = true;
        return " ORDER BY " + cloud_ + "id, 1, 2 LIMIT 7 OFFSET 1";
      case 1:
        return " GROUP BY " + cloud_ + "id % 3 HAVING " + distance_condition();
      case 2:
        return " UNION ALL SELECT 1, 2, 3 WHERE " + condition_without_distance();
      case 3:
        return " ORDER BY " + distance();
      default:
        return "";
    }
  }

  std::string conditions(int depth) {
    const std::uint64_t kind = depth > 3 ? 9 : random_.below(14);
    if (kind < 3)
      return conditions(depth + 1) + one_of({" AND ", "\nand ", " AND/**/"}) + conditions(depth + 1);
    if (kind < 5) return conditions(depth + 1) + one_of({" OR ", " or "}) + conditions(depth + 1);
    if (kind == 5) return one_of({"NOT ", "not ", "NOT NOT "}) + conditions(depth + 1);
    if (kind == 6) return "(" + conditions(depth + 1) + ")";
    if (kind == 7)
      return "(" + conditions(depth + 1) + one_of({") = 1", ") IS NULL", ") IS NOT TRUE", ") + 1 > 1"});
    if (kind == 8) return condition_without_distance();
    return distance_condition();
  }

  std::string condition_without_distance() {
    const std::string id = cloud_ + "id";
    switch (random_.below(13)) {
      case 11:
        return "1 BETWEEN 0 AND " + distance() + " = 1";
      case 0:
        return id + " % 2 = 0";
      case 1:
        return cloud_ + "x BETWEEN 690020 AND 690070";
      case 2:
        return cloud_ + "y > 5325060";
      case 3:
        return cloud_ + "z IS NULL";
      case 4:
        return "random() IS NOT NULL";
      case 5:
        return id + " IN (SELECT id FROM marks WHERE " + distance_condition() + ")";
      case 6:
        return "EXISTS (SELECT 1 FROM marks WHERE " + distance_condition() + ")";
      case 7:
        return "CASE WHEN " + distance_condition() + " AND " + id + " < 90 THEN 1 ELSE 0 END";
      case 8:
        return id + " BETWEEN 10 AND " + distance_condition();
      case 9:
        return "'it''s -- ' IS NOT /* ( */ \"no column (\"";
      case 10:
        return "NULL";
      default:
        return id + " < 150";
    }
  }

  std::string distance_condition() {
    const std::string far = limit();
    switch (random_.below(9)) {
      case 0:
        return far + " " + one_of({">", ">=", "=", "<"}) + " " + distance();
      case 1:
        return distance() + " BETWEEN " + limit() + " AND " + far;
      case 2:
        return distance() + " NOT BETWEEN " + limit() + " AND " + far;
      case 3:
        return distance() + one_of({" <= 1 + ", " <> ", " + 1 < ", " IS NOT "}) + far;
      case 4:
        return distance() + one_of({" > ", " >= ", "==", " = "}) + far;
      case 5:
        return distance() + " <= " + far + one_of({" = 1", " < 1", " IS NULL", " COLLATE nocase", " || ''"});
      default:
        return distance() + one_of({" <= ", "<", " < ", "<="}) + far;
    }
  }

  std::string limit() {
    switch (random_.below(18)) {
      case 0:
        return one_of({"NULL", "'7'", "x'00'", "-1", "1e999", "-1e999", "9007199254740993"});
      case 1:
        return one_of({"(2 + 3)", "(abs(-4))", "abs(-4)", "(SELECT 4)", "- -4", "(random() * 0 + 4)"});
      case 2:
      case 3:
        return parameter();
      case 4:
        return ray_table_ ? *ray_table_ + "radius" : cloud_ + "z";
      case 5:
        return ray_table_ ? *ray_table_ + one_of({"note", "id"}) : "(0.5+0.5)";
      case 6:
        return one_of({"0", "0.5", "1e2", "0x7"});
      default:
        return fmt::format("{:.3g}", random_.between(0, 12));
    }
  }

  std::string parameter() {
    const std::string name = parameter_style_ == "mixed" ? one_of({"?", "?1", "@b"}) : parameter_style_;
    if (name == "?")
      ++statement_.parameters;
    else if (statement_.parameters == 0 || parameter_style_ == "mixed")
      ++statement_.parameters;
    return name;
  }

  std::string distance() {
    const bool is_ray = chance(60);
    std::string text =
        is_ray ? one_of({"dist_ray", "DIST_RAY", "\"dist_ray\"", "dist_ray -- (\n"}) : "dist_plane";
    text += one_of({"(", "( ", " ("}) + numbers() + ", ";
    if (chance(90))
      return text + cloud_ + "x," + cloud_ + one_of({"y , ", "Y,", "\"y\", ", "[y],"}) + cloud_ + "z)";
    return text + one_of({"x, y)", "x, y, z, 1)", "x + 1, y, z)", "x, z, y)", "690050, 5325050, 410)",
                          "'x', y, z)"});
  }

  std::string numbers() {
    if (ray_table_ && chance(60)) {
      std::string text;
      for (const char* const name : {"ox", "oy", "oz", "dx", "dy", "dz"})
        text += (text.empty() ? "" : ", ") + *ray_table_ + name;
      return text;
    }
    switch (random_.below(60)) {
      case 0:
        return "690050, 5325050, 410, 0, 0, 0";
      case 1:
        return "690050, 5325050, 410, NULL, 0, 1";
      case 2:
        return "690050, 5325050, 'far', 0, 0, 1";
      case 3:
        return "690050, 5325050, 1e999, 0, 0, 1";
      case 4:
        return "690050, 5325050, 410, 0, 0, 1 + random() * 0";
      case 5:
        return "690050, 5325050, 410, 0, (SELECT 0), 1";
      case 6:
        return "690050, 5325050 + 1 * 2, 410, -1, 1e-200, (0.5)";
      case 7:
        return "1e6, -1e7, " + parameter() + ", 1, 0.2, -3";
      default:
        break;
    }
    return fmt::format("{:.2f}, {:.2f}, {:.2f}, {:.3g}, {:.3g}, {:.3g}", random_.between(690000, 690100),
                       random_.between(5325000, 5325100), random_.between(400, 430), random_.between(-1, 1),
                       random_.between(-1, 1), random_.between(-1, 1));
  }

  Random& random_;
  RandomStatement statement_;
  std::string with_clause_, parameter_style_;
  std::string cloud_;                     ///< the qualifier before x, y, z
  std::optional<std::string> ray_table_;  ///< the qualifier before ox, if there are rays
};

}  // namespace

RandomStatement random_statement(Random& random) {
  return Writer(random).write();
}

void add_statement_tables(sqlite3* database) {
  for (const char* const sql :
       {"CREATE TABLE rays(id INTEGER, ox REAL, oy REAL, oz REAL, dx, dy, dz, radius, note TEXT)",
        "INSERT INTO rays VALUES(1, 690050, 5325050, 410, 0, 0, 1, 6, '1'), "
        "(2, 690010, 5325020, 405, 1, 0.5, 0, 9.5, 'far'), (3, 690000, 5325000, 400, 1, 1, 1e-200, 3, NULL), "
        "(4, 690080, 5325050, 400, NULL, 0, 1, 6, ''), (5, 690020, 5325080, 401, -1, 0, 0.1, '4', '1'), "
        "(6, 690090, 5325010, 400, 0, -1, 0, -1, 'a'), (7, 690090, 5325010, 400, 0, -1, 0, NULL, 'a')",
        "CREATE TABLE marks(id INTEGER, x, y, z)",
        "INSERT INTO marks VALUES(1, 690050, 5325050, 401), (2, NULL, 1, 1), (3, 690010, 5325010, 400.5), "
        "(590, 690060, 5325060, 402)",
        "CREATE VIEW moved AS SELECT id, x, y + 5 AS y, z FROM points",
        "CREATE VIEW showing AS SELECT id, x, y + 5 AS y, z, _chunk FROM points",
        "CREATE VIEW plain_view AS SELECT * FROM points"})
    database::run(database, sql);
}

StatementAnswer answer_of(sqlite3* database, sqlite3_stmt* statement, const RandomStatement& wanted) {
  for (int i = 1; i <= sqlite3_bind_parameter_count(statement); ++i)
    sqlite3_bind_double(statement, i, 410.0 - 50.0 * i);
  StatementAnswer answer;
  int result = SQLITE_ROW;
  while ((result = sqlite3_step(statement)) == SQLITE_ROW) {
    std::string row;
    for (int i = 0; i < sqlite3_column_count(statement); ++i) {
      const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(statement, i));
      row += fmt::format("{}:{} ", sqlite3_column_type(statement, i), text == nullptr ? "" : text);
    }
    answer.rows.push_back(row);
  }
  if (result != SQLITE_DONE) answer = {.rows = {}, .error = sqlite3_errmsg(database)};
  if (!wanted.is_ordered) std::ranges::sort(answer.rows);
  return answer;
}

}  // namespace alidade::test
