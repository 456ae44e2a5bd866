// SPDX-License-Identifier: MIT
#include <tbb/global_control.h>

#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "octree/query_batch.h"
#include "octree/simd/make_rays.h"
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

template <class Answer>
void expect_all_same(const Answers<Answer>& found, const std::vector<std::vector<Answer>>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  ASSERT_EQ(found.begin.front(), 0u);
  ASSERT_EQ(found.begin.back(), found.all.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_TRUE(same_hits(found[i], std::span<const Answer>(expected[i]))) << "target " << i;
  }
}

/// find and count of many targets against find of each, on one and more threads.
template <class Target, class Query>
void expect_as_one_by_one(const Octree& octree, const std::vector<QueryCase<Target, Query>>& cases,
                          const Query& query) {
  std::vector<Target> targets;
  for (const auto& c : cases) targets.push_back(c.target);
  std::vector<decltype(find(octree, targets[0], query))> expected;
  for (const Target& target : targets) expected.push_back(find(octree, target, query));
  for (const std::size_t threads : {1, 2, 5}) {
    SCOPED_TRACE(std::to_string(threads) + " threads");
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    expect_all_same(find(octree, std::span<const Target>(targets), query), expected);
    std::vector<std::size_t> counts(targets.size());
    count(octree, std::span<const Target>(targets), query, counts);
    for (std::size_t i = 0; i < targets.size(); ++i) ASSERT_EQ(counts[i], expected[i].size());
  }
}

void expect_closest_and_occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
                                 const std::vector<std::optional<Hit>>& expected) {
  std::vector<std::optional<Hit>> hits(rays.size());
  std::vector<std::uint8_t> blocked(rays.size());
  closest(octree, rays, query, hits);
  occluded(octree, rays, query, blocked);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(same_hits(hits[i], expected[i])) << "ray " << i;
    ASSERT_EQ(blocked[i] != 0, expected[i].has_value()) << "ray " << i;
  }
}

class Batch : public ::testing::Test {
 protected:
  Batch() : family_(point_families().back()), octree_(build(family_.cloud)) {}

  const PointFamily family_;
  const Octree octree_;
  Random random_;
};

// More targets than one task takes, so that the seams between tasks are among them.
constexpr std::size_t k_targets = 700;

TEST_F(Batch, of_rays_answers_in_the_order_of_the_rays_on_any_number_of_threads) {
  const auto cases = find_ray_cases(family_.cloud, k_targets, random_);
  expect_as_one_by_one(octree_, cases, RayQuery{.radius = 0.2});
  expect_as_one_by_one(octree_, cases, RayQuery{.radius = 0.5, .measure = Measure::t, .k = 3});
  expect_as_one_by_one(octree_, cases, RayQuery{.measure = Measure::distance, .k = 8});
  expect_as_one_by_one(octree_, cases, RayQuery{.measure = Measure::distance, .k = 1});
  expect_as_one_by_one(octree_, cases, RayQuery{.radius = 0.2, .k = 1});
}

TEST_F(Batch, of_rays_gives_closest_and_occluded_in_the_order_of_the_rays) {
  std::vector<Ray> rays;
  for (const FindRayCase& c : find_ray_cases(family_.cloud, 2000, random_)) rays.push_back(c.target);
  const CandidateFilter odd = [](const Candidate& point) { return point.point_id % 2 == 1; };
  for (const RayQuery& query :
       {RayQuery{.radius = 0.2}, RayQuery{.radius = 0.2, .measure = Measure::t, .filter = odd},
        RayQuery{.measure = Measure::distance}, RayQuery{.radius = 0.3, .entry_min = 1e-6}}) {
    std::vector<std::optional<Hit>> expected;
    for (const Ray& ray : rays) expected.push_back(closest(octree_, ray, query));
    for (const std::size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      expect_closest_and_occluded(octree_, rays, query, expected);
    }
  }
}

