// SPDX-License-Identifier: MIT
#pragma once

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

#include "cloud/lattice.h"
#include "octree/build.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "visibility/sight_line.h"

// Nothing on a convex body hides its own visible side, however exactly its points lie on it: as sampled from
// meshes, plans and elevation models, or scanned.

namespace alidade::test {

using namespace visibility;

/// How the points of a body are written.
struct Writing {
  int decimals = 17;    ///< of coordinates; 17: as doubles
  double noise = 0.0;   ///< metres from the surface, evenly up to this
  bool is_far = false;  ///< coordinates as of UTM

  double step() const { return decimals >= 17 ? 0.0 : std::pow(10.0, -decimals); }
  /// Metres between neighbours: far above what positions are rounded to.
  double spacing() const { return std::max(0.1, 20.0 * step()); }
  std::string text() const {
    return std::to_string(decimals) + " decimals, noise " + std::to_string(noise) + (is_far ? ", far" : "");
  }
};

inline std::vector<Writing> writings() {
  std::vector<Writing> all;
  for (const int decimals : {0, 1, 2, 3, 4, 6, 9, 17}) all.push_back({.decimals = decimals});
  for (const double noise : {1e-4, 1e-3, 1e-2})
    for (const int decimals : {2, 3, 17}) all.push_back({.decimals = decimals, .noise = noise});
  for (const double noise : {0.0, 1e-3})
    for (const int decimals : {3, 17}) all.push_back({.decimals = decimals, .noise = noise, .is_far = true});
  return all;
}

/// Some of them, for questions that take longer.
inline const Writing k_few_writings[] = {
    {}, {.decimals = 3}, {.decimals = 2, .noise = 0.01}, {.noise = 1e-3, .is_far = true}};

/// Points of a convex body around the origin and the directions out of it. Lengths in distances between
/// neighbours.
struct Body {
  std::string name;
  std::vector<glm::dvec3> positions{}, normals{};
  bool has_inside = true;            ///< otherwise it is seen from both sides
  std::array<glm::dvec3, 3> axes{};  ///< of a cube
  double half_side = 0.0;            ///< of a cube
  double size = 0.0;                 ///< no point is farther from the origin
};

inline void add(Body& body, const glm::dvec3& position, const glm::dvec3& normal) {
  body.positions.push_back(position);
  body.normals.push_back(normal);
  body.size = std::max(body.size, glm::length(position));
}

/// Two directions at right angles to a normal and to each other.
inline std::pair<glm::dvec3, glm::dvec3> across(const glm::dvec3& normal) {
  const glm::dvec3 first = glm::normalize(
      glm::cross(normal, std::fabs(normal.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
  return {first, glm::cross(normal, first)};
}

/// count x count points on a grid or, with a random, anywhere.
inline Body plane(const std::string& name, const glm::dvec3& direction, int count, Random* random = nullptr) {
  Body body{.name = name, .has_inside = false};
  const glm::dvec3 normal = glm::normalize(direction);
  const auto [u, v] = across(normal);
  for (int i = 0; i < count * count; ++i) {
    const double a = random ? random->between(0, count) : i % count,
                 b = random ? random->between(0, count) : i / count;
    add(body, (a - 0.5 * count) * u + (b - 0.5 * count) * v, normal);
  }
  return body;
}

/// One of its axes has this direction; count x count points anywhere on each side.
inline Body cube(const std::string& name, const glm::dvec3& direction, int count, Random& random) {
  const glm::dvec3 up = glm::normalize(direction);
  const auto [u, v] = across(up);
  Body body{.name = name, .axes = {u, v, up}, .half_side = 0.5 * count};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      for (int i = 0; i < count * count; ++i) {
        const glm::dvec3 within = random.between(-1, 1) * body.axes[(axis + 1) % 3] +
                                  random.between(-1, 1) * body.axes[(axis + 2) % 3];
        add(body, body.half_side * (side * body.axes[axis] + within), side * body.axes[axis]);
      }
    }
  }
  return body;
}

inline Body sphere(int count) {
  Body body{.name = "sphere"};
  const double radius = std::sqrt(count / (4.0 * std::numbers::pi)),
               golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count, run = std::sqrt(1.0 - z * z);
    const glm::dvec3 normal(run * std::cos(golden * i), run * std::sin(golden * i), z);
    add(body, radius * normal, normal);
  }
  return body;
}

inline const std::pair<const char*, glm::dvec3> k_tilts[] = {{"level", {0, 0, 1}},
                                                             {"nearly level", {0.003, -0.002, 1}},
                                                             {"one in two", {-2, 0, 1}},
                                                             {"tilted", {0.47, -0.31, 0.77}},
                                                             {"steep", {0.3, 1, 0.02}},
                                                             {"upright", {1, 0, 0}},
                                                             {"upright, turned", {0.6, 0.8, 0}}};

inline const std::vector<Body>& bodies() {
  static const std::vector<Body> all = [] {
    Random random("bodies");
    std::vector<Body> made;
    for (const auto& [name, direction] : k_tilts) {
      made.push_back(plane(std::string("25 points, ") + name, direction, 5));
      made.push_back(plane(std::string("grid, ") + name, direction, 20));
      made.push_back(plane(std::string("plane, ") + name, direction, 20, &random));
    }
    made.push_back(cube("cube", {0, 0, 1}, 20, random));
    made.push_back(cube("turned cube", {0.47, -0.31, 0.77}, 20, random));
    made.push_back(sphere(1500));
    return made;
  }();
  return all;
}

/// A body as a cloud.
struct WrittenBody {
  WrittenBody(const Body& body, const Writing& writing) : spacing(writing.spacing()) {
    Random random("written");
    if (writing.is_far) middle = {690000.0, 5325000.0, 600.0};
    CoordinateSurvey survey;
    survey.resolution = glm::dvec3(0.5 * writing.step());
    std::vector<glm::dvec3> positions;
    for (std::size_t i = 0; i < body.positions.size(); ++i) {
      glm::dvec3 position =
          world(body.positions[i]) + random.between(-writing.noise, writing.noise) * body.normals[i];
      if (writing.step() > 0.0) position = glm::round(position / writing.step()) * writing.step();
      positions.push_back(position);
      survey.bounds.grow(position);
      ++survey.finite_count;
    }
    cloud = make_cloud(positions, fit_lattice({&survey, 1}));
  }

