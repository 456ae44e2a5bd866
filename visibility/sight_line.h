// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "base/error.h"
#include "base/progress.h"
#include "geo/terrain_surface.h"
#include "mesh/triangle_tree.h"
#include "octree/octree.h"
#include "surface/point_surface.h"
#include "surface/surface_cloud.h"

namespace alidade::visibility {

/// The i-th of directions that are spread evenly around a middle, in turns, [0, 1): each is turned by
/// the golden angle, (3 - sqrt 5) / 2 of a turn, from the one before. Source: Vogel, A better way to
/// construct the sunflower head, 1979.
inline double golden_turns(int i) {
  constexpr double k_golden_turn = 0.38196601125010515;
  const double turns = i * k_golden_turn;
  return turns - std::floor(turns);
}

/// To be raised with each change of the answers of sight lines; checkpoints of other versions are rejected.
constexpr int k_answers_version = 10;

// What blocks sight. A point of a surface is a disc: it blocks a line that crosses the plane of its sheet
// (surface/point_surface.h) within a radius of the point. So surfaces keep their thickness, and lines that
// graze flat ground pass over it; spheres would make every surface thicker by their radius. A point without
// a surface (foliage, wires) is a sphere, which blocks a line that passes it within a radius. Discs that
// would reach beyond the edge of their sheet (surface/point_surface.h) are cut off there. A mesh beside the
// points, such as a planned building, and a terrain, the bilinear surface of an elevation raster, are opaque
// from both sides. The cloud may be empty beside them.

enum class OccluderShape {
  automatic,  ///< discs where there is a surface, spheres elsewhere
  disc,       ///< points without a surface do not block
  sphere,     ///< of all points
};

struct OccluderOptions {
  OccluderShape shape = OccluderShape::automatic;
  /// Metres, of all points, > 0. Empty: each point has its own, by its spacing, the distance to its 8th
  /// neighbour: 0.92 of it for a disc, which leaves 0.1 % of a surface open, at most 16 times the
  /// renderer's automatic radius; 0.28 of it for a sphere among discs, and where that exceeds w = 0.35
  /// automatic radii, w^2 divided by it: a stray return is not larger because its neighbours are far away;
  /// 0.5 of it if all are spheres, at most that automatic radius. Discs of a given radius and of the
  /// largest are not cut off at edges.
  std::optional<double> radius{};
  /// Cuts discs and spheres down to this radius: metres, > 0. Empty: as above. Not together with `radius`.
  std::optional<double> radius_max{};
  /// Number of separate crossings that block a line, >= 1: 1 for solid things, more to see through foliage.
  /// Crossings within a point's diameter of the first of them count as one.
  int transparency = 1;
  /// Points that may block; empty: all. Called from many threads at once; must return
  /// the same for the same point.
  std::function<bool(std::uint64_t point_id)> counts{};
  /// Triangles that block as well, at their first crossing whatever the transparency; null: none. The other
  /// options do not apply to them.
  std::shared_ptr<const TriangleTree> mesh{};
  /// A terrain that blocks in the same way; null: none.
  std::shared_ptr<const geo::TerrainSurface> terrain{};
  /// Called before every 16384 lines or chords, on each thread that requests answers; if it returns true,
  /// the request ends with Cancelled. Empty: never.
  std::function<bool()> is_given_up{};
};

/// The cloud, mesh and terrain that block sight. Safe to use from many threads.
class Occluders {
 public:
  /// Measures spacings (of 8 neighbours) and fits surfaces if they are needed and the octree lacks them.
  /// `progress` is in points, the spacings' first, then the surfaces'. Errors: radius, radius_max or
  /// transparency out of range, or both radii. Memory: 12 B per point, of a mapped octree 8 B more.
  /// Cost: 1 to 2 microseconds of one thread per point, in parallel; little for an octree that has them.
  Occluders(const Octree& octree, const OccluderOptions& options, const Progress& progress = {});

