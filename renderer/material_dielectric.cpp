// SPDX-License-Identifier: MIT
#include "renderer/material_dielectric.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace alidade {

double fresnel_reflectance(double cosine, double index) {
  const double sine_beyond_sq = (1.0 - cosine * cosine) / (index * index);
  if (sine_beyond_sq >= 1.0) return 1.0;
  const double cosine_beyond = std::sqrt(1.0 - sine_beyond_sq);
  const double across = (cosine - index * cosine_beyond) / (cosine + index * cosine_beyond);
  const double parallel = (index * cosine - cosine_beyond) / (index * cosine + cosine_beyond);
  return 0.5 * (across * across + parallel * parallel);
}

std::optional<MaterialSample> sample(const Dielectric& material, const glm::dvec3& outgoing,
                                     double u_choice) {
  if (outgoing.z == 0.0) return std::nullopt;
  const double index = outgoing.z > 0.0 ? material.refractive_index : 1.0 / material.refractive_index;
  const double cosine = std::fabs(outgoing.z);
  // Chosen in proportion to its share of the light, either way carries weight 1.
  MaterialSample chosen{{-outgoing.x, -outgoing.y, outgoing.z}, Rgb(1.0f), 0.0, true};
  if (u_choice >= fresnel_reflectance(cosine, index)) {
    const double x = -outgoing.x / index, y = -outgoing.y / index;
    const double z = std::sqrt(std::fmax(0.0, 1.0 - x * x - y * y));
    chosen.incoming = glm::normalize(glm::dvec3(x, y, outgoing.z > 0.0 ? -z : z));
  }
  return chosen;
}

}  // namespace alidade