  glm::dvec3 world(const glm::dvec3& position) const { return middle + spacing * position; }

  double spacing;
  glm::dvec3 middle{0.0};
  PointCloud cloud;
};

/// Whether a line passes an edge of a cube within two points' distance: points do not locate the edge better.
inline bool passes_edge(const Body& body, const glm::dvec3& from, const glm::dvec3& to) {
  if (body.half_side == 0.0) return false;
  const double length = std::min(glm::length(to - from), 4.0 * body.size);
  const glm::dvec3 direction = glm::normalize(to - from);
  for (double t = 0.0; t <= length; t += 0.5) {
    const glm::dvec3 at = from + t * direction;
    glm::dvec3 beyond;  // the sides
    for (int axis = 0; axis < 3; ++axis)
      beyond[axis] = std::fabs(glm::dot(at, body.axes[static_cast<std::size_t>(axis)])) - body.half_side;
    for (int along = 0; along < 3; ++along) {
      glm::dvec3 off = beyond;
      off[along] = std::max(off[along], 0.0);
      if (glm::dot(off, off) < 4.0) return true;
    }
  }
  return false;
}

/// Sine of the angle at which an eye looks at a point. 0 if it does not look from outside, or if the points
/// do not show whether it does.
inline double clear_slope(const Body& body, std::size_t id, const glm::dvec3& eye) {
  const double slope = glm::dot(glm::normalize(eye - body.positions[id]), body.normals[id]);
  if (!body.has_inside) return std::fabs(slope);
  // From there on a point's normal decides which side is seen.
  constexpr double k_grazing = 0.02;
  return slope < k_grazing || passes_edge(body, body.positions[id], eye) ? 0.0 : slope;
}

/// Whether a line is above the noise and the rounding three points on.
inline bool is_above_noise(double slope, const Writing& writing) {
  return slope > 0.0 && 3.0 * slope * writing.spacing() >= writing.noise + writing.step();
}

struct View {
  glm::dvec3 eye;
  std::vector<double> slopes;  ///< clear_slope() by point
};

/// From around a body, far and near, and along a side.
inline std::vector<View> views_of(const Body& body) {
  std::vector<glm::dvec3> eyes;
  Random random("eyes");
  for (const double distance : {1.3, 3.0, 30.0})
    for (int i = 0; i < 3; ++i) eyes.push_back(body.size * distance * glm::normalize(random.direction()));
  const glm::dvec3& normal = body.normals.front();
  const auto [u, v] = across(normal);
  for (const double rise : {0.03, 0.1})
    eyes.push_back((body.half_side + rise * body.size) * normal +
                   1.5 * body.size * glm::normalize(u + 0.7 * v));
  std::vector<View> views;
  for (const glm::dvec3& eye : eyes) {
    views.push_back({.eye = eye, .slopes = {}});
    for (std::size_t id = 0; id < body.positions.size(); ++id)
      views.back().slopes.push_back(clear_slope(body, id, eye));
  }
  return views;
}

/// How many of so many are right.
struct Share {
  std::size_t all = 0, right = 0;

  void add(bool is_right) {
    ++all;
    right += is_right ? 1 : 0;
  }
};

inline void expect_nearly_all(const Share& share, const Body& body, const Writing& writing) {
  constexpr double k_least = 0.998;
  ASSERT_GT(share.all, 0u);
  EXPECT_GE(static_cast<double>(share.right), k_least * static_cast<double>(share.all))
      << body.name << ", " << writing.text() << ": " << share.right << " of " << share.all;
}

/// Expects that nearly all is right that look(body, writing, written, occluders, share) finds, for a few
/// writings.
template <class Look>
void expect_in_few_writings(const Look& look) {
  for (const Body& body : bodies()) {
    for (const Writing& writing : k_few_writings) {
      const WrittenBody written(body, writing);
      const Occluders occluders(build(written.cloud), {});
      Share share;
      look(body, writing, written, occluders, share);
      expect_nearly_all(share, body, writing);
    }
  }
}

}  // namespace alidade::test
