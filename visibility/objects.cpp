// SPDX-License-Identifier: MIT
#include "visibility/objects.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <string_view>

#include "base/error.h"
#include "base/exact_math.h"
#include "base/words.h"

namespace alidade::visibility {
namespace {

/// Half of the solid angle of a triangle, by its corners as seen from the eye.
double half_solid_angle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
  return angle_of(std::fabs(glm::dot(a, glm::cross(b, c))),
                  la * lb * lc + glm::dot(a, b) * lc + glm::dot(a, c) * lb + glm::dot(b, c) * la);
}

/// A stretch of an object in plan.
struct Column {
  GivenObserver foot;  ///< with z and height
  ObjectPiece piece;   ///< without its height
};

/// Twice the area within corners, positive if they go counterclockwise.
double doubled_area(std::span<const GivenObserver> corners) {
  double sum = 0.0;
  // From the first corner, so that large coordinates lose no digits.
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const glm::dvec2 a = corners[i].position - corners[0].position,
                     b = corners[i + 1].position - corners[0].position;
    sum += a.x * b.y - a.y * b.x;
  }
  return sum;
}

class Sampler {
 public:
  Sampler(const SampleOptions& options, const GroundHeight& ground) : options_(options), ground_(ground) {
    check_that(options.spacing > 0.0 && std::isfinite(options.spacing), "invalid spacing of an object",
               "a positive length");
    check_that(options.width >= 0.0 && std::isfinite(options.width), "invalid width of an object",
               "at least 0");
  }

  void add(const ObjectPart& part, std::span<const GivenObserver> corners) {
    for (const GivenObserver& corner : corners) check_corner(corner);
    if (part.object == sampled_.objects.size()) add_object(corners.front());
    if (part.shape == ObjectShape::segment)
      return add_column({corners.front(), {.object = part.object, .width = options_.width}});
    // Outwards is to the right of an outline that goes counterclockwise.
    const double side = doubled_area(corners) > 0.0 ? 1.0 : -1.0;
    const std::size_t edges = part.shape == ObjectShape::outline ? corners.size() : corners.size() - 1;
    bool has_length = false;
    for (std::size_t i = 0; i < edges; ++i)
      has_length |= add_edge(part, corners[i], corners[(i + 1) % corners.size()], side);
    if (!has_length) throw Error(corners.front().source, {}, "line without length", "two different vertices");
  }

  SampledObjects finished() {
    const auto is_line = [](const ObjectPiece& piece) { return piece.width == 0.0; };
    const bool any = std::ranges::any_of(sampled_.pieces, is_line);
    check_that(!any || std::ranges::all_of(sampled_.pieces, is_line),
               "vertical objects without a width beside walls",
               "a width of the vertical ones, or walls alone");
    return std::move(sampled_);
  }

 private:
  static void check_corner(const GivenObserver& corner) {
    if (!corner.height || !(*corner.height > 0.0) || !std::isfinite(*corner.height)) {
      throw Error(corner.source, {},
                  corner.height ? "invalid height of an object" : "object without a height",
                  "a height above 0", corner.height ? fmt::format("{}", *corner.height) : "");
    }
  }

  double foot_of(const GivenObserver& corner) const {
    if (corner.z) return *corner.z;
    const std::optional<double> height = ground_(corner.position);
    if (!height) {
      throw Error(corner.source, {}, "no ground below the object",
                  "a position inside the cloud or raster, or a z",
                  fmt::format("{}, {}", corner.position.x, corner.position.y));
    }
    return *height;
  }

  /// An observer at the top of a corner, checked as all observers are.
  Observer placed(const GivenObserver& corner) const {
    GivenObserver top{.source = corner.source, .name = corner.name, .position = corner.position};
    top.z = foot_of(corner);
    top.height = corner.height;
    return place_observers({&top, 1}, {.max_distance = options_.max_distance}, {}).front();
  }

  void add_object(const GivenObserver& corner) {
    Observer object = placed(corner);
    object.max_distance = std::numeric_limits<double>::infinity();
    if (corner.name.empty()) object.name = fmt::format("object {}", sampled_.objects.size() + 1);
    sampled_.objects.push_back(object);
  }

  std::size_t pieces_of(double length, const std::string& source) const {
    const double pieces = std::ceil(length / options_.spacing);
    if (!(pieces + static_cast<double>(sampled_.samples.size()) <=
          static_cast<double>(k_most_object_samples))) {
      throw Error(source, {}, fmt::format("too many samples of objects at a spacing of {}", options_.spacing),
                  fmt::format("at most {}", k_most_object_samples));
    }
    return static_cast<std::size_t>(std::fmax(1.0, pieces));
  }