  /// These for solid things: transparency 1. They share all that was measured and made.
  Occluders solid() const {
    Occluders occluders = *this;
    occluders.options_.transparency = 1;
    return occluders;
  }

  /// With the spacings and surfaces that were measured.
  const Octree& octree() const { return octree_; }
  /// What lines meet where points have radii of their own; without points otherwise.
  const SurfaceCloud& surfaces() const { return surfaces_; }
  const OccluderOptions& options() const { return options_; }
  /// Errors: Cancelled, by OccluderOptions::is_given_up.
  void check_given_up() const {
    if (options_.is_given_up && options_.is_given_up()) throw Cancelled();
  }
  /// The given radius of all points, or the renderer's automatic one, metres.
  double typical_radius() const { return typical_radius_; }
  /// The largest radius of any disc or sphere, metres, without OccluderOptions::radius_max.
  double largest_radius() const { return largest_radius_; }
  bool has_surfaces() const { return options_.shape != OccluderShape::sphere; }
  /// The surface of a point; none where all are spheres.
  PointSurface surface(std::uint64_t point_id) const {
    return has_surfaces() ? surface_of(octree_.layers(), point_id) : PointSurface{};
  }

 private:
  Octree octree_;
  SurfaceCloud surfaces_;
  OccluderOptions options_;
  double typical_radius_ = 0.0, largest_radius_ = 0.0;
};

// Whether a point is visible from another through the points of a cloud.
//
//   const Occluders occluders(octree, {});
//   const SightEnd tree = end_on_point(occluders, id, position, eye);
//   if (std::optional<Blocker> blocker = first_blocker(occluders, sight_line({eye}, tree))) ...
//
// A line is blocked by discs whose plane it crosses, and by spheres whose middle it passes, in its closed
// interval from end to end, and by triangles of the mesh and by the terrain where it meets them there. What
// an end itself lies on does not block it: discs whose middle is near it and whose plane passes through it
// (SightEnd), spheres that it lies in, triangles whose plane passes within k_mesh_contact of it, and the
// terrain if the plane that touches it at the crossing does so and the line remains within k_mesh_contact of
// its height from there to the end. Such an end is on the terrain's upper side: a line that is below it by
// more than that is blocked.

/// An end lies on a triangle or terrain if its plane passes nearer than this: metres. Coordinates of ends may
/// be rounded to millimetres.
constexpr double k_mesh_contact = 0.001;

/// Nothing nearer to the lone end of a line than this blocks, in radii that the points have or would have as
/// discs: some 1.8 spacings.
constexpr double k_lone_radii = 2.0;

/// One end of a sight line.
struct SightEnd {
  glm::dvec3 position{0.0};
  /// The surface that the end lies on consists of discs whose point is within own_reach (metres), or within 3
  /// of their radii if that is more, and whose plane is within own_thickness (metres), k_sheet_reach of their
  /// own sheet, or error_of_plane(), whichever is most. 0: an end in the air.
  double own_reach = 0.0, own_thickness = 0.0;
  /// A point without a surface among discs, as in foliage or at an edge: what a line meets within
  /// k_lone_radii of it is of the same thing. Applies to SightLine::to alone.
  bool is_lone = false;
  /// The end lies on triangles and terrain whose plane passes nearer than this, metres. 0: where chords of a
  /// line meet, and where a ray ends.
  double mesh_contact = k_mesh_contact;
};

/// An end in the air where chords of a line meet.
inline SightEnd chord_end(const glm::dvec3& position) {
  return {.position = position, .mesh_contact = 0.0};
}

/// A line of sight; made by sight_line() and sight_ray().
struct SightLine {
  SightEnd from, to;                                        ///< `to` does not apply if the line has no end
  glm::dvec3 direction{0.0, 0.0, 1.0};                      ///< of length 1
  double length = std::numeric_limits<double>::infinity();  ///< metres

