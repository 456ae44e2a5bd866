// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "cloud/crs.h"
#include "visibility/horizon/skyline.h"
#include "visibility/sky/sun_path.h"

// What the commands of horizon, sky and sun have the module do for them (tools/load_module.h).

namespace alidade {

/// write_skyline() of visibility/horizon/skyline.h. Errors, here and below: those of load_module_function().
using SkylineWriter = void (*)(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                               const SkylineTexts& texts, const std::filesystem::path& file, bool overwrite);
SkylineWriter load_skyline_writer();

/// place_schedule() of visibility/sky/sun_path.h, and its answer.
using SchedulePlacer = bool (*)(const Crs& crs, const glm::dvec2& center,
                                const std::optional<glm::dvec2>& latitude_longitude, SunSchedule& schedule);
SchedulePlacer load_schedule_placer();

/// sun_steps() of visibility/sky/sun_path.h.
using SunStepper = void (*)(const SunSchedule& schedule, const Progress& progress,
                            std::vector<SunStep>& steps);
SunStepper load_sun_stepper();

}  // namespace alidade