TEST_F(Batch, of_many_rays_that_start_here_and_there_answers_in_their_order) {
  // So many that they are sorted; among them rays that lanes do not answer and far away ones.
  std::vector<Ray> rays;
  for (const FindRayCase& c : find_ray_cases(family_.cloud, 55000, random_)) rays.push_back(c.target);
  for (std::size_t i = 0; i < rays.size(); i += 1000) {
    rays[i].direction *= 1.0 + 1e-9;
    rays[i + 1].origin += glm::dvec3(1e9, 0, 0);
  }
  const CandidateFilter odd = [](const Candidate& point) { return point.query_index % 2 == 1; };
  for (const RayQuery& query :
       {RayQuery{.radius = 0.2}, RayQuery{.radius = 0.2, .measure = Measure::t, .filter = odd}}) {
    std::vector<std::optional<Hit>> expected;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      expected.push_back(closest(octree_, rays[i], {.radius = query.radius, .measure = query.measure}));
      if (query.filter && i % 2 == 0) expected.back().reset();
    }
    for (const std::size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      expect_closest_and_occluded(octree_, rays, query, expected);
    }
  }
  rays[41000].t_max = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::optional<Hit>> hits(rays.size());
  try {
    closest(octree_, rays, {.radius = 0.2}, hits);
    FAIL() << "a ray without an interval was accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("ray 41000"), std::string::npos) << error.what();
  }
}

/// Rows of origin, direction, t_min and t_max.
RayColumns columns_of(const std::vector<Ray>& rows) {
  const auto column = [&](const double& first) {
    return RayColumns::Column{&first, sizeof(Ray) / sizeof(double)};
  };
  return {rows.size(), column(rows[0].origin.x), column(rows[0].direction.x), column(rows[0].t_min),
          column(rows[0].t_max)};
}

void expect_same_from_columns(const Octree& octree, const std::vector<Ray>& rows, const RayQuery& query) {
  std::vector<Ray> rays;
  for (const Ray& row : rows) rays.push_back(make_ray(row.origin, row.direction, row.t_min, row.t_max));
  std::vector<std::optional<Hit>> expected(rows.size());
  closest(octree, rays, query, expected);
  std::vector<std::int64_t> ids(rows.size());
  std::vector<double> t(rows.size()), distance(rows.size()), entry(rows.size());
  closest(octree, columns_of(rows), query, {ids.data(), t.data(), distance.data(), entry.data()});
  std::vector<std::uint8_t> blocked(rows.size());
  occluded(octree, columns_of(rows), query, blocked);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::optional<Hit>& hit = expected[i];
    ASSERT_EQ(blocked[i] != 0, hit.has_value()) << "ray " << i;
    ASSERT_EQ(ids[i], hit ? static_cast<std::int64_t>(hit->point_id) : -1) << "ray " << i;
    if (hit) {
      ASSERT_EQ(std::tie(t[i], distance[i], entry[i]), std::tie(hit->t, hit->distance, hit->entry))
          << "ray " << i;
    } else {
      ASSERT_TRUE(std::isnan(t[i]) && std::isnan(distance[i]) && std::isnan(entry[i])) << "ray " << i;
    }
  }
}

/// Scattered, so that many are sorted; with directions of any length.
std::vector<Ray> rows_of_any_length(const PointCloud& cloud, std::size_t count, Random& random) {
  std::vector<Ray> rows;
  for (const FindRayCase& c : find_ray_cases(cloud, count, random)) {
    rows.push_back(c.target);
    const int exponent = static_cast<int>(rows.size() * 7 % 600) - 300;
    rows.back().direction *= 1.7 * std::pow(10.0, exponent);
  }
  return rows;
}

TEST_F(Batch, of_rays_in_columns_has_the_answers_of_the_rays_that_make_ray_makes) {
  const CandidateFilter odd = [](const Candidate& point) { return point.query_index % 2 == 1; };
  for (const InstructionSet instruction_set : available_instruction_sets()) {
    const Octree octree = octree_.with_instruction_set(instruction_set);
    for (const std::size_t count : {1, 63, 4000}) {
      const std::vector<Ray> rows = rows_of_any_length(family_.cloud, count, random_);
      expect_same_from_columns(octree, rows, {.radius = 0.2});
      expect_same_from_columns(octree, rows, {.radius = 0.2, .measure = Measure::t, .filter = odd});
      expect_same_from_columns(octree, rows, {.measure = Measure::distance});
    }
  }
  expect_same_from_columns(octree_, rows_of_any_length(family_.cloud, 55000, random_), {.radius = 0.2});
  expect_same_from_columns(Octree(), rows_of_any_length(family_.cloud, 10, random_), {.radius = 0.2});
}

/// All directions of these numbers, whose quotients round, underflow or are subnormal.
std::vector<Ray> rows_at_the_limits() {
  constexpr double k_numbers[] = {0.0,    -0.0,  1.0,     -0.3,   5e-324, -2e-310, 1e-300,
                                  -1e300, 1e308, 1.7e308, 1e-155, 1e155,  -7.0};
  std::vector<Ray> rows;
  for (const double x : k_numbers)
    for (const double y : k_numbers)
      for (const double z : k_numbers) {
        if (x == 0.0 && y == 0.0 && z == 0.0) continue;
        rows.push_back({{-0.0, y, z}, {x, y, z}, -0.0, x});
      }
  return rows;
}

