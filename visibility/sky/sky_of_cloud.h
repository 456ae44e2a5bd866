// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/checkpoint.h"
#include "base/huge_memory.h"
#include "base/progress.h"
#include "geo/raster.h"
#include "visibility/raster/ground.h"
#include "visibility/sky/sky_view.h"
#include "visibility/sky/sun_hours.h"

// Sky and sun of all points of a cloud, and of the ground below it.
//
//   const Occluders occluders(octree, {});
//   const std::vector<float> views = point_sky_views(occluders, columns.normals, {});

namespace alidade::visibility {

/// Progress and checkpoint of long work.
struct LongWork {
  Progress progress{};              ///< in points or cells
  PartCheckpoint* parts = nullptr;  ///< where finished blocks of them are kept; null: nowhere
};

/// Sky-view factor of every point, by point id. `normals` by point id, each pointing out of its surface (of
/// any length; zero: unknown); empty: the open side is found as in sky_views(). Memory: 4 B per point and
/// some 20 MB. Errors: as sky_views; normals not one per point; those of `work.parts`, here and below.
std::vector<float> point_sky_views(const Occluders& occluders, std::span<const glm::vec3> normals,
                                   const SkyViewOptions& options, const LongWork& work = {});

/// What is computed of receivers in the sun, in one or several periods.
class SunMeasure {
 public:
  virtual ~SunMeasure() = default;
  virtual std::size_t periods() const = 0;
  virtual std::size_t numbers() const = 0;  ///< of a target and period
  virtual std::size_t lines() const = 0;    ///< of sight of a target, roughly
  virtual SkyReceiver receiver() const = 0;
  /// Computes the numbers of every target, period by period. `point_ids`: of targets that are points of the
  /// cloud, whose open sides were found; else empty. Results do not depend on earlier calls.
  virtual void answer(std::span<const SkyTarget> targets, std::span<const std::uint64_t> point_ids,
                      std::span<float> answers) = 0;
};

/// sun_hours() as a number.
class SunHoursMeasure : public SunMeasure {
 public:
  /// The references must outlive the object.
  SunHoursMeasure(const Occluders& occluders, const LightOf<SunHours>& light, const SunHoursOptions& options)
      : occluders_(occluders), light_(light), options_(options) {}

  std::size_t periods() const override { return static_cast<std::size_t>(light_.periods); }
  std::size_t numbers() const override { return 1; }
  std::size_t lines() const override { return light_.bins.size() + light_.fans.size(); }
  SkyReceiver receiver() const override { return options_.receiver; }
  void answer(std::span<const SkyTarget> targets, std::span<const std::uint64_t>,
              std::span<float> answers) override {
    sun_hours(occluders_, targets, light_, options_, answers);
  }

 private:
  const Occluders& occluders_;
  const LightOf<SunHours>& light_;
  SunHoursOptions options_;
};

/// The numbers of every point, by point id, as SunMeasure::answer(). The open side of points without a normal
/// is found with find_open_sides(), of 64 directions. Memory: 8 B per number, and some 20 MB. Errors: those
/// of the measure; normals not one per point.
HugeVector<float> point_sun(const Occluders& occluders, std::span<const glm::vec3> normals,
                            SunMeasure& measure, const LongWork& work = {});

/// Sky-view factor in the middle of every cell, `height` above the ground as in a viewshed
/// (visibility/raster/map_targets.h). The receiver is the horizontal, or the slope of the ground across the
/// cell (SkyReceiver::surface), which receives no light from behind; NaN without ground. Memory: 4 B per
/// cell and some 30 MB; check_map_memory() of one band. Errors: as sky_views; height negative or not
/// finite; not enough memory.
geo::Raster<float> ground_sky_views(const Occluders& occluders, const Ground& ground,
                                    const geo::RasterGrid& grid, double height, const SkyViewOptions& options,
                                    const LongWork& work = {});

/// The numbers of every cell, row by row, with receivers as in ground_sky_views(); NaN without ground.
/// Memory: 4 B per number; check_map_memory() of one band more for each period.
HugeVector<float> ground_sun(const Occluders& occluders, const Ground& ground, const geo::RasterGrid& grid,
                             double height, SunMeasure& measure, const LongWork& work = {});

}  // namespace alidade::visibility
