// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "base/date_time.h"

namespace alidade {

/// Where on Earth one stands, and the air there.
struct SunObserver {
  double latitude = 0.0;      ///< degrees north, [-90, 90]
  double longitude = 0.0;     ///< degrees east
  double height = 0.0;        ///< metres above the ellipsoid; heights above the sea do as well
  double pressure = 1013.25;  ///< of the air there (not brought down to sea level), hPa = mbar; 0 = no air
  double temperature = 10.0;  ///< of the air, degrees Celsius, above -273
};

/// Where the middle of the sun's disc stands, as seen by the observer and not from the Earth's centre.
struct SunPosition {
  double azimuth = 0.0;              ///< degrees clockwise from true north, [0, 360)
  double elevation = 0.0;            ///< degrees above the horizon, as seen through the air
  double geometric_elevation = 0.0;  ///< the same without refraction
};

/// Within 0.0001 degrees of the published example of NREL's algorithm (Reda and Andreas, Solar Position
/// Algorithm for Solar Radiation Applications, 2003). Good to 0.005 degrees in our times, of which 0.004 are
/// the difference (below 0.9 s since 1972) between UTC and the turning of the Earth; far from them the
/// turning itself is an estimate, see delta_t(). The Earth's orbit is VSOP87 as libnova has it; precession,
/// nutation, aberration, sidereal time as in Meeus, Astronomical Algorithms, 1998, chapters 12, 21, 22, 25;
/// parallax from the observer's place on the WGS 84 ellipsoid; refraction as in NREL's algorithm, none where
/// the upper limb is below the horizon. `terrestrial_minus_universal`: seconds; delta_t() of the year if
/// empty. Not from several threads at once: libnova remembers its last answers.
SunPosition sun_position(const Moment& moment, const SunObserver& observer,
                         std::optional<double> terrestrial_minus_universal = {});

/// Terrestrial minus universal time, seconds, for a year like 2003.8. Source: Espenak and Meeus, Five
/// Millennium Canon of Solar Eclipses, NASA/TP-2006-214141; measured up to 2005, a forecast after it.
double delta_t(double year);

}  // namespace alidade
