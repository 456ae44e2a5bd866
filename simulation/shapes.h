// SPDX-License-Identifier: MIT
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <variant>
#include <vector>

#include "base/bounds.h"
#include "base/ray.h"

// The exact surfaces an analytic site is made of. All lengths in metres, z up, in the site's own frame (near
// zero). Everything is double; every intersection is a closed form, except the rolling ground's, which is
// solved to rounding.

namespace alidade::simulation::shapes {

struct Sphere {
  glm::dvec3 center{0.0};
  double radius = 1.0;
};

/// An ellipsoid with axes along x, y, z.
struct Ellipsoid {
  glm::dvec3 center{0.0};
  glm::dvec3 radii{1.0};
};

/// The mantle of a cone or cylinder along `axis` (length 1), open at both ends. If `keep` is not zero, only
/// the half with dot(position - base, keep) >= 0: the vault of a passage, for instance.
struct Frustum {
  glm::dvec3 base{0.0};
  glm::dvec3 axis{0.0, 0.0, 1.0};
  double length = 1.0;
  double base_radius = 1.0, top_radius = 1.0;
  glm::dvec3 keep{0.0};
};

/// Flat ring, or disc if inner_radius is 0. `normal` has length 1.
struct Disc {
  glm::dvec3 center{0.0};
  glm::dvec3 normal{0.0, 0.0, 1.0};
  double radius = 1.0;
  double inner_radius = 0.0;
};

/// Solid box; the columns of `axes` are orthonormal.
struct Box {
  glm::dvec3 center{0.0};
  glm::dmat3 axes{1.0};
  glm::dvec3 half_size{0.5};
};

/// A box without its face at +axes[2], seen from either side: the reveal and pane of a window in a wall.
struct Niche {
  Box box;
};

/// A hole in a panel, in the panel's own (u, v) metres. An arched one has a half circle over its width as its
/// top: `max.y` is the crown.
struct Opening {
  glm::dvec2 min{0.0}, max{1.0};
  bool arched = false;
};

/// Rectangle corner + u * u_axis + v * v_axis, 0 <= u <= size.x, 0 <= v <= size.y, without its openings.
/// The axes are orthonormal.
struct Panel {
  glm::dvec3 corner{0.0};
  glm::dvec3 u_axis{1.0, 0.0, 0.0}, v_axis{0.0, 0.0, 1.0};
  glm::dvec2 size{1.0};
  std::vector<Opening> openings;
};

/// Flat convex polygon, corners in order, at least three.
struct Polygon {
  std::vector<glm::dvec3> corners;
};

/// Points with dot(normal, position) <= offset; `normal` has length 1.
struct HalfSpace {
  glm::dvec3 normal{0.0, 0.0, 1.0};
  double offset = 0.0;
};

/// Bounded intersection of half-spaces. `bounds` must enclose it.
struct ConvexSolid {
  std::vector<HalfSpace> sides;
  Bounds bounds;
};

/// One wave of the rolling ground: amplitude * sin(dot(frequency, (x, y)) + phase),
/// frequency in radians per metre.
struct Wave {
  double amplitude = 0.0;
  glm::dvec2 frequency{0.0};
  double phase = 0.0;
};

/// A part of the ground that reports a face number of its own; a rectangle, or the ellipse within it.
struct Patch {
  glm::dvec2 center{0.0}, half_size{1.0};
  bool round = false;
  int face = 0;
};

/// The height field z = fade(x, y) * sum of waves, over |x| <= half_size.x, |y| <= half_size.y.
/// Inside the core (|x| <= core.x, |y| <= core.y) the ground is the plane z = 0; outside it the waves
/// fade in over `fade_width`.
struct Ground {
  glm::dvec2 half_size{60.0, 50.0};
  glm::dvec2 core{30.0, 25.0};
  double fade_width = 25.0;
  std::vector<Wave> waves;
  std::vector<Patch> patches;  ///< later ones lie over earlier ones; where there is none the face is 0
};

/// Height of the ground and its gradient.
struct GroundHeight {
  double height = 0.0;
  glm::dvec2 slope{0.0};
};
GroundHeight height_at(const Ground& ground, const glm::dvec2& position);

using Shape = std::variant<Sphere, Ellipsoid, Frustum, Disc, Box, Niche, Panel, Polygon, ConvexSolid, Ground>;

/// The smallest t in the ray's closed interval at which the ray meets the shape's surface, from either side.
/// The interval must be bounded below; `ray.direction` has length 1. Solids are surfaces: a ray that starts
/// inside meets them from within.
std::optional<double> intersect(const Shape& shape, const Ray& ray);

/// Properties of a shape at a point on it.
struct SurfacePoint {
  glm::dvec3 normal{0.0, 0.0, 1.0};  ///< length 1, outward for solids, to the open side for a niche
  /// Metres on the surface. Box and niche: from the lower corner along the face's two axes; panel: u, v;
  /// ground: x, y; frustum: 0, height along the axis; disc: distance from the centre, 0. Zero for the others.
  glm::dvec2 uv{0.0};
  /// Box and niche: 0 is -x, 1 is +x, ... 5 is +z; convex solid: index of the side; ground: of the patch.
  /// Else 0.
  int face = 0;
};

/// `position` lies on the surface up to rounding, as intersect() gives it.
SurfacePoint surface_at(const Shape& shape, const glm::dvec3& position);

/// A box that encloses the shape.
Bounds bounds_of(const Shape& shape);

/// Largest |height| the ground can reach.
double amplitude_of(const Ground& ground);

/// intersect() for the rolling ground. Over the level core the answer is that of the
/// plane; elsewhere |z - height| <= 1e-12 m holds at the answer, and no earlier crossing is missed: no
/// step is longer than the bound on the ground's curvature proves to be free.
std::optional<double> intersect_ground(const Ground& ground, const Ray& ray);

}  // namespace alidade::simulation::shapes
