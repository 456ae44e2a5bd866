// SPDX-License-Identifier: MIT
#include "renderer/material.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "renderer/sampling.h"

namespace alidade::renderer {

// Lambert's law: the same radiance in all directions, f = albedo / pi.

static std::optional<MaterialSample> sample(const Lambertian& material, const Rgb& color,
                                            const glm::dvec3& wo, const glm::dvec2& u) {
  glm::dvec3 wi = sample_cosine_hemisphere(u);
  const double density = pdf_cosine_hemisphere(wi.z);
  if (density <= 0.0) return std::nullopt;
  if (wo.z < 0.0) wi.z = -wi.z;
  return MaterialSample{wi, material.albedo.value_or(color), density, false};
}

static double pdf(const Lambertian&, const glm::dvec3& wo, const glm::dvec3& wi) {
  return wo.z * wi.z > 0.0 ? pdf_cosine_hemisphere(std::fabs(wi.z)) : 0.0;
}

static Rgb eval(const Lambertian& material, const Rgb& color, const glm::dvec3& wo, const glm::dvec3& wi) {
  return material.albedo.value_or(color) * static_cast<float>(pdf(material, wo, wi));
}

// Metal as a surface of microfacets, tiny mirrors: GGX distribution of their slopes with alpha = roughness^2,
// Smith's height-correlated shadowing, Schlick's Fresnel term with the albedo as reflectance at normal
// incidence. Only one reflection is computed, so rough metal is a little too dark, never too bright.
//
// Sources: Walter et al., Microfacet Models for Refraction, EGSR 2007; Heitz, Understanding the
// Masking-Shadowing Function, JCGT 2014; visible normals by spherical caps: Dupuy and Benyoub, HPG 2023;
// Schlick 1994.

namespace {

double alpha_of(const Metal& material) {
  return material.roughness * material.roughness;
}

/// Reflectance of a mirror at the cosine of an angle to its normal (Schlick).
Rgb schlick(const Rgb& normal_reflectance, double cosine) {
  const auto away = static_cast<float>(1.0 - std::fmin(1.0, std::fabs(cosine)));
  const float away_sq = away * away;
  return normal_reflectance + (Rgb(1.0f) - normal_reflectance) * (away_sq * away_sq * away);
}

/// Density of the normals of microfacets, per solid angle (GGX).
double distribution(const glm::dvec3& half, double alpha) {
  const double x = half.x / alpha, y = half.y / alpha;
  const double sum = x * x + y * y + half.z * half.z;
  return 1.0 / (k_pi * alpha * alpha * sum * sum);
}

/// Shadowed over visible area of the microfacets, seen from this direction (Smith's Lambda).
double shadowed_share(const glm::dvec3& direction, double alpha) {
  const double tangent_sq =
      (direction.x * direction.x + direction.y * direction.y) / (direction.z * direction.z);
  return 0.5 * (std::sqrt(1.0 + alpha * alpha * tangent_sq) - 1.0);
}

/// The normal of a random microfacet, in proportion to the area that is visible from `wo` (z > 0).
glm::dvec3 visible_normal(const glm::dvec3& wo, double alpha, const glm::dvec2& u) {
  const glm::dvec3 stretched = glm::normalize(glm::dvec3(alpha * wo.x, alpha * wo.y, wo.z));
  const glm::dvec3 cap = sample_cone({1.0 - u.y, u.x}, 1.0 + stretched.z) + stretched;
  return glm::normalize(glm::dvec3(alpha * cap.x, alpha * cap.y, cap.z));
}

/// Density and value of a pair of directions above the surface, without the Fresnel term.
struct Lobe {
  double pdf = 0.0;
  double value = 0.0;  ///< scattering function times cosine
};

Lobe lobe(const glm::dvec3& wo, const glm::dvec3& wi, const glm::dvec3& half, double alpha) {
  const double density = distribution(half, alpha) / (4.0 * wo.z);
  const double shadowed_outgoing = shadowed_share(wo, alpha);
  return {density / (1.0 + shadowed_outgoing),
          density / (1.0 + shadowed_outgoing + shadowed_share(wi, alpha))};
}

/// To the side above the surface and back, if `below`.
glm::dvec3 flipped(const glm::dvec3& direction, bool below) {
  return below ? glm::dvec3(direction.x, direction.y, -direction.z) : direction;
}

}  // namespace

/// Whether the metal is so smooth that it counts as a perfect mirror.
static bool is_mirror(const Metal& material) {
  return alpha_of(material) < 1e-4;
}

static std::optional<MaterialSample> sample(const Metal& material, const Rgb& color, const glm::dvec3& wo,
                                            const glm::dvec2& u) {
  if (wo.z == 0.0) return std::nullopt;
  const Rgb reflectance = material.albedo.value_or(color);
  if (is_mirror(material)) {
    return MaterialSample{{-wo.x, -wo.y, wo.z}, schlick(reflectance, wo.z), 0.0, true};
  }
  const double alpha = alpha_of(material);
  const bool below = wo.z < 0.0;
  const glm::dvec3 view = flipped(wo, below);
  const glm::dvec3 half = visible_normal(view, alpha, u);
  const double cosine = glm::dot(view, half);
  const glm::dvec3 wi = glm::normalize(2.0 * cosine * half - view);
  if (!(wi.z > 0.0)) return std::nullopt;
  const Lobe chosen = lobe(view, wi, half, alpha);
  return MaterialSample{flipped(wi, below),
                        schlick(reflectance, cosine) * static_cast<float>(chosen.value / chosen.pdf),
                        chosen.pdf, false};
}

static Rgb eval(const Metal& material, const Rgb& color, const glm::dvec3& wo, const glm::dvec3& wi) {
  if (is_mirror(material) || !(wo.z * wi.z > 0.0)) return Rgb(0.0f);
  const bool below = wo.z < 0.0;
  const glm::dvec3 view = flipped(wo, below), light = flipped(wi, below);
  const glm::dvec3 half = glm::normalize(view + light);
  return schlick(material.albedo.value_or(color), glm::dot(view, half)) *
         static_cast<float>(lobe(view, light, half, alpha_of(material)).value);
}

static double pdf(const Metal& material, const glm::dvec3& wo, const glm::dvec3& wi) {
  if (is_mirror(material) || !(wo.z * wi.z > 0.0)) return 0.0;
  const bool below = wo.z < 0.0;
  const glm::dvec3 view = flipped(wo, below), light = flipped(wi, below);
  return lobe(view, light, glm::normalize(view + light), alpha_of(material)).pdf;
}

double fresnel_reflectance(double cosine, double index) {
  const double sine_beyond_sq = (1.0 - cosine * cosine) / (index * index);
  if (sine_beyond_sq >= 1.0) return 1.0;
  const double cosine_beyond = std::sqrt(1.0 - sine_beyond_sq);
  const double across = (cosine - index * cosine_beyond) / (cosine + index * cosine_beyond);
  const double parallel = (index * cosine - cosine_beyond) / (index * cosine + cosine_beyond);
  return 0.5 * (across * across + parallel * parallel);
}

// Radiance is not rescaled by the square of the index inside, so light that enters and leaves is unchanged.
static std::optional<MaterialSample> sample(const Dielectric& material, const glm::dvec3& wo,
                                            double u_choice) {
  if (wo.z == 0.0) return std::nullopt;
  const double index = wo.z > 0.0 ? material.refractive_index : 1.0 / material.refractive_index;
  const double cosine = std::fabs(wo.z);
  // Chosen in proportion to its share of the light, either way carries weight 1.
  MaterialSample chosen{{-wo.x, -wo.y, wo.z}, Rgb(1.0f), 0.0, true};
  if (u_choice >= fresnel_reflectance(cosine, index)) {
    const double x = -wo.x / index, y = -wo.y / index;
    const double z = std::sqrt(std::fmax(0.0, 1.0 - x * x - y * y));
    chosen.wi = glm::normalize(glm::dvec3(x, y, wo.z > 0.0 ? -z : z));
  }
  return chosen;
}

std::optional<MaterialSample> sample(const Material& material, const Rgb& color, const glm::dvec3& wo,
                                     const glm::dvec2& u, double u_choice) {
  if (const auto* lambertian = std::get_if<Lambertian>(&material)) return sample(*lambertian, color, wo, u);
  if (const auto* metal = std::get_if<Metal>(&material)) return sample(*metal, color, wo, u);
  if (const auto* dielectric = std::get_if<Dielectric>(&material)) return sample(*dielectric, wo, u_choice);
  return std::nullopt;
}

Rgb eval(const Material& material, const Rgb& color, const glm::dvec3& wo, const glm::dvec3& wi) {
  if (const auto* lambertian = std::get_if<Lambertian>(&material)) return eval(*lambertian, color, wo, wi);
  if (const auto* metal = std::get_if<Metal>(&material)) return eval(*metal, color, wo, wi);
  return Rgb(0.0f);
}

double pdf(const Material& material, const glm::dvec3& wo, const glm::dvec3& wi) {
  if (const auto* lambertian = std::get_if<Lambertian>(&material)) return pdf(*lambertian, wo, wi);
  if (const auto* metal = std::get_if<Metal>(&material)) return pdf(*metal, wo, wi);
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

}  // namespace alidade::renderer
