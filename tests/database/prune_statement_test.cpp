// SPDX-License-Identifier: MIT
// What limits are put into which statements, and why none into others.
#include "database/sql/rewrite_statement.h"

#include <gtest/gtest.h>

#include <vector>

#include "database/sql/sql_tokens.h"

namespace alidade::test {

using namespace database;

namespace {

const std::string k_from = "SELECT * FROM points WHERE ";

TEST(PruneStatement, the_papers_condition_gets_a_limit) {
  const PrunedStatement pruned =
      prune_statement("SELECT * FROM points WHERE dist_ray(1,2,3, 4,5,6, x,y,z) <= 1;");
  EXPECT_EQ(pruned.text,
            "SELECT * FROM points WHERE (dist_ray(1,2,3, 4,5,6, x,y,z) <= 1 AND in_chunk(_chunk, "
            "try_ray_limit(1, 2, 3, 4, 5, 6, 0, 1)));");
  EXPECT_EQ(pruned.reason, "");
}

TEST(PruneStatement, every_comparison_gets_its_limits) {
  const std::string ray = "dist_ray(1,2,3,4,5,6,x,y,z)", plane = "dist_plane(1,2,3,4,5,6,x,y,z)";
  const std::string ray_limit = "try_ray_limit(1, 2, 3, 4, 5, 6, ";
  const std::string plane_limit = "try_plane_limit(1, 2, 3, 4, 5, 6, ";
  const std::vector<std::array<std::string, 2>> cases = {
      {ray + "<9", ray_limit + "0, 9)"},
      {ray + " >= :r", ray_limit + ":r, 1e999)"},
      {plane + " < -1", plane_limit + "-1e999, -1)"},
      {plane + " > r.low", plane_limit + "r.low, 1e999)"},
      {plane + "==(1+2)", plane_limit + "(1+2), (1+2))"},
      {"3 >= " + ray, ray_limit + "0, 3)"},
      {"?2 < " + plane, plane_limit + "?2, 1e999)"},
      {"-1=" + plane, plane_limit + "-1, -1)"},
      {plane + " between 0 and 2", plane_limit + "0, 2)"},
      {"DIST_RAY(1,2,3,4,5,6,\"X\",[y],`Z`) <= 2", ray_limit + "0, 2)"}};
  for (const auto& [condition, limit] : cases) {
    EXPECT_EQ(prune_statement(k_from + condition).text,
              k_from + "(" + condition + " AND in_chunk(_chunk, " + limit + "))");
  }
}

TEST(PruneStatement, limits_are_wherever_the_condition_is) {
  const std::string d = "dist_ray(1,2,3,4,5,6,p.x,p.y,p.z)<1";
  const std::string limited = "(" + d + " AND in_chunk(p._chunk, try_ray_limit(1, 2, 3, 4, 5, 6, 0, 1)))";
  // @ is the condition, which gets a limit; # is the condition, which stays.
  for (const std::string form :
       {"SELECT 1 FROM points p WHERE @ AND @ OR NOT @", "SELECT 1 FROM points p WHERE ((@) OR id < 3) AND @",
        "SELECT 1 FROM points p WHERE id BETWEEN 1 AND 2 AND @ GROUP BY # HAVING # ORDER BY # LIMIT #",
        "SELECT # FROM points p JOIN rays ON @ JOIN marks ON @ WHERE @",
        "SELECT 1 FROM rays r LEFT JOIN points p ON @ WHERE @",
        "SELECT 1 FROM rays r LEFT JOIN points AS p ON r.id = 1 AND @",
        "SELECT 1 FROM points p LEFT JOIN rays r ON # WHERE @",
        "SELECT 1 FROM points p WHERE CASE WHEN # AND # THEN 1 END AND @",
        "SELECT 1 FROM points p WHERE 1 BETWEEN 0 AND # AND @",
        "EXPLAIN QUERY PLAN SELECT 1 FROM points p WHERE @", "SELECT 1 FROM points p WHERE (#) = 1 AND (@)",
        "SELECT 1 FROM points p WHERE f(#) AND @ -- #"}) {
    std::string given, expected;
    for (const char character : form) {
      given += character == '@' || character == '#' ? d : std::string(1, character);
      expected += character == '@' ? limited : character == '#' ? d : std::string(1, character);
    }
    EXPECT_EQ(prune_statement(given).text, expected);
  }
}

TEST(PruneStatement, plain_parameters_get_numbers) {
  EXPECT_EQ(prune_statement("SELECT ? FROM points WHERE dist_ray(?,2,3,4,5,6,x,y,z) <= ? AND id < ?").text,
            "SELECT ?1 FROM points WHERE (dist_ray(?2,2,3,4,5,6,x,y,z) <= ?3 AND in_chunk(_chunk, "
            "try_ray_limit(?2, 2, 3, 4, 5, 6, 0, ?3))) AND id < ?4");
}

TEST(PruneStatement, comments_do_not_reach_into_limits) {
  EXPECT_EQ(prune_statement(k_from + "dist_ray(1,/*)*/2,3,4,5,6-- (\n,x,y,z) <= 1-- 2").text,
            k_from +
                "(dist_ray(1,/*)*/2,3,4,5,6-- (\n,x,y,z) <= 1 AND in_chunk(_chunk, "
                "try_ray_limit(1, 2, 3, 4, 5, 6, 0, 1)))-- 2");
}

TEST(PruneStatement, what_might_change_the_answer_is_left_alone) {
  const std::string ray = "dist_ray(1,2,3,4,5,6,x,y,z)", ends = ray + " <= 1";
  const std::string steady = "may be volatile", compared = "not compared";
  const std::vector<std::array<std::string, 2>> cases = {
      {"WITH p AS (SELECT 1) SELECT * FROM points WHERE " + ends, "WITH"},
      {"SELECT * FROM (SELECT * FROM points) WHERE " + ends, "more than one SELECT"},
      {k_from + ends + " UNION SELECT 1", "more than one SELECT"},
      {k_from + "id IN (VALUES(1)) AND " + ends, "VALUES"},
      {"DELETE FROM points WHERE " + ends, "not a SELECT"},
      {"SELECT * FROM a NATURAL JOIN points WHERE " + ends, "NATURAL"},
      {"SELECT * FROM a JOIN points USING(x,y,z) WHERE " + ends, "USING"},
      {"SELECT * FROM a RIGHT JOIN points ON " + ends, "RIGHT"},
      {"SELECT * FROM a FULL JOIN points ON " + ends, "FULL"},
      {"SELECT * FROM points LEFT JOIN (a) ON " + ends, "LEFT JOIN"},
      {"SELECT * FROM a LEFT JOIN b ON dist_ray(1,2,3,4,5,6,a.x,a.y,a.z) < 1", "LEFT JOIN"},
      {k_from + ends + " AND id = ? AND id < ?2", "question marks"},
      {k_from + "id < 3", "no condition on dist_ray"},
      {"SELECT dist_ray(1,2,3,4,5,6,x,y,z) < 1 FROM points",
       "dist_ray or dist_plane is not in a condition of WHERE or ON"},
      {k_from + "dist_ray(1,2,random(),4,5,6,x,y,z) <= 1", steady},
      {k_from + ray + " <= (abs(1))", steady},
      {k_from + ray + " <= (a LIKE b)", steady},
      {k_from + ray + " <= random()", compared},
      {k_from + ray + " <= 1 + 1", compared},
      {k_from + ray + " <= 1 = 1", compared},
      {k_from + ray + " <= 1 COLLATE nocase", compared},
      {k_from + ray + " + 1 <= 1", compared},
      {k_from + ray + " <> 1", compared},
      {k_from + ray + " NOT BETWEEN 1 AND 2", compared},
      {k_from + ray + " BETWEEN 1 AND 2 + 3", compared},
      {k_from + ray + " <= CASE 1 WHEN 1 THEN 2 END", compared},
      {k_from + "dist_ray(1,2,3,4,5,6,x,z,y) <= 1", "the columns x, y, z"},
      {k_from + "dist_ray(1,2,3,4,5,6,a.x,b.y,a.z) <= 1", "the columns x, y, z"},
      {k_from + "dist_ray(1,2,3,4,5,6,x + 0,y,z) <= 1", "the columns x, y, z"},
      {k_from + "dist_ray(1,2,3,4,5,6,'x',y,z) <= 1", "the columns x, y, z"},
      {k_from + "dist_ray(1,2,3,4,5,6,x,y) <= 1", "9 arguments"},
      {k_from + "dist_ray(1,2,3,4,5,6,x,y,z <= 1", "cannot be parsed"}};
  for (const auto& [statement, reason] : cases) {
    const PrunedStatement pruned = prune_statement(statement);
    EXPECT_EQ(pruned.text, "") << statement;
    EXPECT_NE(pruned.reason.find(reason), std::string::npos) << statement << ": " << pruned.reason;
  }
}

TEST(PruneStatement, one_condition_left_alone_keeps_no_other_from_its_limit) {
  const PrunedStatement pruned =
      prune_statement(k_from + "dist_ray(1,2,3,4,5,6,x,y,z) <> 1 AND dist_ray(1,2,3,4,5,6,x,y,z) < 2");
  EXPECT_NE(pruned.text, "");
  EXPECT_NE(pruned.reason, "");
}

TEST(PruneStatement, deep_parentheses_end_soon) {
  const std::string deep(100'000, '('), closed(100'000, ')');
  EXPECT_EQ(prune_statement(k_from + deep + "dist_ray(1,2,3,4,5,6,x,y,z) < 1" + closed).text, "");
}

TEST(SqlTokens, are_those_of_sqlite) {
  const auto kinds = [](std::string_view sql) {
    std::string text;
    const TokenList tokens(sql);
    for (std::size_t i = 0; i < tokens.size(); ++i) {
      constexpr std::string_view k_letters = "wqtbnps!";
      text += k_letters[static_cast<std::size_t>(tokens[i].kind)];
      text += std::string(tokens.text(i)) + ' ';
    }
    return text;
  };
  EXPECT_EQ(kinds("a\"b\"\"c\"`d`[e f]'g''h'x'00fF'"), "wa q\"b\"\"c\" q`d` q[e f] t'g''h' bx'00fF' ");
  EXPECT_EQ(kinds("1 .5 1.e5 2e+3 0x1F 1e"), "n1 n.5 n1.e5 n2e+3 n0x1F !1e ");
  EXPECT_EQ(kinds("? ?12 :a @b $c::d(e) :"), "p? p?12 p:a p@b p$c::d(e) !: ");
  EXPECT_EQ(kinds("a<=b<>c<<d||e->>f.g--h\n/* i */j/*k"), "wa s<= wb s<> wc s<< wd s|| we s->> wf s. wg wj ");
  EXPECT_EQ(kinds("x'0' 'a"), "!x'0' !'a ");
  EXPECT_EQ(kinds(std::string_view("a\0b", 3)), "wa ");
  EXPECT_EQ(plain_name("\"A\"\"b\""), "a\"b");
  EXPECT_EQ(plain_name("[A]"), "a");
}

}  // namespace
}  // namespace alidade::test
