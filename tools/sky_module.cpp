// SPDX-License-Identifier: MIT
#include "tools/sky_module.h"

#include "tools/load_module.h"

namespace alidade {

SkylineWriter load_skyline_writer() {
  return load_module_function<SkylineWriter>("alidade_write_skyline");
}

SchedulePlacer load_schedule_placer() {
  return load_module_function<SchedulePlacer>("alidade_place_schedule");
}

SunStepper load_sun_stepper() {
  return load_module_function<SunStepper>("alidade_sun_steps");
}

}  // namespace alidade
