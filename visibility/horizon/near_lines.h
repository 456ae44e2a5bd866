// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "visibility/sight_line.h"

namespace alidade::visibility {

/// Azimuths by their number: azimuth(i) = 360 i / per_turn, clockwise from north. `count` of them from
/// `first` on.
struct AzimuthSteps {
  int per_turn = 1, first = 0, count = 0;

  /// Degrees, [0, 360). i: from 0, in [0, count).
  double azimuth(int i) const { return 360.0 * (((first + i) % per_turn + per_turn) % per_turn) / per_turn; }
};

/// Elevations by their number: elevation(i) = 90 i / per_quarter, from number `low` to `high`.
struct ElevationSteps {
  int per_quarter = 1, low = 0, high = 0;

  double elevation(int step) const { return 90.0 * step / per_quarter; }
};

/// Which lines from an eye may be blocked by points: a table by azimuth and elevation,
/// filled from all points once.
class NearLines {
 public:
  /// Neighbouring elevations share an entry, `steps_together` of them, or more if the table would be larger
  /// than 64 MB. Cost: 100 ns of one thread per point, in parallel.
  NearLines(const Occluders& occluders, const SightEnd& eye, const AzimuthSteps& azimuths,
            const ElevationSteps& elevations, int steps_together);

  /// True only if no point blocks any line of the i-th azimuth between two elevations, inclusive.
  bool are_free(int azimuth, int low, int high) const;

 private:
  class Reaches;
  void mark_around(const glm::dvec3& offset, double reach);
  void mark(int first_azimuth, int last_azimuth, int low, int high);
  int entry_of(int step) const { return (step - elevations_.low) / steps_per_entry_; }

  AzimuthSteps azimuths_;
  ElevationSteps elevations_;
  int steps_per_entry_ = 1;
  std::size_t words_per_azimuth_ = 0;
  std::vector<std::atomic<std::uint64_t>> words_{};  ///< a bit for each entry
};

}  // namespace alidade::visibility