bool have_same_bits(const Ray& a, const Ray& b) {
  static_assert(sizeof(Ray) == 8 * sizeof(double));
  using Bits = std::array<std::uint64_t, 8>;
  return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

TEST(MakeRays, makes_what_make_ray_makes_bit_for_bit_with_every_instruction_set) {
  const std::vector<Ray> rows = rows_at_the_limits();
  const RayColumns columns = columns_of(rows);
  std::vector<simd::SortKey> order(rows.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i * 1001 % rows.size();
  for (const InstructionSet instruction_set : available_instruction_sets()) {
    std::vector<Ray> rays(rows.size());
    ASSERT_TRUE(simd::make_rays(instruction_set, columns, 0, {}, rays));
    for (std::size_t i = 0; i < rows.size(); ++i)
      ASSERT_TRUE(
          have_same_bits(rays[i], make_ray(rows[i].origin, rows[i].direction, rows[i].t_min, rows[i].t_max)))
          << "row " << i;
    for (const std::size_t count : {std::size_t{1}, std::size_t{13}, std::size_t{67}, rows.size()}) {
      std::vector<Ray> some(count);
      const std::span<const simd::SortKey> numbers = std::span(order).first(count);
      ASSERT_TRUE(simd::make_rays(instruction_set, columns, 0, numbers, some));
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_TRUE(have_same_bits(some[i], rays[simd::number_of(numbers[i])]))
            << "row " << i << " of " << count;
      ASSERT_TRUE(simd::make_rays(instruction_set, columns, rows.size() - count, {}, some));
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_TRUE(have_same_bits(some[i], rays[rows.size() - count + i])) << "row " << i << " of " << count;
    }
  }
}

TEST_F(Batch, of_rays_in_columns_names_the_first_row_that_is_no_ray) {
  constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double k_infinite = std::numeric_limits<double>::infinity();
  const std::vector<Ray> good = rows_of_any_length(family_.cloud, 55000, random_);
  const std::vector<std::pair<Ray, std::string>> bad{
      {{{0, k_nan, 0}, {0, 0, 1}}, "origin is not finite"},
      {{{0, 0, -k_infinite}, {0, 0, 1}}, "origin is not finite"},
      {{{0, 0, 0}, {0, 0, 0}}, "direction is zero"},
      {{{0, 0, 0}, {0, 1, k_nan}}, "direction is not finite"},
      {{{0, 0, 0}, {k_infinite, 1, 0}}, "direction is not finite"},
      {{{0, 0, 0}, {0, 0, 1}, k_nan}, "NaN"},
      {{{0, 0, 0}, {0, 0, 1}, 0, k_nan}, "NaN"}};
  for (const std::size_t count : {3000, 55000}) {
    for (const auto& [ray, problem] : bad) {
      std::vector<Ray> rows(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(count));
      rows[count - 7] = rows[count - 300] = ray;
      std::vector<std::uint8_t> blocked(count);
      try {
        occluded(octree_, columns_of(rows), {.radius = 0.2}, blocked);
        FAIL() << problem << " was accepted";
      } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("ray " + std::to_string(count - 300) + ": "), std::string::npos) << text;
        EXPECT_NE(text.find(problem), std::string::npos) << text;
      }
    }
  }
}

TEST_F(Batch, of_rays_in_columns_reports_its_progress_and_can_be_stopped) {
  for (const std::size_t count : {3000, 55000}) {
    const std::vector<Ray> rows = rows_of_any_length(family_.cloud, count, random_);
    std::vector<std::uint8_t> blocked(count);
    std::uint64_t last = 0;
    occluded(octree_, columns_of(rows), {.radius = 0.2}, blocked,
             [&](std::uint64_t done, std::uint64_t total) {
               EXPECT_GT(done, last);
               EXPECT_EQ(total, count);
               last = done;
               return true;
             });
    EXPECT_EQ(last, count);
    EXPECT_THROW(occluded(octree_, columns_of(rows), {.radius = 0.2}, blocked,
                          [](std::uint64_t, std::uint64_t) { return false; }),
                 Cancelled);
  }
}

