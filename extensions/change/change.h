// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "base/huge_memory.h"
#include "base/progress.h"
#include "octree/octree.h"
#include "visibility/sight_line.h"

// What has changed between two scans of one site, point by point: a point whose counterpart is missing in the
// other epoch is gone or new only if lines of sight of that epoch pass through its position; otherwise that
// epoch never saw the position.
//
//   const Occluders before(build(old_cloud), {}), after(build(new_cloud), {});
//   const ChangeOptions options{.registration_error = 0.005};
//   const Changes changes = find_changes({before, old_origins}, {after, new_origins}, options);
//   if (changes.before.classes[id] == ChangeClass::gone) ...

namespace alidade::visibility {

// The distance between two surfaces of points along a normal, and how large it must be not to be an effect of
// noise: M3C2 (Lague, Brodu, Leroux 2013, Accurate 3D comparison of complex topography with terrestrial laser
// scanner, ISPRS Journal 82). Each surface is the mean of its points in a cylinder around the normal. Unlike
// there, a cylinder that holds several surfaces gives the mean of one of them.

/// A cylinder around the normal of a point.
struct Cylinder {
  glm::dvec3 center{0.0};          ///< the point; t = 0 on the axis
  glm::dvec3 axis{0.0, 0.0, 1.0};  ///< the normal, of length 1
  double radius = 0.0;             ///< metres, > 0
  double half_length = 0.0;        ///< to either side of the point, metres
  /// Points of one surface lie within this of its mean, metres along the axis, > 0.
  double window = 0.0;
};

/// A surface in a cylinder.
struct CylinderSurface {
  std::size_t count = 0;   ///< points of the surface, at least 1
  double t = 0.0;          ///< their mean along the axis, metres
  double deviation = 0.0;  ///< their standard deviation along the axis, metres; 0 for a single point
  glm::dvec3 middle{0.0};  ///< their mean, world coordinates
};

/// Points that count; empty: all.
using CountedPoints = std::function<bool(std::uint64_t point_id)>;

/// The surface nearest to t on the axis: the mean of the points within the window around the point nearest to
/// t, then of those around this mean, until it no longer changes (at most 8 times). Empty: the cylinder holds
/// no point. The same bits on any machine. Cost: some microseconds, grows with the points in the cylinder.
std::optional<CylinderSurface> nearest_surface(const Octree& octree, const Cylinder& cylinder, double t,
                                               const CountedPoints& counts = {});

/// Levels of detection of fewer points are not reliable.
constexpr std::size_t k_least_cylinder_points = 4;

/// The level of detection with a confidence of 95 % (LoD95): 1.96 (sqrt(s1^2 / n1 + s2^2 / n2) + registration
/// error), metres. A distance that exceeds it is significant. registration_error: standard deviation of the
/// offset between both clouds, metres.
double detection_level(const CylinderSurface& one, const CylinderSurface& other, double registration_error);

/// What the other epoch shows about a point.
enum class ChangeClass : std::uint8_t {
  /// It has the surface: the distance is within the level of detection. If no radius is given, also points
  /// that are as near as those of one scan are to each other.
  same = 0,
  moved = 1,       ///< it has the surface at a significant distance along the normal
  gone = 2,        ///< of BEFORE: lines of sight of AFTER pass through the position
  appeared = 3,    ///< "new", of AFTER: lines of sight of BEFORE pass through the position
  never_seen = 4,  ///< none of its lines of sight passed or met the position: hidden, or out of range
  unmatched = 5,   ///< it has no surface here, and its origins are unknown
  ignored = 6,     ///< the point does not count (OccluderOptions::counts)
  /// The other epoch has points here, but their distance is unknown; PointChanges counts the reasons.
  not_measured = 7,
};
constexpr int k_change_classes = 8;

/// "same", "moved", "gone", "new", "never seen", "unmatched", "ignored", "not measured".
const char* name_of(ChangeClass kind);

/// One scan of the site. `occluders` must outlive it.
struct Epoch {
  const Occluders& occluders;       ///< with surfaces, one crossing blocks, and radii by spacings
  std::vector<glm::dvec3> origins;  ///< where scanners were, world coordinates; empty: unknown
};

struct ChangeOptions {
  double registration_error = 0.0;  ///< standard deviation of the offset between the clouds, metres, >= 0
  /// Radius of the sphere whose points define the normal, metres, > 0. Empty, and if the sphere has too few
  /// points for a plane: the surfaces of surface/point_surface.h, 2.5 spacings of the point.
  std::optional<double> normal_radius{};
  /// Radius of the cylinder, metres, > 0. Empty: twice the spacing (to the 8th neighbour) of the point or, if
  /// it is more, of the nearest point of the other epoch.
  std::optional<double> cylinder_radius{};
  /// A surface within this along the normal has moved, one farther away is another one: metres, > 0. Empty: 3
  /// radii of the cylinder.
  std::optional<double> max_distance{};
  double max_range = std::numeric_limits<double>::infinity();  ///< of the scanners, metres, > 0
  Progress progress{};                                         ///< in points of both clouds
};

/// The findings of one epoch, by point id.
struct PointChanges {
  HugeVector<ChangeClass> classes;
  /// M3C2 distance from BEFORE to AFTER along the normal, metres. Normals point to the scanner, upwards if no
  /// origin is known: added material is positive. NaN for points without a surface or a counterpart.
  HugeVector<float> distances;
  HugeVector<float> detection_levels;  ///< LoD95, metres; NaN if the distance is NaN
  // Numbers of points by the reason why they are not_measured; they add up to that class.
  std::uint64_t without_normal = 0;  ///< their neighbours do not lie on a plane
  std::uint64_t too_few_points = 0;  ///< in their cylinder, of one of the epochs, around the same middle
  /// Points whose sphere of ChangeOptions::normal_radius holds too few points for a normal.
  std::uint64_t wider_normals = 0;
};

struct Changes {
  PointChanges before, after;
};

/// Errors: the bounds of both clouds are farther apart than a tenth of their longest side.
void check_overlap(const Octree& before, const Octree& after);

/// Compares both epochs. Each point is tested in this order:
///
/// 1. Its cylinder holds surfaces of both epochs, k_least_cylinder_points points of each around about the
///    same middle: the M3C2 distance is insignificant, `same`, or not, `moved`. Points count whose
///    own surfaces are parallel to that of the point within 45 degrees; those of one surface lie within a
///    sixth of the cylinder's radius, or 3 thicknesses, of its mean.
/// 2. A point of the other epoch has exactly the same position: `same`, at distance 0.
/// 3. A point of the other epoch is within the larger of both spacings, on the same plane if both points have
///    surfaces: `same`. This step decides for foliage and wires, which have no normal, and for edges.
/// 4. Lines from the other epoch's origins through the point, to the first surface of that epoch. Beyond the
///    point: the line passes, `gone` or `appeared`, if it ends on the side of a surface that was scanned, and
///    points there are dense enough for a beam to have met the point's surface. At the point, or beyond it on
///    its plane, where a line grazes it: `same`. Before the point: hidden. Nothing there, or out of range:
///    unknown. One line that passes decides; if none passes or meets the point, `never_seen`.
///
/// Steps 3 and 4 do not measure a distance: for them a movement by less than a spacing is `same`. So they
/// find `not_measured` instead if a radius of normals or cylinders is given, or if an epoch has too few
/// points for a spacing. They also find `not_measured` instead of `unmatched` if the other epoch has points
/// in the cylinder, or near a point without a normal.
///
/// A line of sight that is free in the cloud of its epoch is taken as proof that the scanner saw along it, so
/// origins must be those of scanners that scan all around.
///
/// The same bits on any number of threads and any instruction set. Errors: an empty cloud, those of
/// check_overlap(), options out of range, origins not finite, other occluders. Memory: 13 B per point, and
/// 8 B in summaries_of(); on the disk if the octree has scratch files. Cost: 10 to 40 microseconds of one
/// thread per point; for points without a counterpart a microsecond more per origin.
Changes find_changes(const Epoch& before, const Epoch& after, const ChangeOptions& options = {});

/// The points of one class of one epoch.
struct ChangeSummary {
  std::uint64_t count = 0;
  std::uint64_t measured = 0;  ///< of these with a distance
  /// Square metres: for each point an 8th of the circle through its 8th neighbour.
  double area = 0.0;
  // Of the points with a distance, metres; empty if there are none.
  std::optional<double> median_distance{}, median_absolute_distance{}, median_detection_level{};
};

/// The summary of each class, in their order. Cost: linear.
std::vector<ChangeSummary> summaries_of(const PointChanges& changes, const Occluders& occluders);

}  // namespace alidade::visibility
