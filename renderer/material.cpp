// SPDX-License-Identifier: MIT
#include "renderer/material.h"

#include "renderer/material_dielectric.h"
#include "renderer/material_lambertian.h"
#include "renderer/material_metal.h"

namespace alidade {

std::optional<MaterialSample> sample(const Material& material, const Rgb& color, const glm::dvec3& outgoing,
                                     const glm::dvec2& u, double u_choice) {
  if (const auto* lambertian = std::get_if<Lambertian>(&material))
    return sample(*lambertian, color, outgoing, u);
  if (const auto* metal = std::get_if<Metal>(&material)) return sample(*metal, color, outgoing, u);
  if (const auto* dielectric = std::get_if<Dielectric>(&material))
    return sample(*dielectric, outgoing, u_choice);
  return std::nullopt;
}

Rgb eval(const Material& material, const Rgb& color, const glm::dvec3& outgoing, const glm::dvec3& incoming) {
  if (const auto* lambertian = std::get_if<Lambertian>(&material))
    return eval(*lambertian, color, outgoing, incoming);
  if (const auto* metal = std::get_if<Metal>(&material)) return eval(*metal, color, outgoing, incoming);
  return Rgb(0.0f);
}

double pdf(const Material& material, const glm::dvec3& outgoing, const glm::dvec3& incoming) {
  if (const auto* lambertian = std::get_if<Lambertian>(&material))
    return pdf(*lambertian, outgoing, incoming);
  if (const auto* metal = std::get_if<Metal>(&material)) return pdf(*metal, outgoing, incoming);
  return 0.0;
}

bool is_specular(const Material& material) {
  if (const auto* metal = std::get_if<Metal>(&material)) return is_mirror(*metal);
  return std::holds_alternative<Dielectric>(material);
}

Rgb albedo(const Material& material, const Rgb& color) {
  if (const auto* lambertian = std::get_if<Lambertian>(&material)) return lambertian->albedo.value_or(color);
  if (const auto* metal = std::get_if<Metal>(&material)) return metal->albedo.value_or(color);
  return Rgb(std::holds_alternative<Dielectric>(material) ? 1.0f : 0.0f);
}

}  // namespace alidade
