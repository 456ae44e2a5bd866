// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/material.h"

// Smooth clear glass: reflects by Fresnel's equations, refracts the rest by Snell's law. Radiance is not
// rescaled by the square of the index inside, so light that goes in and out again is unchanged. Contract of
// the functions: material.h.

namespace alidade {

/// Share of unpolarised light that a smooth boundary reflects; `cosine` >= 0 on the side the light comes
/// from, `index` = refractive index beyond the boundary over the one before it. 1 at total internal
/// reflection. Source: Born and Wolf, Principles of Optics, section 1.5.2.
double fresnel_reflectance(double cosine, double index);

std::optional<MaterialSample> sample(const Dielectric& material, const glm::dvec3& outgoing, double u_choice);

}  // namespace alidade
