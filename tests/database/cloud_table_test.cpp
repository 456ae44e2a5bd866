// SPDX-License-Identifier: MIT
// SQL over a stored cloud: every form gives the points that loops over all of them give.
#include <algorithm>

#include "database/sqlite/chunk_store.h"
#include "database/sqlite/scan.h"
#include "octree/distance.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

namespace {

class CloudTableTest : public SqliteTest {
 protected:
  CloudTableTest() : cloud_(site(20000)) {
    store_cloud(file_, cloud_, {.chunk_points = 64});
    database_.emplace(file_, Connection::Mode::read);
  }

  /// A ray near the cloud as the SQL text of its six numbers, and as it is.
  struct SomeRay {
    std::string numbers;
    Ray ray;
  };
  SomeRay some_ray(Random& random) {
    const glm::dvec3 origin =
        glm::dvec3(690050, 5325050, 400) +
        glm::dvec3(random.between(-80, 80), random.between(-80, 80), random.between(-5, 40));
    glm::dvec3 direction = random.direction();
    if (random.below(4) == 0) direction = {1e-200, 0, random.below(2) == 0 ? 1.0 : -1.0};
    return {fmt::format("{:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}", origin.x, origin.y, origin.z,
                        direction.x, direction.y, direction.z),
            make_ray(origin, direction)};
  }

  /// Ids of the points for which `keep` is true.
  template <class Keep>
  std::vector<double> expected(const Keep& keep) const {
    std::vector<double> ids;
    for (std::size_t id = 0; id < cloud_.size(); ++id) {
      if (keep(cloud_.world(id))) ids.push_back(static_cast<double>(id));
    }
    return ids;
  }

  std::vector<double> ids(const std::string& where) const {
    std::vector<double> found = numbers(*database_, "SELECT id FROM " + where);
    std::ranges::sort(found);
    return found;
  }

