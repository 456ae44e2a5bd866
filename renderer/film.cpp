// SPDX-License-Identifier: MIT
#include "renderer/film.h"

#include <limits>

namespace alidade {

Film::Film(int film_width, int film_height) : width(film_width), height(film_height) {
  const std::size_t count = static_cast<std::size_t>(width) * height;
  constexpr float k_infinity = std::numeric_limits<float>::infinity();
  color.assign(count, Rgb(0.0f));
  alpha.assign(count, 0.0f);
  variance.assign(count, Rgb(0.0f));
  depth.assign(count, k_infinity);
  distance.assign(count, k_infinity);
  normal.assign(count, glm::vec3(0.0f));
  position.assign(count, glm::dvec3(0.0));
  albedo.assign(count, Rgb(0.0f));
  id.assign(count, 0);
}

}  // namespace alidade
