// SPDX-License-Identifier: MIT
#include "visibility/sky/sky_directions.h"

#include <cmath>

#include "base/exact_math.h"
#include "visibility/golden_turn.h"

namespace alidade {
namespace {

glm::dvec3 spiral_direction(int i, double height) {
  const SineCosine turn = sine_cosine_of_turns(golden_turns(i));
  const double run = std::sqrt(1.0 - height * height);
  return {run * turn.sine, run * turn.cosine, height};
}

}  // namespace

std::vector<glm::dvec3> even_sky_directions(int count) {
  std::vector<glm::dvec3> directions;
  directions.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) directions.push_back(spiral_direction(i, (i + 0.5) / count));
  return directions;
}

std::vector<glm::dvec3> cosine_sky_directions(int count) {
  std::vector<glm::dvec3> directions;
  directions.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    directions.push_back(spiral_direction(i, std::sqrt(1.0 - (i + 0.5) / count)));
  return directions;
}

}  // namespace alidade
