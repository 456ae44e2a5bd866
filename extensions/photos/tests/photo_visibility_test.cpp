// SPDX-License-Identifier: MIT
#include "extensions/photos/photo_visibility.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <memory>

#include "base/error.h"
#include "octree/tree_walk.h"
#include "tests/visibility/wall_cloud.h"
#include "visibility/photo_frame.h"

namespace alidade::test {
namespace {

using camera::NamedCamera;

/// Ground of 20 by 20 with a wall right across it at x = 10, 3 high.
const Occluders& yard() {
  static const Occluders occluders = WallCloud()
                                         .add({0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.25)
                                         .add({10, 0, 0.25}, {0, 20, 0}, {0, 0, 2.75}, 0.25)
                                         .occluders();
  return occluders;
}

std::vector<glm::dvec3> positions_of(const Occluders& occluders) {
  const TreeView& tree = occluders.octree().view();
  std::vector<glm::dvec3> positions;
  for (const LatticePosition& position : positions_in_order(tree))
    positions.push_back(to_world(tree.lattice, position));
  return positions;
}

NamedCamera photo_at(const std::string& name, const glm::dvec3& eye, const glm::dvec3& target,
                     double fov = 70.0) {
  return {name, camera::pinhole_from_fov(120, 90, fov, camera::look_at(eye, target))};
}

/// On either side of the wall, towards it, and one above that sees both sides.
const std::vector<NamedCamera> k_photos = {photo_at("west", {2, 10, 1.5}, {10, 10, 1}),
                                           photo_at("east", {18, 10, 1.5}, {10, 10, 1}),
                                           photo_at("above", {10.1, 10, 15}, {10, 10, 0}, 50.0)};

image::PhotoPixels plain_photo(const std::array<std::uint8_t, 3>& color) {
  return {.size = {120, 90}, .values = std::vector(120 * 90, color)};
}

std::string problem_in(const std::function<void()>& task) {
  try {
    task();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(PhotoVisibility, photos_see_what_is_in_their_frame_on_their_side_of_a_wall) {
  const std::vector<NamedCamera> photos = {k_photos[0], k_photos[1]};
  const PhotoVisibility seen = photo_visibility(yard(), photos, {});
  const std::vector<glm::dvec3> positions = positions_of(yard());
  const PhotoFrame west(photos[0].camera), east(photos[1].camera);
  std::uint64_t both = 0, western = 0, foot = 0;
  for (std::size_t id = 0; id < positions.size(); ++id) {
    const glm::dvec3& at = positions[id];
    const bool in_west = west.film_position(at).has_value(), in_east = east.film_position(at).has_value();
    const bool is_wall = at.z > 0.3;
    if (!is_wall && std::fabs(at.x - 10) < 0.6) {  // the foot of the wall
      foot += in_west || in_east;
      continue;
    }
    const bool by_west = in_west && (is_wall || at.x < 10), by_east = in_east && (is_wall || at.x > 10);
    ASSERT_EQ(seen.counts[id], static_cast<std::uint32_t>(by_west) + by_east)
        << at.x << " " << at.y << " " << at.z;
    ASSERT_EQ(seen.best[id] == 0, seen.counts[id] == 0);
    ASSERT_EQ(std::isnan(seen.sampling[id]), seen.counts[id] == 0);
    if (by_west != by_east) {
      ASSERT_EQ(seen.best[id], by_west ? 1u : 2u);
    }
    both += by_west && by_east;
    western += by_west;
  }
  EXPECT_GT(both, 300u);
  ASSERT_EQ(seen.overlaps.size(), 1u);
  EXPECT_GE(seen.overlaps[0].points, both);
  EXPECT_LE(seen.overlaps[0].points, both + foot);
  EXPECT_GE(seen.photos[0].points, western);
  EXPECT_LE(seen.photos[0].points, western + foot);
  EXPECT_EQ(seen.photos[0].points, seen.photos[1].points) << "mirrored";
}

TEST(PhotoVisibility, is_that_of_the_lines_of_sight_from_the_cameras) {
  const PhotoVisibility seen = photo_visibility(yard(), k_photos, {.with_footprints = true});
  const std::vector<glm::dvec3> positions = positions_of(yard());
  std::vector<std::vector<bool>> by(k_photos.size(), std::vector<bool>(positions.size()));
  for (std::size_t photo = 0; photo < k_photos.size(); ++photo) {
    const glm::dvec3 eye = k_photos[photo].camera.pose.position;
    const PhotoFrame frame(k_photos[photo].camera);
    for (std::size_t id = 0; id < positions.size(); ++id) {
      if (!frame.film_position(positions[id])) continue;
      by[photo][id] = !first_blocker(
          yard(), sight_line(end_near_surface(yard(), eye), end_on_point(yard(), id, positions[id], eye)));
    }
    EXPECT_EQ(seen.photos[photo].points,
              static_cast<std::uint64_t>(std::count(by[photo].begin(), by[photo].end(), true)));
  }
  ASSERT_EQ(seen.overlaps.size(), 3u);
  for (const PhotoOverlap& pair : seen.overlaps) {
    std::uint64_t common = 0;
    for (std::size_t id = 0; id < positions.size(); ++id) common += by[pair.first][id] && by[pair.second][id];
    EXPECT_EQ(pair.points, common) << pair.first << " " << pair.second;
  }
  const auto share = [&](std::size_t pair, std::size_t photo) {
    return static_cast<double>(seen.overlaps[pair].points) / static_cast<double>(seen.photos[photo].points);
  };
  EXPECT_DOUBLE_EQ(seen.photos[0].largest_overlap, std::max(share(0, 0), share(1, 0)));
  std::array<std::uint64_t, 4> expected{};
  for (std::size_t id = 0; id < positions.size(); ++id) {
    const std::size_t count = by[0][id] + by[1][id] + by[2][id];
    ASSERT_EQ(seen.counts[id], count);
    ++expected[count];
  }
  EXPECT_EQ(totals(seen).points_by_count, expected);
  EXPECT_EQ(totals(seen).photos_without_points, 0u);
}

TEST(PhotoVisibility, the_footprint_covers_the_cells_of_the_points_that_are_seen) {
  const std::vector<NamedCamera> photos = {k_photos[0]};
  const PhotoVisibility seen =
      photo_visibility(yard(), photos, {.footprint_cell = 0.5, .with_footprints = true});
  EXPECT_EQ(seen.footprint_cell, 0.5);
  double west = 1e9, east = -1e9;
  ASSERT_FALSE(seen.photos[0].footprint.empty());
  for (const PlanePolygon& polygon : seen.photos[0].footprint) {
    for (const glm::dvec2& corner : polygon.rings[0]) {
      west = std::min(west, corner.x);
      east = std::max(east, corner.x);
    }
  }
  EXPECT_GT(west, 2.0);
  EXPECT_EQ(east, 10.5) << "the wall hides what is behind it";
}

TEST(PhotoVisibility, no_photo_colours_through_a_wall) {
  const std::vector<std::array<std::uint8_t, 3>> colors = {{200, 0, 0}, {0, 100, 0}};
  const std::vector<NamedCamera> photos = {k_photos[0], k_photos[1]};
  const PhotoVisibility seen = photo_visibility(
      yard(), photos, {.read_photo = [&](std::size_t photo) { return plain_photo(colors[photo]); }});
  const std::vector<glm::dvec3> positions = positions_of(yard());
  for (std::size_t id = 0; id < positions.size(); ++id) {
    const glm::dvec3& at = positions[id];
    if (seen.counts[id] == 0) {
      ASSERT_EQ(seen.colors[id], Color16(0, 0, 0));
    }
    if (seen.counts[id] == 2 && std::fabs(at.y - 10) < 1e-9) {
      ASSERT_NEAR(seen.colors[id].r, 100 * 257, 257) << "as far from both";
      ASSERT_NEAR(seen.colors[id].g, 50 * 257, 257);
    }
    if (seen.counts[id] != 1 || std::fabs(at.x - 10) < 0.6) continue;
    ASSERT_EQ(seen.colors[id], at.x < 10 ? Color16(200 * 257, 0, 0) : Color16(0, 100 * 257, 0)) << at.x;
  }
}

TEST(PhotoVisibility, a_point_has_the_colour_of_its_position_in_the_photo) {
  image::PhotoPixels gradient = plain_photo({});
  for (int row = 0; row < 90; ++row)
    for (int column = 0; column < 120; ++column)
      gradient.values[static_cast<std::size_t>(row * 120 + column)] = {static_cast<std::uint8_t>(2 * column),
                                                                       static_cast<std::uint8_t>(2 * row), 7};
  const std::vector<NamedCamera> photos = {k_photos[2]};
  const PhotoVisibility seen =
      photo_visibility(yard(), photos, {.read_photo = [&](std::size_t) { return gradient; }});
  const std::vector<glm::dvec3> positions = positions_of(yard());
  const PhotoFrame frame(photos[0].camera);
  for (std::size_t id = 0; id < positions.size(); ++id) {
    if (seen.counts[id] == 0) continue;
    const glm::dvec2 film = *frame.film_position(positions[id]);
    ASSERT_NEAR(seen.colors[id].r / 257.0, std::clamp(2.0 * film.x - 1.0, 0.0, 238.0), 0.51);
    ASSERT_NEAR(seen.colors[id].g / 257.0, std::clamp(2.0 * film.y - 1.0, 0.0, 178.0), 0.51);
    ASSERT_EQ(seen.colors[id].b, 7 * 257);
  }
}

TEST(PhotoVisibility, of_two_photos_that_from_half_as_far_counts_four_times) {
  // One pixel of it is half as wide on the ground, and so has a quarter of the area.
  const std::vector<NamedCamera> photos = {photo_at("low", {5.01, 10, 6}, {5, 10, 0}),
                                           photo_at("high", {5.01, 10, 12}, {5, 10, 0})};
  const std::vector<std::array<std::uint8_t, 3>> colors = {{200, 0, 0}, {0, 100, 0}};
  const PhotoVisibility seen = photo_visibility(
      yard(), photos, {.read_photo = [&](std::size_t photo) { return plain_photo(colors[photo]); }});
  const std::vector<glm::dvec3> positions = positions_of(yard());
  int found = 0;
  for (std::size_t id = 0; id < positions.size(); ++id) {
    if (glm::length(positions[id] - glm::dvec3(5, 10, 0)) > 0.3) continue;
    ++found;
    ASSERT_NEAR(seen.colors[id].r, 160 * 257, 257);
    ASSERT_NEAR(seen.colors[id].g, 20 * 257, 257);
  }
  EXPECT_GT(found, 3);
}

TEST(PhotoVisibility, one_wrong_photo_of_three_does_not_show) {
  // The wrong one is by far the nearest.
  const std::vector<NamedCamera> photos = {photo_at("a", {2, 10, 2}, {10, 10, 1}),
                                           photo_at("b", {3, 9, 2}, {10, 10, 1}),
                                           photo_at("wrong", {8, 10, 2}, {10, 10, 1})};
  const PhotoVisibility seen =
      photo_visibility(yard(), photos, {.read_photo = [](std::size_t photo) {
                         return photo == 2 ? plain_photo({255, 0, 255}) : plain_photo({90, 91, 92});
                       }});
  std::size_t common = 0;
  for (std::size_t id = 0; id < seen.counts.size(); ++id) {
    if (seen.counts[id] != 3) continue;
    ++common;
    ASSERT_EQ(seen.best[id], 3u);
    ASSERT_EQ(seen.colors[id], Color16(90 * 257, 91 * 257, 92 * 257));
  }
  EXPECT_GT(common, 50u);
}

TEST(PhotoVisibility, a_limit_of_distance_holds_for_all_photos) {
  const PhotoVisibility seen = photo_visibility(yard(), k_photos, {.max_distance = 6.0});
  const std::vector<glm::dvec3> positions = positions_of(yard());
  for (std::size_t id = 0; id < positions.size(); ++id) {
    if (seen.counts[id] == 0) continue;
    ASSERT_LE(std::min(glm::length(positions[id] - k_photos[0].camera.pose.position),
                       glm::length(positions[id] - k_photos[1].camera.pose.position)),
              6.0);
  }
  EXPECT_EQ(seen.photos[2].points, 0u) << "15 above the ground";
  EXPECT_EQ(seen.photos[2].median_distance, 0.0);
  EXPECT_EQ(totals(seen).photos_without_points, 1u);
}

TEST(PhotoVisibility, is_the_same_on_any_number_of_threads) {
  const auto look = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return photo_visibility(yard(), k_photos,
                            {.read_photo =
                                 [](std::size_t photo) {
                                   return plain_photo({static_cast<std::uint8_t>(photo * 40), 5, 9});
                                 },
                             .with_footprints = true});
  };
  const PhotoVisibility one = look(1), several = look(4);
  EXPECT_EQ(one.counts, several.counts);
  EXPECT_EQ(one.best, several.best);
  EXPECT_EQ(one.colors, several.colors);
  for (std::size_t photo = 0; photo < k_photos.size(); ++photo) {
    EXPECT_EQ(one.photos[photo].median_sampling, several.photos[photo].median_sampling);
    EXPECT_EQ(one.photos[photo].footprint.size(), several.photos[photo].footprint.size());
  }
}

TEST(PhotoVisibility, goes_on_from_finished_parts) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "alidade_photo_parts";
  std::filesystem::remove(file);
  const auto look = [&](const Progress& progress) {
    PartCheckpoint parts({.file = file, .resume = true}, {{"command", "photos"}});
    return photo_visibility(yard(), k_photos,
                            {.read_photo =
                                 [](std::size_t photo) {
                                   return plain_photo({static_cast<std::uint8_t>(photo * 40), 5, 9});
                                 },
                             .parts = &parts,
                             .progress = progress});
  };
  EXPECT_THROW(look([](std::uint64_t done, std::uint64_t total) { return 3 * done < 2 * total; }), Cancelled);
  const PhotoVisibility resumed = look({});
  const PhotoVisibility again = look({});
  EXPECT_EQ(resumed.colors, again.colors);
  EXPECT_EQ(resumed.best, again.best);
  EXPECT_EQ(resumed.counts, photo_visibility(yard(), k_photos, {}).counts);
  std::filesystem::remove(file);
}

TEST(PhotoVisibility, photos_that_cannot_be_are_errors) {
  EXPECT_NE(problem_in([] { photo_visibility(yard(), {}, {}); }).find("there is no photo"),
            std::string::npos);
  std::vector<NamedCamera> photos = {k_photos[0]};
  photos[0].camera.lens = camera::OrthographicLens{};
  EXPECT_NE(problem_in([&] { photo_visibility(yard(), photos, {}); }).find("camera 'west' is orthographic"),
            std::string::npos);
}

TEST(PhotoVisibility, a_camera_inside_a_point_sees_the_others) {
  const std::vector<NamedCamera> photos = {photo_at("a", {5, 5, 0}, {10, 10, 1})};
  const PhotoVisibility seen = photo_visibility(yard(), photos, {});
  EXPECT_GT(seen.photos[0].points, 300u) << "the wall at least";
}

}  // namespace
}  // namespace alidade::test
