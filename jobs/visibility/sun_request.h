// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/date_time.h"
#include "base/fingerprint.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/visibility/map_request.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/sky_site.h"
#include "jobs/visibility/sun_measure.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/sky/sun_hours.h"
#include "visibility/sky/sun_path.h"

// The request of the job on the sun, and the path and light of the sun that it describes.

namespace alidade::jobs {

/// A date of --from or --to: a whole day, or a moment.
struct SunDate {
  Moment moment;  ///< of a day: its begin in UTC, whatever the location
  bool is_day = false;
};

/// Hours of direct sun of points, of the ground, or at observers, with what an extension adds to them.
struct SunRequest : SkySiteRequest {
  std::optional<SunDate> from, to;
  double step_minutes = 10.0;
  std::optional<glm::dvec2> location;  ///< latitude, longitude
  visibility::SunPeriod period = visibility::SunPeriod::whole;
  std::optional<double> bin;           ///< degrees; 0: none; empty: by the number of steps
  std::optional<double> tilt, aspect;  ///< degrees
  Additions<AddedSunMeasure> measures = make_additions<AddedSunMeasure>();  ///< the first is used
  ObserverRequest observers;
  std::filesystem::path diagram;  ///< empty: none

  bool has_observers() const {
    return !observers.positions.empty() || !observers.file.empty() || observers.grid.has_value();
  }
  visibility::SunHoursOptions hours_options(visibility::SkyReceiver usual) const;
};

/// The path of the sun, and what shines along it.
struct SunSky {
  visibility::SunSchedule schedule;
  bool is_map_known = false;
  double hours = 0.0;        ///< with the sun above the horizon
  double first_hours = 0.0;  ///< of these those of the first period
  std::size_t steps = 0;     ///< with the sun above the horizon
  double bin = 0.0;          ///< degrees
  bool by_horizons = false;
  std::vector<std::string> periods;
  std::unique_ptr<SunShine> shine;
};

/// Declares all fields.
void add_sun_fields(const Fields& fields, SunRequest& request);

/// The sun over a site, as one stage. `targets`: the number of receivers, if they are few: every step is
/// then computed exactly, without bins, up to 10^7 lines of sight. Errors: as place_schedule(), sun_steps(),
/// sun_periods(), and those of the measure.
SunSky sun_of(const SunRequest& request, const VisibilityCloud& cloud, Listener& listener,
              std::optional<std::size_t> targets = {});

/// Notes where and how long the sun is up, and what shines; warns of what is unusual.
void say_sun(const SunSky& sun, Listener& listener);

/// The settings and steps of the sun, for the metadata of a map.
MapMetadata sun_metadata(const SunRequest& request, const SunSky& sun);

/// Adds what answers depend on beside the site.
void add_to_fingerprint(const SunSky& sun, Fingerprint& fingerprint);

/// The quantities that the job writes.
std::span<const SunQuantity> sun_quantities(const SunRequest& request);

}  // namespace alidade::jobs
