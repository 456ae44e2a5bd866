// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/visibility/convex_bodies.h"
#include "visibility/lines/line_report.h"
#include "visibility/points/point_visibility.h"
#include "visibility/raster/viewshed.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade::test {

using namespace visibility;

namespace {

TEST(ConvexBodies, show_their_points_to_every_observer_outside) {
  for (const Body& body : bodies()) {
    const std::vector<View> views = views_of(body);
    for (const Writing& writing : writings()) {
      // Few points do not show how thick their sheet is.
      if (body.positions.size() < 100 && writing.noise > 0.01 * writing.spacing()) continue;
      const WrittenBody written(body, writing);
      const Occluders occluders(build(written.cloud), {});
      Share share;
      for (const View& view : views) {
        Observer observer;
        observer.position = written.world(view.eye);
        const PointVisibility seen = point_visibility(occluders, {&observer, 1}, {});
        for (std::size_t id = 0; id < body.positions.size(); ++id)
          if (is_above_noise(view.slopes[id], writing)) share.add(seen.counts[id] == 1);
      }
      expect_nearly_all(share, body, writing);
    }
  }
}

TEST(ConvexBodies, of_a_plane_with_whole_coordinates_show_all_points) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) positions.emplace_back(i, j, 2 * i);
  Observer observer;
  observer.position = {-24.8328, 2, 17.4164};
  for (const double scale : {4e-9, 1e-6, 1e-3, 1e-1}) {
    const Occluders occluders(build(make_cloud(positions, {glm::dvec3(scale), glm::dvec3(0.0)})), {});
    const PointVisibility seen = point_visibility(occluders, {&observer, 1}, {});
    EXPECT_EQ(std::ranges::count(seen.counts, 1u), 25) << scale;
  }
}

/// Whether a point is away from the edges of a cube.
bool is_amid(const Body& body, std::size_t id) {
  // Low lines to the sky pass far edges, too.
  constexpr double k_beside = 5.0;
  if (body.half_side == 0.0) return true;
  int near = 0;
  for (const glm::dvec3& axis : body.axes)
    near += std::fabs(glm::dot(body.positions[id], axis)) > body.half_side - k_beside ? 1 : 0;
  return near == 1;
}

TEST(ConvexBodies, get_light_from_all_of_the_sky_before_them) {
  constexpr int k_directions = 32;
  const std::vector<glm::dvec3> directions = even_sky_directions(k_directions);
  expect_in_few_writings(
      [&](const Body& body, const Writing&, const WrittenBody&, const Occluders& occluders, Share& share) {
        const std::vector<glm::vec3> normals(body.normals.begin(), body.normals.end());
        const std::vector<float> views = point_sky_views(occluders, normals, {.directions = k_directions});
        for (std::size_t id = 0; id < views.size(); ++id) {
          if (!is_amid(body, id)) continue;
          double expected = 0.0;
          for (const glm::dvec3& direction : directions)
            expected += 2.0 / k_directions * std::max(0.0, glm::dot(direction, body.normals[id]));
          share.add(std::fabs(static_cast<double>(views[id]) - expected) < 0.03);
        }
      });
}

TEST(ConvexBodies, get_all_hours_of_the_sun_before_them) {
  const std::vector<SunStep> steps{{75.0, 20.0, 1.0}, {200.0, 60.0, 2.0}, {240.0, 40.0, 4.0}};
  const LightOf<SunHours> light = sun_light(steps, 1, {});
  const auto direction_of = [](const SunStep& step) {
    const double azimuth = step.azimuth * std::numbers::pi / 180.0,
                 elevation = step.elevation * std::numbers::pi / 180.0;
    return glm::dvec3(std::sin(azimuth) * std::cos(elevation), std::cos(azimuth) * std::cos(elevation),
                      std::sin(elevation));
  };
  expect_in_few_writings(
      [&](const Body& body, const Writing&, const WrittenBody&, const Occluders& occluders, Share& share) {
        const std::vector<glm::vec3> normals(body.normals.begin(), body.normals.end());
        SunHoursMeasure measure(occluders, light, {});
        const HugeVector<float> found = point_sun(occluders, normals, measure);
        for (std::size_t id = 0; id < found.size(); ++id) {
          double hours = 0.0, flattest = 1.0;
          for (const SunStep& step : steps) {
            const double slope = glm::dot(direction_of(step), body.normals[id]);
            flattest = std::min(flattest, std::fabs(slope));
            if (slope > 0.0) hours += step.hours;
          }
          // Where the sun grazes a side it is before it or behind.
          if (is_amid(body, id) && flattest > 0.1) share.add(std::fabs(found[id] - hours) < 1e-3);
        }
      });
}

TEST(ConvexBodies, do_not_block_lines_to_positions_on_them) {
  expect_in_few_writings([](const Body& body, const Writing& writing, const WrittenBody& written,
                            const Occluders& occluders, Share& share) {
    const View view = views_of(body)[4];
    std::vector<LinePair> pairs;
    for (std::size_t id = 0; id < body.positions.size(); id += 3) {
      if (!is_above_noise(view.slopes[id], writing)) continue;
      pairs.push_back({.from = {written.world(view.eye)},
                       .to = end_near_surface(occluders, written.world(body.positions[id]))});
    }
    for (const LineReport& report : report_lines(occluders, pairs, {})) share.add(!report.blocker);
  });
}

TEST(ConvexBodies, that_are_planes_are_seen_in_all_cells_of_a_map) {
  Random random("maps");
  for (const auto& [name, direction] : k_tilts) {
    if (glm::normalize(direction).z < 0.5) continue;  // what is steeper is no ground (end_on_ground())
    for (const Body& body : {plane(std::string("grid, ") + name, direction, 30),
                             plane(std::string("plane, ") + name, direction, 30, &random)}) {
      for (const Writing& writing : k_few_writings) {
        const WrittenBody written(body, writing);
        const Octree octree = build(written.cloud);
        const Occluders occluders(octree, {});
        const Ground ground = make_ground(octree, {}, {.cell_size = 2.0 * writing.spacing()});
        Observer observer;
        observer.position =
            written.world(body.size * (body.normals.front() + 0.5 * across(body.normals.front()).first));
        // The middle half: beyond the edge ground goes on level.
        Bounds area = octree.bounds();
        const glm::dvec3 quarter = 0.25 * area.size();
        area = {area.min + quarter, area.max - quarter};
        const Viewshed seen =
            viewshed(occluders, ground, {&observer, 1}, geo::grid_over(area, writing.spacing()), {});
        Share share;
        for (const float value : seen.values.values) share.add(value == 1.0f);
        expect_nearly_all(share, body, writing);
      }
    }
  }
}

}  // namespace
}  // namespace alidade::test