  PointCloud cloud_;
  std::optional<Connection> database_;
};

TEST_F(CloudTableTest, the_form_with_a_ray_equals_brute_force_on_100_rays) {
  Random random;
  std::size_t found = 0;
  for (int i = 0; i < 100; ++i) {
    const auto [text, ray] = some_ray(random);
    const double radius = random.between(0, 8), least = random.between(-50, 50);
    const std::vector<double> points = ids(fmt::format(
        "points({}) WHERE dist <= {:.17g} AND t > {:.17g} AND t < {:.17g}", text, radius, least, least + 60));
    EXPECT_EQ(points, expected([&](const glm::dvec3& point) {
                const RayProjection at = project(ray, point);
                return at.distance <= radius && at.t > least && at.t < least + 60;
              }))
        << text;
    found += points.size();
  }
  EXPECT_GT(found, 2000u);
}

TEST_F(CloudTableTest, conditions_on_chunks_change_no_answer) {
  Random random;
  for (int i = 0; i < 20; ++i) {
    const auto [text, ray] = some_ray(random);
    const std::string plain = "dist_ray(" + text + ", x, y, z) <= 1.5";
    const std::string pruned = "in_chunk(_chunk, ray_limit(" + text + ", -1e999, 1.5))";
    EXPECT_EQ(ids("points WHERE " + plain + " AND " + pruned), ids("points WHERE " + plain));
    // Alone it leaves out none within the limit, and many of the others.
    const std::vector<double> within = ids("points WHERE " + plain), alone = ids("points WHERE " + pruned);
    EXPECT_TRUE(std::ranges::includes(alone, within));
    EXPECT_LT(alone.size(), cloud_.size() / 2);
    const std::string slab = "dist_plane(" + text + ", x, y, z) BETWEEN -2 AND 3";
    EXPECT_EQ(ids("points WHERE " + slab + " AND in_chunk(_chunk, plane_limit(" + text + ", -2, 3))"),
              ids("points WHERE " + slab));
    // Both branches of an OR are planned for themselves.
    EXPECT_EQ(ids("points WHERE (" + plain + " AND " + pruned + ") OR (x < 690001 AND z > 410)"),
              ids("points WHERE " + plain + " OR (x < 690001 AND z > 410)"));
  }
}

TEST_F(CloudTableTest, rows_in_order_are_the_nearest) {
  Random random;
  for (int i = 0; i < 20; ++i) {
    const auto [text, ray] = some_ray(random);
    std::vector<std::pair<double, double>> all;
    for (std::size_t id = 0; id < cloud_.size(); ++id) {
      const RayProjection at = project(ray, cloud_.world(id));
      if (at.t >= 0) all.emplace_back(at.distance, at.t);
    }
    std::ranges::sort(all);
    std::vector<double> nearest;
    for (std::size_t k = 0; k < std::min<std::size_t>(10, all.size()); ++k) nearest.push_back(all[k].first);
    EXPECT_EQ(
        numbers(*database_, "SELECT dist FROM points(" + text + ") WHERE t >= 0 ORDER BY dist LIMIT 10"),
        nearest);
    double first = std::numeric_limits<double>::infinity();
    for (const auto& [distance, t] : all) first = distance <= 1 ? std::min(first, t) : first;
    const std::vector<double> hit = numbers(
        *database_, "SELECT t FROM points(" + text + ") WHERE dist <= 1 AND t >= 0 ORDER BY t LIMIT 1");
    if (std::isinf(first)) {
      EXPECT_TRUE(hit.empty());
    } else {
      EXPECT_EQ(hit, std::vector<double>{first});
    }
    EXPECT_EQ(
        numbers(*database_, "SELECT dist FROM points(" + text + ") WHERE t >= 0 ORDER BY dist DESC LIMIT 1"),
        all.empty() ? std::vector<double>() : std::vector<double>{all.back().first});
  }
}

TEST_F(CloudTableTest, rows_in_order_come_along_the_whole_line) {
  Random random;
  std::size_t found = 0;
  for (int i = 0; i < 10; ++i) {
    const auto [text, ray] = some_ray(random);
    std::vector<double> along;
    for (std::size_t id = 0; id < cloud_.size(); ++id) {
      const RayProjection at = project(ray, cloud_.world(id));
      if (at.distance <= 8) along.push_back(at.t);
    }
    std::ranges::sort(along);
    EXPECT_EQ(numbers(*database_, "SELECT t FROM points(" + text + ") WHERE dist <= 8 ORDER BY t"), along);
    found += along.size();
  }
  EXPECT_GT(found, 1000u);
}

TEST_F(CloudTableTest, boxes_are_conditions_on_coordinates) {
  const std::vector<double> inside = expected([](const glm::dvec3& point) {
    return point.x >= 690010 && point.x < 690020 && point.y > 5325030 && point.y <= 5325050 &&
           point.z <= 400.25;
  });
  EXPECT_GT(inside.size(), 20u);
  EXPECT_EQ(ids("points WHERE x >= 690010 AND x < 690020 AND y > 5325030 AND 5325050 >= y AND z <= 400.25"),
            inside);
  EXPECT_EQ(ids("points WHERE x BETWEEN 690010 AND 690010").size(),
            expected([](const glm::dvec3& point) { return point.x == 690010; }).size());
  const glm::dvec3 one = cloud_.world(77);
  EXPECT_FALSE(
      ids(fmt::format("points WHERE x = {:.17g} AND y = {:.17g} AND z = {:.17g}", one.x, one.y, one.z))
          .empty());
}

TEST_F(CloudTableTest, rays_of_a_table_are_joined) {
  Random random;
  run(database_->get(), "CREATE TEMP TABLE rays(ray, ox, oy, oz, dx, dy, dz)");
  std::vector<double> counts;
  for (int i = 0; i < 8; ++i) {
    const auto [text, ray] = some_ray(random);
    run(database_->get(), fmt::format("INSERT INTO rays VALUES({}, {})", i, text));
    counts.push_back(static_cast<double>(
        expected([&](const glm::dvec3& point) { return project(ray, point).distance <= 1; }).size()));
  }
  EXPECT_EQ(numbers(*database_,
                    "SELECT (SELECT count(*) FROM points(r.ox, r.oy, r.oz, r.dx, r.dy, r.dz) WHERE dist <= "
                    "1) FROM rays r "
                    "ORDER BY ray"),
            counts);
  EXPECT_EQ(numbers(*database_,
                    "SELECT count(p.id) FROM rays r LEFT JOIN points p ON dist_ray(r.ox, r.oy, r.oz, r.dx, "
                    "r.dy, r.dz, x, y, z) "
                    "<= 1 GROUP BY ray ORDER BY ray"),
            counts);
}

TEST_F(CloudTableTest, few_chunks_are_read) {
  const CloudSchema schema = read_cloud_schema(database_->get(), "main", "points");
  ChunkStore store(database_->get(), "main", "points", schema);
  const Ray ray = make_ray({690050, 5325050, 500}, {0.01, 0.02, -1});
  PointCursor within(store, schema, {.points = {.lines = {{.ray = ray, .distance = {0, 1}}}}},
                     RowOrder::stored);
  while (!within.at_end()) within.next();
  EXPECT_GT(within.reads().rows_given, 0u);
  EXPECT_LT(within.reads().chunks_read, schema.chunk_count / 15);
  PointCursor nearest(store, schema, {.points = {.lines = {{.ray = ray}}}}, RowOrder::distance);
  for (int k = 1; k < 10; ++k) nearest.next();
  EXPECT_LT(nearest.reads().chunks_read, schema.chunk_count / 15);
  EXPECT_EQ(schema.chunk_count, (20000u + 63) / 64);
}

TEST_F(CloudTableTest, columns_hold_the_attributes) {
  Statement row(
      database_->get(),
      "SELECT id, red, green, blue, classification, return_number, number_of_returns, gps_time, Height, "
      "x, y, z FROM points");
  std::size_t count = 0;
  for (; row.step(); ++count) {
    const auto id = static_cast<std::size_t>(row.whole(0));
    ASSERT_LT(id, cloud_.size());
    ASSERT_EQ(glm::dvec3(row.number(9), row.number(10), row.number(11)), cloud_.world(id));
    ASSERT_EQ(Color16(row.whole(1), row.whole(2), row.whole(3)), cloud_.colors[id]);
    ASSERT_EQ(row.whole(4), cloud_.classifications[id]);
    ASSERT_EQ(row.whole(5), cloud_.returns[id].number);
    ASSERT_EQ(row.whole(6), 3);
    ASSERT_EQ(row.number(7), cloud_.gps_times[id]);
    ASSERT_EQ(row.is_null(8), id % 200 == 0);
    if (id % 200 != 0) {
      ASSERT_EQ(row.number(8), 0.01 * static_cast<double>(id % 200));
    }
  }
  EXPECT_EQ(count, cloud_.size());
  EXPECT_EQ(numbers(*database_, "SELECT count(DISTINCT rowid) FROM points"), std::vector<double>{20000});
}

TEST_F(CloudTableTest, what_needs_a_ray_is_an_error_without_one) {
  const std::string ray = "690050, 5325050, 400, 1, 0, 0";
  for (const std::string& statement : std::vector<std::string>{
           "SELECT dist FROM points", "SELECT id FROM points WHERE dist <= 1",
           "SELECT id FROM points WHERE t > 0", "SELECT id FROM points WHERE ox = 1",
           "SELECT p.id FROM points p JOIN points q ON p.ox = q.ox", "SELECT id FROM points(1, 2, 3)"}) {
    const std::string error = error_of(*database_, statement);
    EXPECT_NE(error.find("FROM TABLE(ox, oy, oz, dx, dy, dz)"), std::string::npos) << statement << "\n"
                                                                                   << error;
  }
  // There SQLite (3.40) hands over no arguments.
  EXPECT_TRUE(error_of(*database_, "SELECT count(p.id) FROM (SELECT 5 AS far) o RIGHT JOIN points(" + ray +
                                       ") p ON p.dist < o.far")
                  .find("FROM TABLE(ox, oy, oz, dx, dy, dz)") != std::string::npos);
  EXPECT_EQ(numbers(*database_, "SELECT count(o.far) FROM points(" + ray +
                                    ") p LEFT JOIN (SELECT 5 AS far) o ON p.dist < o.far"),
            numbers(*database_, "SELECT count(*) FROM points(" + ray + ") WHERE dist < 5"));
  EXPECT_EQ(ids("points(" + ray + ") WHERE ox = 1 OR dist < 1"), ids("points(" + ray + ") WHERE dist < 1"));
  EXPECT_NE(error_of(*database_, "SELECT id FROM points(" + ray + ", 7)")
                .find("a ray and a chunk number exclude each other"),
            std::string::npos);
}

TEST_F(CloudTableTest, numbers_at_the_ends_are_compared_as_any) {
  EXPECT_EQ(ids("points WHERE x > -9223372036854775808").size(), 20000u);
  EXPECT_EQ(ids("points WHERE x < -9223372036854775807").size(), 0u);
}

TEST_F(CloudTableTest, a_row_is_found_by_its_rowid) {
  const std::vector<double> some =
      numbers(*database_, "SELECT rowid FROM points WHERE id IN (3, 500, 19999)");
  ASSERT_EQ(some.size(), 3u);
  for (const double rowid : some) {
    const std::string sql = fmt::format("FROM points WHERE rowid = {}", static_cast<std::int64_t>(rowid));
    EXPECT_EQ(numbers(*database_, "SELECT rowid " + sql), std::vector<double>{rowid});
    EXPECT_EQ(numbers(*database_, "SELECT count(*) " + sql + " AND z < 0"), std::vector<double>{0});
  }
  const ScanReads before = database_->reads();
  EXPECT_EQ(numbers(*database_, fmt::format("SELECT count(*) FROM points WHERE rowid IN "
                                            "({}, {:.1f}, -1, 1.5, 1e300, NULL, 9223372036854775807)",
                                            some[0], some[1])),
            std::vector<double>{2});
  EXPECT_LE(database_->reads().chunks_read - before.chunks_read, 3u);
  EXPECT_EQ(numbers(*database_, "SELECT count(*) FROM points WHERE rowid = 'x'"), std::vector<double>{0});
  EXPECT_EQ(ids("points WHERE _chunk = 3").size(), 64u);
}

TEST_F(CloudTableTest, bad_input_is_an_error_and_null_matches_nothing) {
  const std::string origin = "690050, 5325050, 400";
  const auto says = [&](const std::string& sql, const std::string& part) {
    const std::string error = error_of(*database_, sql);
    EXPECT_NE(error.find(part), std::string::npos) << sql << "\n" << error;
  };
  says("SELECT dist_ray(" + origin + ", 0, 0, 0, x, y, z) FROM points",
       "dist_ray: the ray direction is zero");
  says("SELECT dist_plane(" + origin + ", 0, 0, 0, x, y, z) FROM points", "dist_plane: ");
  says("SELECT dist_ray(" + origin + ", 1e999, 0, 0, x, y, z) FROM points", "direction is not finite");
  says("SELECT dist_ray(1e999, 0, 0, 1, 0, 0, x, y, z) FROM points", "origin is not finite");
  says("SELECT dist_plane(1e999, 0, 0, 1, 0, 0, x, y, z) FROM points", "point of a plane is not finite");
  says("SELECT dist_plane(" + origin + ", 0, -1e999, 0, x, y, z) FROM points",
       "normal of a plane is not finite");
  EXPECT_EQ(
      numbers(*database_, "SELECT dist_ray(" + origin + ", 1, 0, 0, 1, NULL, 1) IS NULL AND dist_plane(" +
                              origin + ", 1, 0, 0, NULL, 1, 1) IS NULL"),
      std::vector<double>{1});
  says("SELECT dist_ray(" + origin + ", 1, 0, '0', x, y, z) FROM points",
       "invalid argument 6; expected a number");
  says("SELECT dist_ray(" + origin + ", 1, 0, x, y, z) FROM points", "wrong number of arguments");
  says("SELECT id FROM points(" + origin + ", 0, 0, 0)", "the ray direction is zero");
  says("SELECT id FROM points(" + origin + ", 1, 'east', 0)", "invalid argument 5; expected a number");
  says("SELECT id FROM points WHERE in_chunk(_chunk, 'all')", "not a limit");
  says("SELECT id FROM points WHERE in_chunk(_chunk, ray_limit(" + origin + ", 0, 0, 0, 0, 1))",
       "the ray direction is zero");
  says("INSERT INTO points(id) VALUES(1)", "may not be modified");
  says("CREATE VIRTUAL TABLE temp.more USING pointcloud(1)", "no arguments");
  says("CREATE VIRTUAL TABLE temp.more USING pointcloud", "more_cloud");
  for (const std::string& none : std::vector<std::string>{
           "points WHERE dist_ray(" + origin + ", 1, 0, 0, x, y, z) <= NULL",
           "points WHERE dist_ray(NULL, 0, 0, 1, 0, 0, x, y, z) <= 1", "points(" + origin + ", 1, 0, NULL)",
           "points(" + origin + ", 1, 0, 0) WHERE dist <= NULL",
           "points(" + origin + ", 1, 0, 0) WHERE dist <= -1",
           "points(" + origin + ", 1, 0, 0) WHERE dist BETWEEN 2 AND 1", "points WHERE x < NULL",
           "points WHERE in_chunk(_chunk, ray_limit(" + origin + ", 1, 0, 0, 0, NULL))"}) {
    EXPECT_TRUE(ids(none).empty()) << none;
  }
  // Text is larger than every number, also where there is a plan.
  EXPECT_EQ(ids("points(" + origin + ", 1, 0, 0) WHERE dist < 'far'").size(), 20000u);
}

}  // namespace
}  // namespace alidade::test