TEST_F(Batch, of_rays_in_columns_can_be_asked_for_while_it_reports_its_progress) {
  const std::vector<Ray> rows = rows_of_any_length(family_.cloud, 55000, random_);
  std::vector<std::uint8_t> blocked(rows.size()), others(rows.size());
  std::atomic<int> calls = 0, depth = 0, most = 0;
  const Progress nested = [&](std::uint64_t, std::uint64_t) {
    most = std::max<int>(most, ++depth);
    if (calls++ < 3) occluded(octree_, columns_of(rows), {.radius = 0.2}, others);
    --depth;
    return true;
  };
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 5);
  occluded(octree_, columns_of(rows), {.radius = 0.2}, blocked, nested);
  EXPECT_EQ(blocked, others);
  EXPECT_EQ(most, 1);
}

TEST_F(Batch, of_cones_paths_regions_boxes_and_points_answers_in_their_order) {
  expect_as_one_by_one(octree_, cone_cases(family_.cloud, k_targets, random_), ConeQuery{.k = 5});
  expect_as_one_by_one(octree_, path_cases(family_.cloud, k_targets, random_), PathQuery{.radius = 0.5});
  expect_as_one_by_one(octree_, region_cases(family_.cloud, k_targets, random_), PointQuery{.k = 9});
  expect_as_one_by_one(octree_, box_cases(family_.cloud, k_targets, random_), PointQuery{.k = 100});
  expect_as_one_by_one(octree_, point_cases(family_.cloud, k_targets, random_), PointQuery{.k = 8});
}

TEST_F(Batch, of_nothing_answers_nothing) {
  const Answers<Hit> none = find(octree_, std::span<const Ray>(), {.radius = 1.0});
  EXPECT_EQ(none.size(), 0u);
  EXPECT_TRUE(none.all.empty());
  std::vector<std::optional<Hit>> hits;
  closest(octree_, std::span<const Ray>(), {.radius = 1.0}, hits);
}

/// A filter that admits points to every second target only.
template <class Target, class Query>
void expect_every_second_answered(const Octree& octree, const std::vector<QueryCase<Target, Query>>& cases,
                                  Query query) {
  std::vector<Target> targets;
  for (const auto& c : cases) targets.push_back(c.target);
  const std::span<const Target> span(targets);
  const auto all = find(octree, span, query);
  query.filter = [](const Candidate& point) { return point.query_index % 2 == 1; };
  const auto odd = find(octree, span, query);
  std::vector<std::size_t> counts(targets.size());
  count(octree, span, query, counts);
  std::vector<std::optional<Hit>> hits(targets.size());
  std::vector<std::uint8_t> blocked(targets.size());
  if constexpr (std::is_same_v<Target, Ray>) {
    closest(octree, span, query, hits);
    occluded(octree, span, query, blocked);
  }
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const std::size_t expected = i % 2 ? all[i].size() : 0;
    ASSERT_EQ(odd[i].size(), expected);
    ASSERT_EQ(counts[i], expected);
    if constexpr (std::is_same_v<Target, Ray>) {
      ASSERT_EQ(hits[i].has_value(), expected > 0);
      ASSERT_EQ(blocked[i] != 0, expected > 0);
    }
  }
  EXPECT_GT(odd.all.size(), 100u);
}

TEST_F(Batch, in_which_several_targets_fail_tells_of_the_first_on_any_number_of_threads) {
  const std::vector<glm::dvec3> sound(20000);
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto problem = [](std::span<const glm::dvec3> targets) -> std::string {
      try {
        for_each_target(targets, 4, [](std::size_t i) {
          if (i >= 5000 && i % 7 == 3) throw Error({.problem = "work on " + std::to_string(i)});
        });
      } catch (const Error& error) {
        return error.what();
      }
      return "none";
    };
    EXPECT_EQ(problem(sound), "work on 5001");
    std::vector<glm::dvec3> bad = sound;
    bad[19000].x = bad[4321].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(problem(bad).substr(0, 11), "point 4321:");
  }
}

TEST_F(Batch, its_filter_is_told_the_number_of_the_target) {
  expect_every_second_answered(octree_, find_ray_cases(family_.cloud, k_targets, random_),
                               RayQuery{.radius = 0.3});
  expect_every_second_answered(octree_, cone_cases(family_.cloud, k_targets, random_), ConeQuery{.k = 5});
  expect_every_second_answered(octree_, path_cases(family_.cloud, k_targets, random_),
                               PathQuery{.radius = 0.5});
  expect_every_second_answered(octree_, region_cases(family_.cloud, k_targets, random_), PointQuery{.k = 9});
  expect_every_second_answered(octree_, box_cases(family_.cloud, k_targets, random_), PointQuery{.k = 9});
  expect_every_second_answered(octree_, point_cases(family_.cloud, k_targets, random_), PointQuery{.k = 9});
}

}  // namespace
}  // namespace alidade
