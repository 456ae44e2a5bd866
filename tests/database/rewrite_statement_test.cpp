// SPDX-License-Identifier: MIT
// Plain SQL keeps the value of a distance and every row of the answer.
#include "database/sql/rewrite_statement.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "database/box_cover.h"
#include "database/point_filter.h"
#include "octree/distance.h"
#include "tests/database/sqlite_fixture.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace database;

namespace {

const Bounds k_bounds{{0, 0, 0}, {64, 64, 32}};

std::string rewritten(const std::string& condition, SqlDialect dialect = SqlDialect::datafusion) {
  return rewrite_statement("SELECT * FROM p WHERE " + condition, {.dialect = dialect, .bounds = k_bounds})
      .text;
}

std::string reason(const std::string& sql) {
  return rewrite_statement(sql, {.bounds = k_bounds}).reason;
}

TEST(BoxCover, holds_every_point_of_random_rays_and_slabs) {
  Random random;
  double shares = 0.0;
  for (int i = 0; i < 60; ++i) {
    const Ray ray = make_ray(glm::dvec3(32, 32, 16) + 20.0 * random.in_cube(), random.direction());
    const Plane plane = make_plane(ray.origin, random.direction());
    const PointFilter filter{.lines = {{ray, {0.0, 1.0}}}, .planes = {{plane, {-30.0, 5.0}}}};
    const BoxCover boxes = cover([&](const Bounds& box) { return may_hold(filter, box); }, k_bounds, 16);
    ASSERT_LE(boxes.boxes.size(), 16U);
    for (std::size_t k = 1; k < boxes.boxes.size(); ++k)
      EXPECT_LE(boxes.boxes[k - 1].max[boxes.axis], boxes.boxes[k].min[boxes.axis]);
    for (const Bounds& box : boxes.boxes) shares += volume_share(box, k_bounds) / 60;
    for (int k = 0; k < 2000; ++k) {
      const glm::dvec3 point = ray.origin + random.between(-50, 50) * ray.direction + random.in_cube();
      if (!k_bounds.contains(point) || !holds(filter, point)) continue;
      EXPECT_TRUE(std::ranges::any_of(boxes.boxes, [&](const Bounds& box) { return box.contains(point); }))
          << i;
    }
  }
  EXPECT_LT(shares, 0.02);
}

TEST(BoxCover, is_one_box_along_an_axis_and_none_where_nothing_is) {
  const PointFilter along{.lines = {{make_ray({10, 20, 0}, {0, 0, -1}), {0.0, 1.0}}}};
  const BoxCover one = cover([&](const Bounds& box) { return may_hold(along, box); }, k_bounds, 16);
  ASSERT_EQ(one.boxes.size(), 1U);
  EXPECT_NEAR(one.boxes.front().min.x, 9.0, 0.1);
  EXPECT_NEAR(one.boxes.front().max.y, 21.0, 0.1);
  EXPECT_EQ(one.boxes.front().max.z, 32.0);
  EXPECT_TRUE(cover([](const Bounds&) { return false; }, k_bounds, 16).boxes.empty());
  // A cloud of one level.
  const BoxCover flat =
      cover([&](const Bounds& box) { return may_hold(along, box); }, {{0, 0, 7}, {64, 64, 7}}, 16);
  ASSERT_EQ(flat.boxes.size(), 1U);
}

TEST(RewriteStatement, writes_expressions_and_one_box) {
  EXPECT_EQ(
      rewrite_statement("SELECT id, dist_plane(1,2,3, 0,0,2, a.x,a.y,a.z) AS h FROM p a ORDER BY h", {}).text,
      "SELECT id, ((a.z - 3e+00) * 1e+00) AS h FROM p a ORDER BY h");
  EXPECT_EQ(
      rewritten("dist_plane(0,0,-16, 0,0,1, x,y,z) BETWEEN 16 AND 16.5 -- low\nLIMIT 3"),
      "SELECT * FROM p WHERE z <= 5.0048828125e-01 AND (((z + 1.6e+01) * 1e+00 + 0e+00) BETWEEN 1.6e+01 AND "
      "1.65e+01) -- "
      "low\nLIMIT 3");
  // It passes beside the bounds.
  EXPECT_EQ(rewritten("dist_ray(10,-20,0, 0,0,-1, x,y,z) <= 1"),
            "SELECT * FROM p WHERE 1 = 0 AND (sqrt(((y + 2e+01) * -1e+00) * ((y + 2e+01) * -1e+00) + ((x - "
            "1e+01) * "
            "-1e+00) * ((x - 1e+01) * -1e+00)) <= 1e+00)");
}

TEST(RewriteStatement, a_plane_without_a_lower_limit_keeps_what_is_behind_it) {
  // z <= 20 and z >= 12: what is on the other side of z = 16 is at negative distances.
  const std::string below = rewritten("dist_plane(0,0,16, 0,0,1, x,y,z) <= 4"),
                    above = rewritten("dist_plane(0,0,16, 0,0,1, x,y,z) >= -4");
  EXPECT_NE(below.find("WHERE z <= 2.0"), std::string::npos) << below;
  EXPECT_EQ(below.find("z >="), std::string::npos) << below;
  EXPECT_NE(above.find("WHERE z >= 1.1"), std::string::npos) << above;
  EXPECT_EQ(above.find("z <="), std::string::npos) << above;
}

TEST(RewriteStatement, gives_each_engine_its_form_of_several_boxes) {
  const std::string diagonal = "dist_ray(0,0,0, 1,1,0.5, x,y,z) <= 1";
  const std::string either = rewritten(diagonal);
  EXPECT_NE(either.find(") OR ("), std::string::npos) << either;
  for (const SqlDialect dialect : {SqlDialect::duckdb, SqlDialect::trino}) {
    const std::string scans = rewritten(diagonal, dialect);
    EXPECT_NE(scans.find("FROM (SELECT * FROM p WHERE "), std::string::npos) << scans;
    EXPECT_NE(scans.find(" UNION ALL SELECT * FROM p WHERE "), std::string::npos) << scans;
    EXPECT_NE(scans.find(") AS p WHERE sqrt("), std::string::npos) << scans;
  }
  EXPECT_NE(
      rewrite_statement("SELECT q.x FROM read_parquet('a''b') AS q WHERE " + diagonal, {.bounds = k_bounds})
          .text.find("SELECT * FROM read_parquet('a''b') WHERE"),
      std::string::npos);
}

TEST(RewriteStatement, tells_what_prunes_nothing) {
  const std::string near = "dist_ray(1,2,3, 0,0,1, x,y,z) <= 1";
  EXPECT_EQ(rewrite_statement("SELECT 1 FROM p WHERE " + near, {}).reason,
            "the bounds of the points are not given");
  EXPECT_EQ(reason("SELECT 1 FROM p JOIN q ON p.id = q.id WHERE " + near),
            "it is not SELECT ... FROM one table WHERE ...");
  EXPECT_EQ(reason("SELECT 1 FROM p WHERE id IN (SELECT 1 FROM p WHERE " + near + ")"),
            "it has more than one SELECT");
  EXPECT_EQ(reason("SELECT 1 FROM p WHERE NOT " + near),
            "a distance is part of a larger expression or below NOT");
  EXPECT_EQ(reason("SELECT 1 FROM p WHERE " + near + " OR id < 3"),
            "its condition prunes nothing: dist_ray or dist_plane must be compared with a constant");
  EXPECT_EQ(reason("SELECT 1 FROM p WHERE dist_ray(1,2,3, 0,0,1, x,y,z) <= id"),
            "a limit on a distance is not constant");
  EXPECT_EQ(reason("SELECT 1 FROM p WHERE id < 3 AND (" + near + " OR " + near + ")"), "");
}

TEST(RewriteStatement, reads_other_dialects_or_leaves_them) {
  const std::string near = "dist_ray(1,2,3, 0,0,1, x,y,z) <= 1";
  // A name behind a dot is no keyword, so the OR counts.
  for (const std::string name : {"limit", "group", "case", "end"})
    EXPECT_NE(reason("SELECT 1 FROM p WHERE " + near + " AND p." + name + " = 3 OR id = 2"), "") << name;
  EXPECT_EQ(reason("EXPLAIN ANALYZE SELECT x::int FROM p WHERE " + near), "");
  EXPECT_EQ(reason("SELECT {'a': 1}, [x, y] FROM p WHERE " + near), "");
  for (const std::string clause : {"FOR UPDATE", "SORT BY id", "USING SAMPLE 3", "UNION ALL FROM q"}) {
    const std::string text = rewritten("id > 3 AND " + near + " " + clause);
    EXPECT_EQ(text.find(clause + ")"), std::string::npos) << text;
  }
  // What is calculated differs, and parameters are unknown.
  for (const std::string limit :
       {"(5/2)", "(? IS NULL)", "?", "(SELECT 4)", "abs(4)", "NULL", "'4'", "1e999"})
    EXPECT_NE(reason("SELECT 1 FROM p WHERE dist_ray(1,2,3, 0,0,1, x,y,z) <= " + limit), "") << limit;
  EXPECT_NE(rewritten("dist_plane(0,0,0, 0,0,1, x,y,z) <= -(-(+4.5))").find("<= 4.5e+00"), std::string::npos);
  EXPECT_EQ(reason("SELECT 1 FROM p WHERE dist_ray(1,2,3, 0,0,1, x,y,z) >= 1"),
            "its condition may hold anywhere within the bounds");
}

TEST(RewriteStatement, rejects_what_it_cannot_write) {
  const std::string near = "dist_ray(1,2,3, 0,0,1, x,y,z) <= 1";
  for (const std::string& foreign :
       {"id = 3 /* a /* b */ AND " + near + " -- */",
        near + " AND n <> $a$ ' $a$ OR id = 3 AND n <> $a$ ' $a$", near + " AND n = E'it\\'' OR id = 3 -- '",
        near + " AND tags <> ['a]', 'b'] OR id = 3 --'"})
    EXPECT_THROW(rewritten(foreign), Error) << foreign;
  for (const std::string wrong :
       {"dist_ray(r.ox,2,3, 0,0,1, x,y,z) <= 1", "dist_ray(1,2,3, 0,0,0, x,y,z) <= 1",
        "dist_ray(1,2,3,x,y,z) <= 1", "dist_ray(1,2,3, 0,0,1, x,z,y) <= 1",
        "dist_ray(?,2,3, 0,0,1, x,y,z) <= 1", "dist_ray(1,2,3, 0,0,1, x,y,z <= 1",
        "dist_ray(1,2,NULL, 0,0,1, x,y,z) <= 1", "dist_ray(1,2,3, 0,0,1, \"X\",y,z) <= 1",
        "dist_plane(0,0,1/2, 0,0,1, x,y,z) <= 1"})
    EXPECT_THROW(rewritten(wrong), Error) << wrong;
}

class RewriteTest : public SqliteTest {};

TEST_F(RewriteTest, answers_are_those_of_the_statement) {
  store_cloud(file_, site(1000), {.chunk_points = 64});
  const Connection connection(file_, Connection::Mode::read);
  const Bounds bounds{{689990, 5324990, 390}, {690110, 5325110, 440}};
  Random random;
  const auto number = [&](double low, double high) {
    return fmt::format("{:.6g}", random.between(low, high));
  };
  const auto distance = [&](const std::string& name) {
    return fmt::format("{}({},{},{}, {},{},{}, x,y,z)", name, 690050 + random.between(-50, 50),
                       5325050 + random.between(-50, 50), number(395, 430), number(-1, 1), number(-1, 1),
                       number(-1, 1));
  };
  const auto condition = [&] {
    return random.below(3) > 0
               ? distance("dist_ray") + " <= " + number(0, 20)
               : distance("dist_plane") + " BETWEEN " + number(-9, 0) + " AND " + number(0, 9);
  };
  const auto rows = [&](const std::string& sql) {
    Statement statement(connection.get(), sql);
    std::vector<std::string> found;
    while (statement.step()) found.push_back(fmt::format("{} {}", statement.whole(0), statement.number(1)));
    std::ranges::sort(found);
    return found;
  };
  std::size_t count = 0, boxes = 0;
  for (int i = 0; i < 200; ++i) {
    const std::string sql =
        fmt::format("SELECT id, {} FROM points AS p WHERE {} {} ({} {} id % 3 = 1)", distance("dist_ray"),
                    condition(), i % 2 == 0 ? "AND" : "OR", condition(), i % 5 == 0 ? "OR" : "AND");
    const RewrittenStatement plain = rewrite_statement(
        sql, {.dialect = i % 4 < 2 ? SqlDialect::sqlite : SqlDialect::duckdb, .bounds = bounds});
    EXPECT_EQ(plain.text.find("dist_"), std::string::npos);
    const std::vector<std::string> expected = rows(sql);
    EXPECT_EQ(rows(plain.text), expected) << sql << "\n" << plain.text;
    count += expected.size();
    boxes += plain.box_count;
  }
  EXPECT_GT(count, 3000U);
  EXPECT_GT(boxes, 1000U);
}

}  // namespace
}  // namespace alidade::test
