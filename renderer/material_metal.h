// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/material.h"

// Metal as a field of tiny mirrors: GGX distribution of their slopes with alpha = roughness^2, Smith's
// height-correlated shadowing, Schlick's Fresnel term with the albedo as reflectance at normal incidence. One
// reflection only, so rough metal is a little dark, never too bright. Contract of the functions: material.h.
//
// Sources: Walter et al., Microfacet Models for Refraction, EGSR 2007; Heitz, Understanding the
// Masking-Shadowing Function, JCGT 2014; visible normals by spherical caps: Dupuy and Benyoub, HPG 2023;
// Schlick 1994.

namespace alidade {

/// Whether it is so smooth that it counts as a perfect mirror.
bool is_mirror(const Metal& material);

std::optional<MaterialSample> sample(const Metal& material, const Rgb& color, const glm::dvec3& outgoing,
                                     const glm::dvec2& u);
Rgb eval(const Metal& material, const Rgb& color, const glm::dvec3& outgoing, const glm::dvec3& incoming);
double pdf(const Metal& material, const glm::dvec3& outgoing, const glm::dvec3& incoming);

}  // namespace alidade
