// SPDX-License-Identifier: MIT
// Any bytes as a weather file: an Error, or a year of finite irradiances.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "base/error.h"
#include "extensions/radiation/weather.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  using namespace alidade::visibility;
  InputFile file(std::as_bytes(std::span(data, size)), "weather.epw");
  try {
    const Weather weather(file);
    for (int hour = 0; hour < 9000; ++hour) {
      const Moment moment{std::chrono::sys_days(std::chrono::days(hour / 24)), 3600.0 * (hour % 24)};
      const HourlyIrradiance& one = weather.at(moment);
      if (!(one.direct_normal >= 0.0 && one.diffuse_horizontal <= 2000.0)) std::abort();
    }
  } catch (const Error&) {
  }
  return 0;
}
