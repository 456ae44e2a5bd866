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

#include "jobs/additions.h"
#include "jobs/listener.h"
#include "jobs/visibility/map_request.h"
#include "visibility/sky/sky_of_cloud.h"

// What the job on the sun computes along the path of the sun: hours, or what an extension adds to them.

namespace alidade::jobs {

/// A value that goes into files.
struct SunQuantity {
  const char* name;
  const char* unit;
  const char* text;
  float (*value)(const float* numbers);  ///< of the numbers of a receiver and period
};

/// What shines along the path of the sun, in one run of the job. Called in this order.
class SunShine {
 public:
  virtual ~SunShine() = default;

  /// Completes the schedule. `location`, latitude and longitude: may be set if it is empty.
  virtual void begin(visibility::SunSchedule&, std::optional<glm::dvec2>&) {}
  /// The path that was computed from the schedule.
  virtual void set_path(const visibility::SunSchedule& schedule, std::span<const visibility::SunStep> steps,
                        int periods, const visibility::LightOptions& options) = 0;
  /// Lines of sight, or horizons, of every receiver.
  virtual std::size_t directions() const = 0;
  /// Notes and warns of what shines, if someone is listening.
  virtual void note(Listener&) const {}
  virtual void warn(const visibility::SunSchedule&, Listener&) const {}
  /// Everything that answers depend on beside the fields.
  virtual std::vector<double> fingerprint() const = 0;
  /// Adds to the metadata of outputs, whose last one is the location.
  virtual void add_metadata(MapMetadata&) const {}
  /// What is computed of receivers. `cell`: width of the cells of a map; 0: none. All references must outlive
  /// the result.
  virtual std::unique_ptr<visibility::SunMeasure> measure(const visibility::Occluders& occluders,
                                                          const visibility::SunHoursOptions& options,
                                                          double cell) const = 0;
};

/// What an extension computes instead of hours alone.
class AddedSunMeasure : public Addition {
 public:
  /// Errors that need no file.
  virtual void check() const {}
  /// A file that is read; empty: none.
  virtual std::filesystem::path input() const { return {}; }
  /// The first is hours.
  virtual std::span<const SunQuantity> quantities() const = 0;
  virtual std::unique_ptr<SunShine> shine() const = 0;
};

/// Hours of direct sun alone.
std::span<const SunQuantity> quantity_of_hours();
std::unique_ptr<SunShine> shine_of_hours();

/// Appends bins, fans and sums without obstructions; put_sums(sums, numbers) appends sums.
template <class Sums, class Put>
void append_light(const visibility::LightOf<Sums>& light, const Put& put_sums, std::vector<double>& numbers) {
  for (const auto& bin : light.bins) {
    numbers.insert(numbers.end(), {bin.direction.x, bin.direction.y, bin.direction.z});
    for (const auto& share : bin.shares) {
      numbers.push_back(share.period);
      put_sums(share.sums, numbers);
    }
  }
  for (const auto& fan : light.fans) {
    numbers.insert(numbers.end(), {fan.direction.x, fan.direction.y});
    for (const auto& share : fan.shares) {
      numbers.push_back(share.period);
      numbers.insert(numbers.end(), share.slopes.begin(), share.slopes.end());
      for (const Sums& sums : share.sums) put_sums(sums, numbers);
    }
  }
  for (const Sums& sums : light.open) put_sums(sums, numbers);
}

}  // namespace alidade::jobs
