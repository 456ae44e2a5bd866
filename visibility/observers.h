// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "base/progress.h"
#include "visibility/sight_line.h"

namespace alidade::visibility {

/// An eye with its field of view.
struct Observer {
  /// The eye, world coordinates: its height above the ground or the mast's foot is in z already.
  glm::dvec3 position{0.0};
  /// How far the eye is above its foot, metres; the foot is at position.z - height.
  double height = 0.0;
  bool stands_on_ground = false;  ///< the foot was put on the ground, its z was not given
  bool is_placed = false;         ///< by place_observers(): neither a camera nor an object
  std::string name;               ///< never empty: "observer 3" if none was given
  /// Field of view, degrees, limits inclusive. Azimuth clockwise from north (+y), from the first
  /// limit to the second: 350 to 10 looks north. A range of 360 or more is the full circle.
  /// Elevation up from the horizontal.
  double azimuth_min = 0.0, azimuth_max = 360.0;
  double elevation_min = -90.0, elevation_max = 90.0;
  /// Nothing farther is seen; metres along the line of sight, inclusive.
  double max_distance = std::numeric_limits<double>::infinity();
};

/// The field of view and reach of an observer, prepared for tests of many directions. Answers are the same on
/// every machine.
class FieldOfView {
 public:
  explicit FieldOfView(const Observer& observer);

  /// Whether the direction `offset` (target minus eye, of any length) lies inside. Straight up and down have
  /// every azimuth; a zero offset is inside.
  bool contains(const glm::dvec3& offset) const;
  /// As contains(), and not farther away than max_distance.
  bool reaches(const glm::dvec3& offset) const;

  /// Whether contains() is true for every direction.
  bool is_everything() const { return all_azimuths_ && all_elevations_; }

 private:
  bool all_azimuths_ = true, all_elevations_ = true;
  double max_distance_sq_ = std::numeric_limits<double>::infinity();
  bool is_wide_ = false;                       ///< more than half of the circle
  glm::dvec2 from_{0.0, 1.0}, to_{0.0, 1.0};   ///< directions of the azimuth limits
  glm::dvec2 low_{1.0, 0.0}, high_{1.0, 0.0};  ///< cosine and sine of the elevation limits
};

/// An observer as given by the user or a file: what was not given is empty.
struct GivenObserver {
  std::string source{};  ///< where it was given, for messages: "observers.csv:3"
  std::string name{};
  glm::dvec2 position{0.0};
  std::optional<double> z{};  ///< of the foot; empty: the ground
  std::optional<double> height{}, azimuth_min{}, azimuth_max{}, elevation_min{}, elevation_max{},
      max_distance{};
};

/// The observer height of gdal_viewshed (-oz), metres.
constexpr double k_usual_observer_height = 2.0;

/// Values for observers that do not give their own.
struct ObserverDefaults {
  /// Height of the eye above the foot; empty: 0 for an observer with a z, height_on_ground for others.
  std::optional<double> height{};
  double height_on_ground = k_usual_observer_height;
  double azimuth_min = 0.0, azimuth_max = 360.0, elevation_min = -90.0, elevation_max = 90.0;
  double max_distance = std::numeric_limits<double>::infinity();
};

/// Height of the ground below a position; empty where no ground is known.
using GroundHeight = std::function<std::optional<double>(const glm::dvec2& position)>;

/// Reads "X,Y,Z" or "X,Y". Errors: anything else, numbers that are not finite.
GivenObserver parse_observer(const std::string& text);

/// Gives every observer its position: z as given or that of the ground, plus the height; what is empty
/// comes from `defaults`. Observers without a name are called "observer N", from 1. `ground` is called only
/// for those without z. Errors, naming the source: a number that is not finite (max_distance may be
/// infinite), a coordinate beyond 1e12, a height or distance below 0, elevations outside [-90, 90] or in
/// the wrong order, azimuths outside [-360, 720], equal, or going backwards by a turn or more; no ground
/// below an observer without z.
std::vector<Observer> place_observers(std::span<const GivenObserver> given, const ObserverDefaults& defaults,
                                      const GroundHeight& ground);

/// Most positions of an observer grid.
constexpr double k_most_grid_observers = 1e6;

/// Candidates for observers: the middles of square cells of this width, where they have ground. The
/// cells cover the extent and share its middle. Row by row from the south-west; named "ROW-COLUMN", from
/// 1. `progress` is in cells. Errors: `width` not above 0 and finite; more than k_most_grid_observers
/// cells; no ground anywhere.
std::vector<GivenObserver> observer_grid(const Bounds& extent, double width, const GroundHeight& ground,
                                         const Progress& progress = {});

/// What a vertical line through an eye meets, metres from the eye: what blocks sight, or a point without a
/// surface within the typical radius of the line, since lines may pass through crowns that are above an eye.
struct Clearance {
  std::optional<double> below{};  ///< 0 for an eye on a surface; empty: nothing is below
  std::optional<double> above{};  ///< the surface that the eye is on left out; empty: nothing is overhead
};

/// Cost: some microseconds.
Clearance clearance_of(const Occluders& occluders, const glm::dvec3& eye);

/// Remarks on observers that are likely mistakes, a sentence each, in their order:
/// - farther outside the cloud and the terrain than these are long, and than 100 metres;
/// - unable to reach them within its max_distance;
/// - below the terrain;
/// - below all points near it (within a square of half side 1, or the first of 2, 4, 8 and 16 that holds
///   points), unless it was put on the ground;
/// - inside the sphere of a point, which then does not block its view;
/// - so near the disc of a point that it hides nearly half of the view, as in scans whose discs are metres
///   wide;
/// - if it was placed: with anything overhead, or with a foot more than 1 above or below what is there
///   (clearance_of()). The remark has the observer to give instead.
/// Of the points, the 16 nearest are tested.
/// Cost: some ten microseconds of one thread each. Errors: Cancelled, by OccluderOptions::is_given_up.
std::vector<std::string> observer_remarks(const Occluders& occluders, std::span<const Observer> observers);

}  // namespace alidade::visibility
