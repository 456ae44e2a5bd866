// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <string>
#include <vector>

#include "visibility/observers.h"

// Objects to be seen from many positions: masts, wind turbines, walls, buildings. An object consists
// of upright pieces, each with a sample in its middle; the piece is visible if its sample is. Samples
// are observers, since a line of sight is the same from either end: a viewshed of them shows from
// where the object is visible.
//
//   const SampledObjects mast = sample_objects(given, {.spacing = 5.0}, ground);
//   const ViewshedOptions options{.mode = ViewshedMode::size, .target_height = 2.0, .pieces = mast.pieces};
//   const Viewshed seen = viewshed(occluders, ground, mast.samples, grid, options);

namespace alidade::visibility {

enum class ObjectShape {
  segment,  ///< straight up from its only corner
  wall,     ///< above a line, visible from both sides
  outline,  ///< walls around an area, visible from outside
};

/// The footprint of an object, or of a part of it.
struct ObjectPart {
  std::size_t object = 0;  ///< number of the object, from 0, in order
  ObjectShape shape = ObjectShape::segment;
  std::size_t begin = 0, end = 0;  ///< corners of GivenObjects
};

/// Objects as given by the user or a file.
struct GivenObjects {
  /// `z` is of the foot, `height` of the object above it; views and distances do not apply.
  std::vector<GivenObserver> corners;
  std::vector<ObjectPart> parts;

  std::size_t count() const { return parts.empty() ? 0 : parts.back().object + 1; }
  /// Adds a vertical segment as an object of its own.
  void add_segment(const GivenObserver& corner);
};

/// Reads "X,Y,Z0,Z1": a vertical segment from Z0 up to Z1. Errors: anything else, numbers that are not
/// finite, a top that is not above the foot.
GivenObserver parse_object(const std::string& text);

/// What a sample represents.
struct ObjectPiece {
  std::size_t object = 0;
  double width = 0.0, height = 0.0;  ///< in the unit of the cloud; width 0: a line
  glm::dvec2 normal{0.0};            ///< horizontal, of length 1; zero: turns towards the eye
  bool is_one_sided = false;         ///< visible only from where the normal points to

  /// Area, or length of a line.
  double size() const { return width > 0.0 ? width * height : height; }
};

/// Solid angle, in steradians, of a piece around `middle` for an eye: exact for the upright rectangle that it
/// is. 0 for lines. The same bits on every machine. Source: Van Oosterom and Strackee, The solid angle of a
/// plane triangle, 1983.
double solid_angle(const ObjectPiece& piece, const glm::dvec3& middle, const glm::dvec3& eye);

/// Whether the outside of a piece faces `eye`.
bool faces(const ObjectPiece& piece, const glm::dvec3& middle, const glm::dvec3& eye);

struct SampleOptions {
  double spacing = 1.0;  ///< no piece is higher, or of a wall wider, than this; in the unit of the cloud, > 0
  double width = 0.0;    ///< of vertical segments, which turn it towards the eye; >= 0
  double max_distance = std::numeric_limits<double>::infinity();  ///< not visible from farther away
};

struct SampledObjects {
  std::vector<Observer> objects;    ///< one each: its first corner at the top
  std::vector<Observer> samples;    ///< object by object
  std::vector<ObjectPiece> pieces;  ///< of the samples
};

constexpr std::size_t k_most_object_samples = 1'000'000;

/// Divides objects into equal pieces. The foot of a wall is the straight line between two corners if both
/// have a z, else the ground below each piece. Objects without a name are called "object N", from 1. Errors,
/// naming the source: a height that is missing or not above 0; a coordinate that is not finite or beyond
/// 1e12; no ground below a foot without z; a wall without length; options out of range; more than
/// k_most_object_samples samples. Also: segments without a width beside walls.
SampledObjects sample_objects(const GivenObjects& given, const SampleOptions& options,
                              const GroundHeight& ground);

}  // namespace alidade::visibility
