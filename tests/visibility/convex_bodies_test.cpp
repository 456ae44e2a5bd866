// SPDX-License-Identifier: MIT
// Nothing on a convex body hides its own visible side, however exactly or roughly its points lie on it: as sampled from
// meshes, plans and elevation models, or scanned.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "cloud/lattice.h"
#include "octree/build.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "visibility/lines/line_report.h"
#include "visibility/photos/photo_visibility.h"
#include "visibility/points/point_visibility.h"
#include "visibility/raster/viewshed.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade::test {

using namespace visibility;

namespace {

/// How the points of a body are written down.
struct Writing {
  int decimals = 17;     ///< of coordinates; 17: as doubles
  double noise = 0.0;    ///< metres from the surface, evenly up to this
  bool is_far = false;   ///< coordinates as of UTM

  double step() const { return decimals >= 17 ? 0.0 : std::pow(10.0, -decimals); }
  /// Between neighbours: far above what positions are rounded to.
  double spacing() const { return std::max(0.1, 20.0 * step()); }
  std::string text() const {
    return std::to_string(decimals) + " decimals, noise " + std::to_string(noise) + (is_far ? ", far" : "");
  }
};

/// Points of a convex body around the origin, in spacings, and the directions out of it.
struct Body {
  std::string name;
  std::vector<glm::dvec3> positions, normals;
  bool has_inside = true;  ///< otherwise it is seen from both sides
  double size = 0.0;       ///< no point is farther from the origin
};

void add(Body& body, const glm::dvec3& position, const glm::dvec3& normal) {
  body.positions.push_back(position);
  body.normals.push_back(normal);
  body.size = std::max(body.size, glm::length(position));
}

/// Two directions at right angles to a normal and to each other.
std::pair<glm::dvec3, glm::dvec3> across(const glm::dvec3& normal) {
  const glm::dvec3 first = glm::normalize(
      glm::cross(normal, std::fabs(normal.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
  return {first, glm::cross(normal, first)};
}

/// count x count points of a plane, on a grid or anywhere.
Body plane(const std::string& name, const glm::dvec3& direction, int count, Random* random) {
  Body body{.name = name, .positions = {}, .normals = {}, .has_inside = false};
  const glm::dvec3 normal = glm::normalize(direction);
  const auto [u, v] = across(normal);
  for (int i = 0; i < count * count; ++i) {
    const double a = random ? random->between(0, count) : i % count, b = random ? random->between(0, count) : i / count;
    add(body, (a - 0.5 * count) * u + (b - 0.5 * count) * v, normal);
  }
  return body;
}

/// A cube turned so that one axis has this direction; count x count points on each side, by chance.
Body cube(const std::string& name, const glm::dvec3& direction, int count, Random& random) {
  Body body{.name = name, .positions = {}, .normals = {}};
  const glm::dvec3 up = glm::normalize(direction);
  const auto [u, v] = across(up);
  for (const auto& axes : {std::array{u, v, up}, std::array{v, up, u}, std::array{up, u, v}}) {
    for (const double side : {-0.5, 0.5}) {
      for (int i = 0; i < count * count; ++i)
        add(body, static_cast<double>(count) * (side * axes[2] + random.between(-0.5, 0.5) * axes[0] + random.between(-0.5, 0.5) * axes[1]),
            2.0 * side * axes[2]);
    }
  }
  return body;
}

Body sphere(int count) {
  Body body{.name = "sphere", .positions = {}, .normals = {}};
  const double radius = std::sqrt(count / (4.0 * std::numbers::pi));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count, run = std::sqrt(1.0 - z * z), angle = 2.399963229728653 * i;
    const glm::dvec3 normal(run * std::cos(angle), run * std::sin(angle), z);
    add(body, radius * normal, normal);
  }
  return body;
}

std::vector<Body> bodies() {
  Random random("bodies");
  std::vector<Body> all;
  const std::pair<const char*, glm::dvec3> directions[] = {
      {"level", {0, 0, 1}},  {"upright", {1, 0, 0}},       {"upright, turned", {0.6, 0.8, 0}}, {"one in two", {-2, 0, 1}},
      {"nearly level", {0.003, -0.002, 1}}, {"steep", {0.3, 1, 0.02}}, {"tilted", {0.47, -0.31, 0.77}}};
  for (const auto& [name, direction] : directions) {
    all.push_back(plane(std::string("25 points of a plane, ") + name, direction, 5, nullptr));
    all.push_back(plane(std::string("grid, ") + name, direction, 30, nullptr));
    all.push_back(plane(std::string("plane, ") + name, direction, 30, &random));
  }
  all.push_back(cube("cube", {0, 0, 1}, 20, random));
  all.push_back(cube("turned cube", {0.47, -0.31, 0.77}, 20, random));
  all.push_back(sphere(2000));
  return all;
}

/// A body as a cloud.
struct BodyCloud {
  std::vector<glm::dvec3> positions;  ///< as they were written
  glm::dvec3 middle{0.0};
  PointCloud cloud;
};

BodyCloud write(const Body& body, const Writing& writing) {
  Random random("write");
  BodyCloud written;
  if (writing.is_far) written.middle = {690000.0, 5325000.0, 600.0};
  CoordinateSurvey survey;
  survey.resolution = glm::dvec3(0.5 * writing.step());
  for (std::size_t i = 0; i < body.positions.size(); ++i) {
    glm::dvec3 position = written.middle + writing.spacing() * body.positions[i] +
                          random.between(-writing.noise, writing.noise) * body.normals[i];
    if (writing.step() > 0.0) position = glm::round(position / writing.step()) * writing.step();
    written.positions.push_back(position);
    survey.bounds.grow(position);
    ++survey.finite_count;
  }
  written.cloud = make_cloud(written.positions, fit_lattice({&survey, 1}));
  return written;
}

/// Around a body, far and near, also where sight grazes sides.
std::vector<glm::dvec3> eyes_around(const Body& body) {
  std::vector<glm::dvec3> eyes;
  Random random("eyes");
  for (const double distance : {1.3, 3.0, 30.0})
    for (int i = 0; i < 3; ++i) eyes.push_back(body.size * distance * glm::normalize(random.direction()));
  const glm::dvec3 normal = body.normals.front();
  const auto [u, v] = across(normal);
  const double side = body.has_inside ? glm::dot(body.positions.front(), normal) : 0.0;
  for (const double rise : {0.03, 0.1})
    eyes.push_back(normal * (side + rise * body.size) + 1.5 * body.size * glm::normalize(u + 0.7 * v));
  return eyes;
}

/// Points that an eye sees, and those of them that it is said to see.
struct Share {
  std::size_t visible = 0, found = 0;

  double value() const { return visible == 0 ? 1.0 : static_cast<double>(found) / static_cast<double>(visible); }
};

Share found_by(const Body& body, const Writing& writing) {
  const BodyCloud written = write(body, writing);
  const Occluders occluders(build(written.cloud), {});
  Share share;
  for (const glm::dvec3& at : eyes_around(body)) {
    Observer eye;
    eye.position = written.middle + writing.spacing() * at;
    const PointVisibility seen = point_visibility(occluders, {&eye, 1}, {});
    for (std::size_t id = 0; id < written.positions.size(); ++id) {
      // Behind the horizon of the body within what positions are rounded to.
      const glm::dvec3 way = eye.position - (written.middle + writing.spacing() * body.positions[id]);
      if (body.has_inside && glm::dot(way, body.normals[id]) < writing.noise + 2.0 * writing.step()) continue;
      ++share.visible;
      share.found += seen.counts[id];
    }
  }
  return share;
}

TEST(ConvexBodies, see) {
  for (const bool is_far : {false, true}) {
    for (const double noise : {0.0, 1e-4, 1e-3, 1e-2}) {
      for (const int decimals : {0, 1, 2, 3, 4, 6, 9, 17}) {
        const Writing writing{decimals, noise, is_far};
        for (const Body& body : bodies()) {
          const Share share = found_by(body, writing);
          if (share.value() < 0.998)
            printf("%s, %s: %.4f of %zu\n", body.name.c_str(), writing.text().c_str(), share.value(), share.visible);
        }
      }
    }
  }
}

}  // namespace
}  // namespace alidade::test
