// SPDX-License-Identifier: MIT
#include "visibility/points/point_visibility.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <bit>
#include <numeric>

#include "base/error.h"
#include "tests/visibility/wall_cloud.h"
#include "visibility/sight_line.h"

namespace alidade::test {

using namespace visibility;

namespace {

/// Ground of 20 by 20 metres with a wall across its middle, x = 10, 3 metres high.
WallCloud garden() {
  return WallCloud()
      .add({0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.25)
      .add({10, 4, 0.25}, {0, 12, 0}, {0, 0, 2.75}, 0.25);
}

Observer observer_at(const glm::dvec3& position) {
  Observer observer;
  observer.position = position;
  return observer;
}

const std::vector<Observer> k_observers = {observer_at({5, 10, 1.7}), observer_at({16, 3, 1.7}),
                                           observer_at({10, 10, 8})};

std::uint32_t sum(const std::vector<std::uint32_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0u);
}

TEST(PointVisibility, of_each_point_is_that_of_its_own_sight_line) {
  const WallCloud cloud = garden();
  for (const OccluderShape shape : {OccluderShape::automatic, OccluderShape::sphere}) {
    const Occluders occluders = cloud.occluders({.shape = shape});
    const PointVisibility seen = point_visibility(occluders, k_observers, {.with_blockers = true});
    ASSERT_EQ(seen.counts.size(), cloud.positions().size());
    ASSERT_EQ(seen.blockers.size(), 3u);
    const PointCloud points = make_cloud(cloud.positions(), {glm::dvec3(1e-4), glm::dvec3(0.0)});
    for (std::size_t id = 0; id < points.size(); ++id) {
      std::uint64_t mask = 0;
      for (std::size_t i = 0; i < k_observers.size(); ++i) {
        const glm::dvec3 eye = k_observers[i].position;
        const auto blocker = first_blocker(
            occluders,
            sight_line(end_near_surface(occluders, eye), end_on_point(occluders, id, points.world(id), eye)));
        ASSERT_EQ(seen.blockers[i][id], blocker ? blocker->point_id : k_no_blocker) << id;
        if (!blocker) mask |= std::uint64_t{1} << i;
      }
      ASSERT_EQ(seen.masks[id], mask) << id;
      ASSERT_EQ(seen.counts[id], static_cast<std::uint32_t>(std::popcount(mask))) << id;
    }
    ASSERT_GT(sum(seen.counts), 1000u);
  }
}

TEST(PointVisibility, ends_behind_a_wall) {
  const WallCloud cloud = garden();
  const Occluders occluders = cloud.occluders();
  const PointVisibility seen =
      point_visibility(occluders, std::span(k_observers).first(1), {.with_blockers = true});
  EXPECT_TRUE(seen.masks.empty()) << "one observer's mask says no more than its count";
  const glm::dvec3 eye = k_observers[0].position;
  for (std::size_t id = 0; id < cloud.positions().size(); ++id) {
    const glm::dvec3& point = cloud.positions()[id];
    if (point.z > 0.0) {
      // The wall itself, whose edges and foot have no clear side.
      if (point.y > 4.5 && point.y < 15.5 && point.z > 0.5 && point.z < 2.5) {
        EXPECT_EQ(seen.counts[id], 1u) << id;
      }
      continue;
    }
    const double y_at_wall = eye.y + (point.y - eye.y) * 5.0 / (point.x - eye.x);
    const bool is_in_shadow = point.x > 11.0 && y_at_wall > 4.5 && y_at_wall < 15.5;
    const bool is_free = point.x < 9.5 || (point.x > 10.5 && (y_at_wall < 3.5 || y_at_wall > 16.5));
    if (is_in_shadow) {
      EXPECT_EQ(seen.counts[id], 0u) << point.x << " " << point.y;
      ASSERT_NE(seen.blockers[0][id], k_no_blocker);
      EXPECT_NEAR(cloud.positions()[seen.blockers[0][id]].x, 10.0, 0.01);
    }
    if (is_free) {
      EXPECT_EQ(seen.counts[id], 1u) << point.x << " " << point.y;
    }
  }
}

TEST(PointVisibility,
     is_the_same_with_and_without_blockers_lists_and_fractions_on_any_threads_and_instructions) {
  const WallCloud cloud = garden();
  const Occluders occluders = cloud.occluders();
  const PointVisibility plain = point_visibility(occluders, k_observers, {});
  EXPECT_TRUE(plain.blockers.empty());
  EXPECT_TRUE(plain.fractions.empty());
  std::optional<PointVisibility> known;
  for (const InstructionSet set : available_instruction_sets()) {
    for (const int threads : {1, 4}) {
      const Occluders others(occluders.octree().with_instruction_set(set), {});
      PointVisibility seen;
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
      tbb::task_arena(threads).execute(
          [&] { seen = point_visibility(others, k_observers, {.sub_rays = 4, .with_blockers = true}); });
      EXPECT_EQ(seen.counts, plain.counts);
      EXPECT_EQ(seen.masks, plain.masks);
      if (known) {
        EXPECT_EQ(seen.fractions, known->fractions);
        EXPECT_EQ(seen.blockers, known->blockers);
      }
      known = std::move(seen);
    }
  }
}

TEST(PointVisibility, leaves_out_what_is_out_of_view_or_too_far) {
  const WallCloud cloud = garden();
  const Occluders occluders = cloud.occluders();
  const PointVisibility all = point_visibility(occluders, std::span(k_observers).first(1), {});
  Observer observer = k_observers[0];
  observer.azimuth_min = 30.0;
  observer.azimuth_max = 200.0;
  observer.elevation_min = -60.0;
  observer.max_distance = 7.0;
  const PointVisibility some = point_visibility(occluders, std::span(&observer, 1), {.with_blockers = true});
  const FieldOfView field(observer);
  for (std::size_t id = 0; id < cloud.positions().size(); ++id) {
    const glm::dvec3 offset = cloud.positions()[id] - observer.position;
    const double distance = std::sqrt(offset.x * offset.x + offset.y * offset.y + offset.z * offset.z);
    // Points are on a lattice finer than this.
    if (std::fabs(distance - 7.0) < 1e-3) continue;
    const bool is_in_view = field.contains(offset) && distance < 7.0;
    ASSERT_EQ(some.counts[id], is_in_view ? all.counts[id] : 0u) << id;
    if (!is_in_view) {
      ASSERT_EQ(some.blockers[0][id], k_no_blocker);
    }
  }
  EXPECT_GT(sum(some.counts), 100u);
  EXPECT_LT(sum(some.counts), sum(all.counts) / 2);
}

TEST(PointVisibility, fraction_is_the_share_of_the_disc_that_is_seen) {
  const WallCloud cloud = garden();
  const Occluders occluders = cloud.occluders();
  const PointVisibility seen = point_visibility(occluders, std::span(k_observers).first(1), {.sub_rays = 16});
  std::size_t partly = 0;
  for (std::size_t id = 0; id < cloud.positions().size(); ++id) {
    const glm::dvec3& point = cloud.positions()[id];
    const float fraction = seen.fractions[id];
    ASSERT_EQ(fraction * 16.0f, std::round(fraction * 16.0f));
    // The first of the lines goes to the point itself.
    if (seen.counts[id] > 0) {
      ASSERT_GE(fraction, 1.0f / 16.0f);
    }
    partly += fraction > 0.0f && fraction < 1.0f;
    if (point.z == 0.0 && point.x < 9.0) {
      ASSERT_EQ(fraction, 1.0f) << point.x << " " << point.y;
    }
    if (point.z == 0.0 && point.x > 12.0 && point.y > 8.0 && point.y < 12.0) {
      ASSERT_EQ(fraction, 0.0f) << id;
    }
  }
  EXPECT_GT(partly, 5u) << "at the edge of the shadow";
}

TEST(PointVisibility, fraction_of_several_observers_is_the_greatest) {
  const WallCloud cloud = garden();
  const Occluders occluders = cloud.occluders();
  const PointVisibilityOptions options{.sub_rays = 4};
  const PointVisibility both = point_visibility(occluders, std::span(k_observers).first(2), options);
  const PointVisibility first = point_visibility(occluders, std::span(k_observers).subspan(0, 1), options);
  const PointVisibility second = point_visibility(occluders, std::span(k_observers).subspan(1, 1), options);
  for (std::size_t id = 0; id < both.fractions.size(); ++id)
    ASSERT_EQ(both.fractions[id], std::max(first.fractions[id], second.fractions[id]));
}

TEST(PointVisibility, tells_what_each_observer_sees_one_after_the_other) {
  const Occluders occluders = garden().occluders();
  std::vector<std::size_t> numbers;
  std::vector<std::vector<std::uint8_t>> columns;
  PointVisibilityOptions options;
  options.each_observer = [&](std::size_t number, std::span<const std::uint8_t> seen) {
    numbers.push_back(number);
    columns.emplace_back(seen.begin(), seen.end());
  };
  const PointVisibility seen = point_visibility(occluders, k_observers, options);
  EXPECT_EQ(numbers, (std::vector<std::size_t>{0, 1, 2}));
  for (std::size_t id = 0; id < seen.counts.size(); ++id) {
    for (std::size_t i = 0; i < 3; ++i) ASSERT_EQ(columns[i][id], seen.masks[id] >> i & 1);
  }
}

TEST(PointVisibility, has_masks_for_up_to_64_observers) {
  const Occluders occluders = WallCloud().add({0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 0.5).occluders();
  const std::vector<Observer> many(65, observer_at({1, 1, 5}));
  const PointVisibility with = point_visibility(occluders, std::span(many).first(64), {});
  const PointVisibility without = point_visibility(occluders, many, {});
  ASSERT_EQ(with.masks.size(), 25u);
  EXPECT_EQ(with.masks[12], ~std::uint64_t{0});
  EXPECT_TRUE(without.masks.empty());
  EXPECT_EQ(without.counts[12], 65u);
}

TEST(PointVisibility, of_no_points_or_no_observers_is_empty) {
  const PointVisibility none = point_visibility(WallCloud().occluders(), k_observers, {});
  EXPECT_TRUE(none.counts.empty());
  const PointVisibility unseen = point_visibility(garden().occluders(), {}, {});
  EXPECT_EQ(sum(unseen.counts), 0u);
}

TEST(PointVisibility, rejects_a_number_of_lines_out_of_range) {
  const Occluders occluders = garden().occluders();
  for (const int sub_rays : {0, -1, 256})
    EXPECT_THROW(point_visibility(occluders, k_observers, {.sub_rays = sub_rays}), Error) << sub_rays;
}

TEST(PointVisibility, progress_counts_all_lines_and_can_stop_them) {
  const Occluders occluders = garden().occluders();
  std::uint64_t last = 0, of = 0;
  PointVisibilityOptions options{.sub_rays = 2};
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last);
    last = done;
    of = total;
    return true;
  };
  const PointVisibility seen = point_visibility(occluders, k_observers, options);
  EXPECT_EQ(last, 2 * 3 * seen.counts.size());
  EXPECT_EQ(of, last);
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(point_visibility(occluders, k_observers, options), Cancelled);
}

TEST(PointVisibility, what_does_not_fit_into_memory_is_rejected_beforehand_with_its_size) {
  constexpr std::uint64_t k_points = std::uint64_t{1} << 40;
  try {
    check_point_visibility(k_points, 64, {.with_blockers = true});
    FAIL() << "takes 300 terabytes";
  } catch (const Error& error) {
    // 5 + 12 + 8 + 4 * 64 bytes per point.
    EXPECT_NE(std::string(error.what()).find("column of blockers for each observer; expected 308962.8 GB"),
              std::string::npos)
        << error.what();
  }
  EXPECT_NO_THROW(check_point_visibility(1000, 64, {.with_blockers = true}));
}

}  // namespace
}  // namespace alidade::test