  bool has_end() const { return length < std::numeric_limits<double>::infinity(); }
};

/// Errors: ends not finite. If both ends are at one position, the line has length 0, and nothing blocks it.
SightLine sight_line(const SightEnd& from, const SightEnd& to);

/// A line in one direction, up to a length in metres. Errors: as make_ray(); length negative or NaN.
SightLine sight_ray(const SightEnd& from, const glm::dvec3& direction,
                    double length = std::numeric_limits<double>::infinity());

/// A point of the cloud as an end: on its sheet, lifted by the sheet's thickness towards the side that
/// `seen_from` is on; where the line grazes the sheet by less than 0.02 (1.1 degrees), upwards. Its own
/// surface consists of the discs whose planes pass within 3 thicknesses, without noise within the precision
/// of the lattice and the arithmetic, so that an exact plane does not hide itself, and whose points are near:
/// within 3 of their radii or, if each has its own, 4 of the typical one. A point without a surface keeps its
/// position. Requires: point_id has this position.
SightEnd end_on_point(const Occluders& occluders, std::uint64_t point_id, const glm::dvec3& position,
                      const glm::dvec3& seen_from);

/// A position on or a little above the ground or a roof as an end: the surface of the nearest point, as far
/// as it passes near the position, is its own. An end in the air if no point is within the typical radius,
/// the nearest has no surface, or all points are spheres. Cost: a microsecond.
SightEnd end_near_surface(const Occluders& occluders, const glm::dvec3& position);

/// Blocker::point_id of a mesh or terrain; no point has it.
constexpr std::uint64_t k_mesh_blocker = std::numeric_limits<std::uint64_t>::max();

/// What blocks a line.
struct Blocker {
  std::uint64_t point_id = 0;  ///< or k_mesh_blocker
  glm::dvec3 position{0.0};    ///< of the point, or where the line meets the mesh or terrain
  /// Metres from the line's start to where it crosses the disc, passes the middle of the sphere or meets the
  /// mesh or terrain.
  double distance = 0.0;

  bool is_mesh() const { return point_id == k_mesh_blocker; }
  bool operator==(const Blocker&) const = default;
};

/// The first point that blocks, in the order of where the line crosses discs and enters spheres (with a given
/// radius, and where all are spheres, of where it passes the points), then by point id; with a transparency
/// of k, the one that makes the k-th separate crossing. The first crossing of the mesh or terrain instead if
/// its distance is smaller. Empty if nothing blocks. Errors: Cancelled.
std::optional<Blocker> first_blocker(const Occluders& occluders, const SightLine& line);

/// first_blocker() of many lines, in parallel, with the same answers on any number of threads and any
/// instruction set. Lines that lie near each other should follow each other. Cost: 0.3 to some microseconds
/// of one thread per line, and as many for a mesh or terrain. Errors: not as many answers as lines;
/// Cancelled.
void first_blockers(const Occluders& occluders, std::span<const SightLine> lines,
                    std::span<std::optional<Blocker>> blockers);

/// Whether lines have a first_blocker(), 1 or 0: faster, but for a transparency above 1. Errors: those of
/// first_blockers().
void blocked(const Occluders& occluders, std::span<const SightLine> lines, std::span<std::uint8_t> answers);

/// Lines of straight chords, one after another, which may overlap.
struct ChordLines {
  std::span<const SightLine> chords;
  std::span<const double> starts;      ///< metres from the start of its line to that of each chord
  std::span<const std::size_t> begin;  ///< first chord of each line, and the end
};

/// first_blocker() of lines of chords. Crossings are counted over all chords of a line, those of one point
/// with two chords as one. Blocker::distance is from the line's start. Cost: that of the chords; with a
/// transparency above 1 two to three times as much. Errors: not as many answers as lines; Cancelled.
void first_blockers(const Occluders& occluders, const ChordLines& lines,
                    std::span<std::optional<Blocker>> blockers);

}  // namespace alidade::visibility
