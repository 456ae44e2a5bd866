// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <variant>

#include "base/color.h"

namespace alidade::renderer {

/// Diffuse reflection, equal in all directions. Without an albedo the colour of the hit point is used.
struct Lambertian {
  std::optional<Rgb> albedo;
};

/// Reflects like metal: a perfect mirror at roughness 0, the most blurred one at 1. Without an albedo the
/// colour of the hit point is used.
struct Metal {
  std::optional<Rgb> albedo;
  double roughness = 0.0;
};

/// Smooth, clear glass or water: reflects by Fresnel's equations, refracts the rest by Snell's law.
struct Dielectric {
  double refractive_index = 1.5;  ///< relative to the air around it
};

/// Emits the same radiance in all directions, and reflects nothing.
struct Emissive {
  Rgb radiance{1.0f};
};

/// What a surface does with light; the word in scene files ("type") is the struct's name in lower case.
using Material = std::variant<Lambertian, Metal, Dielectric, Emissive>;

// How a surface scatters light. Directions are unit vectors that LEAVE the surface, in a frame whose z axis
// is the outward normal: `wo` towards the viewer, `wi` towards the light. z < 0 is the inside; opaque
// materials look the same from both sides. `color` is the hit point's linear colour and is used where the
// material has no albedo of its own.

/// A direction a material has chosen.
struct MaterialSample {
  glm::dvec3 wi{0.0, 0.0, 1.0};
  Rgb weight{0.0f};  ///< eval / pdf; for a specular choice the share of light it carries over its probability
  double pdf = 0.0;  ///< per solid angle; 0 for a specular choice, which has no density
  bool specular = false;  ///< mirror or refraction: a single direction, invisible to eval and pdf
};

/// Chooses a direction by three uniform random numbers in [0, 1); empty if the light is absorbed. Never
/// creates energy: the mean weight is at most 1 in each channel.
std::optional<MaterialSample> sample(const Material& material, const Rgb& color, const glm::dvec3& wo,
                                     const glm::dvec2& u, double u_choice);

/// Scattering function TIMES the cosine of `wi`. Zero for specular directions and for emissive surfaces.
Rgb eval(const Material& material, const Rgb& color, const glm::dvec3& wo, const glm::dvec3& wi);

/// Density per solid angle with which `sample` chooses `wi`, specular choices left out.
double pdf(const Material& material, const glm::dvec3& wo, const glm::dvec3& wi);

/// Whether all the material's directions are specular, so that lights need not be sampled.
bool is_specular(const Material& material);

/// The colour that the albedo layer of an image shows: the material's albedo or the hit point's colour, 1 for
/// Dielectric, 0 for Emissive.
Rgb albedo(const Material& material, const Rgb& color);

/// Share of unpolarised light that a smooth boundary reflects; `cosine` >= 0 on the side the light comes
/// from, `index` = refractive index beyond the boundary over the one before it. 1 at total internal
/// reflection. Source: Born and Wolf, Principles of Optics, section 1.5.2.
double fresnel_reflectance(double cosine, double index);

}  // namespace alidade::renderer
