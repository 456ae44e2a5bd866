// SPDX-License-Identifier: MIT
#include "renderer/material_metal.h"

#include "renderer/sampling.h"

namespace alidade {
namespace {

double alpha_of(const Metal& material) {
  return material.roughness * material.roughness;
}

/// Reflectance of a mirror of this colour seen under this cosine.
Rgb schlick(const Rgb& normal_reflectance, double cosine) {
  const auto away = static_cast<float>(1.0 - std::fmin(1.0, std::fabs(cosine)));
  const float away_sq = away * away;
  return normal_reflectance + (Rgb(1.0f) - normal_reflectance) * (away_sq * away_sq * away);
}

/// Density of mirror normals, per solid angle.
double distribution(const glm::dvec3& half, double alpha) {
  const double x = half.x / alpha, y = half.y / alpha;
  const double sum = x * x + y * y + half.z * half.z;
  return 1.0 / (k_pi * alpha * alpha * sum * sum);
}

/// Smith's Lambda: shadowed over visible area of the mirrors, seen from this direction.
double shadowed_share(const glm::dvec3& direction, double alpha) {
  const double tangent_sq =
      (direction.x * direction.x + direction.y * direction.y) / (direction.z * direction.z);
  return 0.5 * (std::sqrt(1.0 + alpha * alpha * tangent_sq) - 1.0);
}

/// A mirror normal, as often as it is seen from `outgoing` (z > 0).
glm::dvec3 visible_normal(const glm::dvec3& outgoing, double alpha, const glm::dvec2& u) {
  const glm::dvec3 stretched = glm::normalize(glm::dvec3(alpha * outgoing.x, alpha * outgoing.y, outgoing.z));
  const glm::dvec3 cap = sample_cone({1.0 - u.y, u.x}, 1.0 + stretched.z) + stretched;
  return glm::normalize(glm::dvec3(alpha * cap.x, alpha * cap.y, cap.z));
}

/// Density and value of a pair of directions above the surface, without the Fresnel term.
struct Lobe {
  double pdf = 0.0;
  double value = 0.0;  ///< scattering function times cosine
};

Lobe lobe(const glm::dvec3& outgoing, const glm::dvec3& incoming, const glm::dvec3& half, double alpha) {
  const double density = distribution(half, alpha) / (4.0 * outgoing.z);
  const double shadowed_outgoing = shadowed_share(outgoing, alpha);
  return {density / (1.0 + shadowed_outgoing),
          density / (1.0 + shadowed_outgoing + shadowed_share(incoming, alpha))};
}

glm::dvec3 above(const glm::dvec3& direction, bool mirrored) {
  return mirrored ? glm::dvec3(direction.x, direction.y, -direction.z) : direction;
}

}  // namespace

bool is_mirror(const Metal& material) {
  return alpha_of(material) < 1e-4;
}

std::optional<MaterialSample> sample(const Metal& material, const Rgb& color, const glm::dvec3& outgoing,
                                     const glm::dvec2& u) {
  if (outgoing.z == 0.0) return std::nullopt;
  const Rgb reflectance = material.albedo.value_or(color);
  if (is_mirror(material)) {
    return MaterialSample{
        {-outgoing.x, -outgoing.y, outgoing.z}, schlick(reflectance, outgoing.z), 0.0, true};
  }
  const double alpha = alpha_of(material);
  const bool mirrored = outgoing.z < 0.0;
  const glm::dvec3 view = above(outgoing, mirrored);
  const glm::dvec3 half = visible_normal(view, alpha, u);
  const double cosine = glm::dot(view, half);
  const glm::dvec3 incoming = glm::normalize(2.0 * cosine * half - view);
  if (!(incoming.z > 0.0)) return std::nullopt;
  const Lobe chosen = lobe(view, incoming, half, alpha);
  return MaterialSample{above(incoming, mirrored),
                        schlick(reflectance, cosine) * static_cast<float>(chosen.value / chosen.pdf),
                        chosen.pdf, false};
}

Rgb eval(const Metal& material, const Rgb& color, const glm::dvec3& outgoing, const glm::dvec3& incoming) {
  if (is_mirror(material) || !(outgoing.z * incoming.z > 0.0)) return Rgb(0.0f);
  const bool mirrored = outgoing.z < 0.0;
  const glm::dvec3 view = above(outgoing, mirrored), light = above(incoming, mirrored);
  const glm::dvec3 half = glm::normalize(view + light);
  return schlick(material.albedo.value_or(color), glm::dot(view, half)) *
         static_cast<float>(lobe(view, light, half, alpha_of(material)).value);
}

double pdf(const Metal& material, const glm::dvec3& outgoing, const glm::dvec3& incoming) {
  if (is_mirror(material) || !(outgoing.z * incoming.z > 0.0)) return 0.0;
  const bool mirrored = outgoing.z < 0.0;
  const glm::dvec3 view = above(outgoing, mirrored), light = above(incoming, mirrored);
  return lobe(view, light, glm::normalize(view + light), alpha_of(material)).pdf;
}

}  // namespace alidade
