// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "base/exact_math.h"
#include "base/ray.h"
#include "simulation/scanner.h"

// Where the beams of a scan go: beam number -> ray. Nothing here looks at the site.

namespace alidade {

/// One emitted beam.
struct Beam {
  Ray ray;                  ///< world, within the scanner's range
  float scan_angle = 0.0f;  ///< degrees: from straight down, as LAS has it
  double seconds = 0.0;     ///< since the scan or flight began
};

/// The raster of a terrestrial scanner. Beam = column * rows + row; columns follow azimuth, rows elevation
/// upwards.
class StationBeams {
 public:
  /// About as many steps per degree in both directions; at least one of each.
  StationBeams(const TerrestrialScanner& scanner, double steps_per_degree);

  std::uint64_t count() const { return columns_ * rows_.size(); }
  std::uint64_t rows() const { return rows_.size(); }
  Beam beam(const Station& station, std::uint64_t index) const;

 private:
  TerrestrialScanner scanner_;
  std::uint64_t columns_ = 1;
  std::vector<SineCosine> rows_;  ///< of the elevation of each row
};

/// `count` beams spread evenly over flight lines: as many on each as the strip it covers is long and wide, in
/// sweeps as far apart as the beams of a sweep.
class FlightBeams {
 public:
  /// `ground_height` is the level the strips are reckoned on; `pass` shifts the sweeps so that a second pass
  /// falls between the first's. Errors: no lines; a line without length; a line not above the ground; pitch
  /// or field of view out of their limits.
  FlightBeams(const DroneScanner& scanner, const std::vector<FlightLine>& lines, double ground_height,
              std::uint64_t count, int pass);

  std::uint64_t count() const { return count_; }
  double seconds() const { return seconds_; }
  /// Index of the line a beam belongs to. Beams are in the order of the lines.
  std::size_t line_of(std::uint64_t index) const;
  Beam beam(std::uint64_t index) const;

 private:
  struct Strip {
    FlightLine line;
    std::uint64_t begin = 0, count = 0;
    double sweeps = 1.0;
    double seconds_begin = 0.0;
    double length = 0.0;
    glm::dvec3 ahead{0.0}, side{0.0}, down{0.0};  ///< of the flight; `down` is tilted by the pitch
  };

  DroneScanner scanner_;
  std::vector<Strip> strips_;
  std::uint64_t count_ = 0;
  double seconds_ = 0.0;
  double shift_ = 0.0;  ///< of the sweeps, in parts of a sweep
};

}  // namespace alidade
