// SPDX-License-Identifier: MIT
// Any bytes as a CSV of observers: an Error, or observers at finite positions with a usable field of view.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "base/error.h"
#include "visibility/read_observers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  using namespace alidade::visibility;
  InputFile file(std::as_bytes(std::span(data, size)), "observers.csv");
  try {
    const std::vector<GivenObserver> given = read_observer_table(file);
    const auto ground = [](const glm::dvec2&) { return std::optional<double>(3.0); };
    for (const Observer& one : place_observers(given, {}, ground)) {
      if (!std::isfinite(one.position.x + one.position.y + one.position.z) &&
          std::fabs(one.position.x) < 1e300)
        std::abort();
      if (one.name.empty() || !FieldOfView(one).contains({0.0, 0.0, 0.0})) std::abort();
    }
  } catch (const Error&) {
  }
  return 0;
}
