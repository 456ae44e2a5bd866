// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/material.h"
#include "renderer/sampling.h"

// Lambert's law: the same radiance in all directions, f = albedo / pi. Contract of the functions: material.h.

namespace alidade {

inline std::optional<MaterialSample> sample(const Lambertian& material, const Rgb& color,
                                            const glm::dvec3& outgoing, const glm::dvec2& u) {
  glm::dvec3 incoming = sample_cosine_hemisphere(u);
  const double density = pdf_cosine_hemisphere(incoming.z);
  if (density <= 0.0) return std::nullopt;
  if (outgoing.z < 0.0) incoming.z = -incoming.z;
  return MaterialSample{incoming, material.albedo.value_or(color), density, false};
}

inline double pdf(const Lambertian&, const glm::dvec3& outgoing, const glm::dvec3& incoming) {
  return outgoing.z * incoming.z > 0.0 ? pdf_cosine_hemisphere(std::fabs(incoming.z)) : 0.0;
}

inline Rgb eval(const Lambertian& material, const Rgb& color, const glm::dvec3& outgoing,
                const glm::dvec3& incoming) {
  return material.albedo.value_or(color) * static_cast<float>(pdf(material, outgoing, incoming));
}

}  // namespace alidade
