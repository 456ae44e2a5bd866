// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "simulation/site.h"

namespace alidade::simulation {

/// The position of a terrestrial scanner: the centre of its mirror, world coordinates.
struct Station {
  glm::dvec3 position{0.0};
};

/// A terrestrial laser scanner: the mirror turns about a level axis while the head turns about the vertical
/// one, so beams form a raster of equal steps in azimuth (columns, full circle) and elevation (rows).
struct TerrestrialScanner {
  double elevation_min = -60.0;  ///< degrees; below it the tripod hides the ground
  double elevation_max = 90.0;   ///< degrees
  double range_min = 0.5;        ///< metres
  double range_max = 120.0;      ///< metres
  double range_noise = 0.0015;   ///< standard deviation along the beam, metres
  double seconds = 180.0;        ///< duration of one scan
};

/// A straight flight line. The scanner's mirror turns about the axis of flight and sweeps beams across to
/// both sides of a plane that looks straight down, or ahead by `pitch`.
struct FlightLine {
  glm::dvec3 start{0.0}, end{0.0};  ///< world; at one height, apart
  double pitch = 0.0;               ///< degrees ahead of straight down, (-80, 80)
  double field_of_view = 50.0;      ///< of a sweep from side to side, degrees, (0, 160)
};

struct DroneScanner {
  double range_max = 250.0;    ///< metres
  double range_noise = 0.006;  ///< standard deviation along the beam, metres
  double speed = 6.0;          ///< metres per second
};

struct ScanOptions {
  std::uint64_t point_count = 2'000'000;  ///< the exact number of points of the scan
  std::uint64_t seed = 1;                 ///< of the range noise
  std::vector<Station> stations;
  std::vector<FlightLine> flight_lines;  ///< REQUIRED: at least one, over the site
  double terrestrial_share = 0.65;       ///< of the points from the stations, about; 0 .. 1
  TerrestrialScanner terrestrial;
  DroneScanner drone;
};

/// Called with the next points of a scan. `batch` is on the scan's lattice and is only valid during the call.
using PointSink = std::function<void(const PointCloud& batch)>;

/// A cloud without points that has the values that all batches of a scan share: the lattice (1 mm,
/// offset = the site's origin, which must be whole metres) and the CRS (WGS 84 / UTM zone 32N). For
/// parameter `like` of LasWriter.
PointCloud scan_header(const Site& site);

/// The columns of every batch: color, intensity, classification, returns, scan_angle,
/// point_source_id, gps_time.
AttributeSet scan_attributes();

/// Scans the site from every station, then along every flight line, and hands exactly `point_count` points to
/// `sink`, in batches of some ten thousand in a fixed order, from one thread at a time. Traces in parallel
/// (oneTBB). The points are the same on any number of threads and on any machine.
///
/// The number is exact, and normally no points are dropped: a coarse survey of each station gives the share
/// of its beams that meet something; from it one angular step for all stations is chosen that gives about
/// terrestrial_share of the points. The flight then sends as many beams as points are missing, spread evenly
/// over its lines; further passes replace beams that miss the site, each as large as the share of hits so far
/// suggests. (Surplus points are left out only if the stations alone give more than point_count, with a share
/// of nearly 1 or a handful of points, and after such further passes; courtyard() needs none.)
///
/// Each point lies on its beam, off the surface by the range noise (a sum of eight uniform numbers, so
/// never beyond 5 standard deviations), rounded to the lattice. point_source_id counts stations, then
/// lines, from 1; gps_time increases.
///
/// Errors: no flight line, or one that is not level above the origin; a flight that meets nothing; a point
/// outside the lattice. Throws Cancelled if `progress` ends the scan. Cost: about a microsecond per point on
/// two cores; memory: some 20 MB.
void scan(const Site& site, const ScanOptions& options, const PointSink& sink, const Progress& progress = {});

}  // namespace alidade::simulation