  /// Returns false if the corners have no distance in plan.
  bool add_edge(const ObjectPart& part, const GivenObserver& from, const GivenObserver& to, double side) {
    const glm::dvec2 way = to.position - from.position;
    const double length = glm::length(way);
    if (!(length > 0.0)) return false;
    const glm::dvec2 along = way / length;
    const std::size_t columns = pieces_of(length, from.source);
    for (std::size_t i = 0; i < columns; ++i) {
      const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(columns);
      Column column{from, {.object = part.object, .width = length / static_cast<double>(columns)}};
      column.foot.position += share * way;
      column.foot.z.reset();
      if (from.z && to.z) column.foot.z = *from.z + share * (*to.z - *from.z);
      column.piece.normal = side * glm::dvec2(along.y, -along.x);
      column.piece.is_one_sided = part.shape == ObjectShape::outline;
      add_column(column);
    }
    return true;
  }

  void add_column(const Column& column) {
    const Observer top = placed(column.foot);
    const std::size_t count = pieces_of(top.height, column.foot.source);
    const double height = top.height / static_cast<double>(count);
    for (std::size_t i = 0; i < count; ++i) {
      Observer sample = top;
      sample.name = sampled_.objects.back().name;
      sample.position.z += (static_cast<double>(i) + 0.5) * height - top.height;
      sampled_.samples.push_back(sample);
      sampled_.pieces.push_back(column.piece);
      sampled_.pieces.back().height = height;
    }
  }

  const SampleOptions& options_;
  const GroundHeight& ground_;
  SampledObjects sampled_;
};

}  // namespace

void GivenObjects::add_segment(const GivenObserver& corner) {
  parts.push_back({count(), ObjectShape::segment, corners.size(), corners.size() + 1});
  corners.push_back(corner);
}

GivenObserver parse_object(const std::string& text) {
  GivenObserver given{.source = "--object " + text};
  std::vector<std::string_view> cells;
  split_cells(text, ',', cells);
  double numbers[4] = {};
  bool is_right = cells.size() == 4;
  for (std::size_t i = 0; i < 4 && is_right; ++i) {
    const std::optional<double> number = parse_number(cells[i]);
    is_right = number && std::isfinite(*number);
    if (is_right) numbers[i] = *number;
  }
  if (!is_right) throw Error(given.source, {}, "invalid object", "X,Y,Z0,Z1: position, foot and top");
  if (!(numbers[3] > numbers[2])) throw Error(given.source, {}, "object without height", "Z1 above Z0");
  given.position = {numbers[0], numbers[1]};
  given.z = numbers[2];
  given.height = numbers[3] - numbers[2];
  return given;
}

double solid_angle(const ObjectPiece& piece, const glm::dvec3& middle, const glm::dvec3& eye) {
  if (!(piece.width > 0.0)) return 0.0;
  const glm::dvec3 way = middle - eye;
  glm::dvec2 normal = piece.normal;
  if (normal == glm::dvec2(0.0)) {
    const double run = glm::length(glm::dvec2(way));
    // Sides are not visible from straight above or below.
    if (!(run > 0.0)) return 0.0;
    normal = glm::dvec2(way) / run;
  }
  const glm::dvec3 across = 0.5 * piece.width * glm::dvec3(-normal.y, normal.x, 0.0),
                   up(0.0, 0.0, 0.5 * piece.height);
  const glm::dvec3 a = way - across - up, b = way + across - up, c = way + across + up, d = way - across + up;
  return 2.0 * (half_solid_angle(a, b, c) + half_solid_angle(a, c, d));
}

bool faces(const ObjectPiece& piece, const glm::dvec3& middle, const glm::dvec3& eye) {
  return !piece.is_one_sided || glm::dot(piece.normal, glm::dvec2(eye) - glm::dvec2(middle)) > 0.0;
}

SampledObjects sample_objects(const GivenObjects& given, const SampleOptions& options,
                              const GroundHeight& ground) {
  Sampler sampler(options, ground);
  for (const ObjectPart& part : given.parts)
    sampler.add(part, std::span(given.corners).subspan(part.begin, part.end - part.begin));
  return sampler.finished();
}

}  // namespace alidade::visibility
